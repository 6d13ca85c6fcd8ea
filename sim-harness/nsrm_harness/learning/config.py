"""The trainer's configuration: a TOML file over the defaults that stand here."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Annotated, Any, Final, Literal

from pydantic import Field

from nsrm_harness.common.errors import HarnessError
from nsrm_harness.common.toml_file import (
    NO_OTHER_KEYS,
    Count,
    CountOrZero,
    Flag,
    Positive,
    PositiveOrZero,
    Whole,
    checked,
    read_toml,
)
from nsrm_harness.learning.objective import LossWeights

EXACT: Final = "exact"
REINFORCE: Final = "reinforce"
GUMBEL: Final = "gumbel"

QUICK_CONFIG = Path(__file__).resolve().parent / "quick.toml"
"""Of a miniature training."""


class ConfigError(HarnessError):
    """A configuration that cannot be read or does not make sense."""


@dataclass(frozen=True)
class StageConfig:
    """One stage of the curriculum (section IV-F)."""

    __pydantic_config__ = NO_OTHER_KEYS

    epochs: CountOrZero
    """Passes over the stage's episodes."""
    learning_rate: Positive
    """Adam's, at the start; it falls to a twentieth along a cosine."""
    batch: Count
    """Episodes in a step of the optimiser."""


@dataclass(frozen=True)
class TrainingConfig:
    """Everything that a training run depends on, apart from data and seed."""

    __pydantic_config__ = NO_OTHER_KEYS

    temperature: Positive = 0.05
    """τ of the soft minimum over choices; from 0.1 on actions merge."""
    loss: LossWeights = field(default_factory=lambda: LossWeights(square=200.0, overlap=1.0))
    polish_loss: LossWeights = field(default_factory=lambda: LossWeights(5000.0, 1.0))
    """For the last stage, which is about millimetres."""
    polish_cap: Positive = 3.0
    """Most that one object adds there. More means that a choice is wrong, or that a block is
    hidden: a handful of those outweighs all others in the squared error."""
    attempts: Count = 4
    """How often the first stage is begun, at most. With few episodes about one start in four learns
    two actions as one; the model's own answers to the domain's phrases show it."""
    exploration: Positive = 0.8
    """Share of the actions' probability that is spread evenly when learning begins."""
    failed_split: Positive = 2.0
    """Loss of a split that leaves a step without two objects."""
    indecision: Positive = 0.02
    """Weight of the entropy over splits: of several that do equally well one is to be preferred."""
    unusual_end: Positive = 0.05
    """Loss that a split has for each token between it and the end that the first step has if it
    ends as sentences do. Many splits do equally well: a word that joins two steps may be either's,
    and between two habits the splitter would be sure of neither."""
    nonsense: Positive = 0.05
    """Weight of steps that say nothing, of which the parser is to be sure of no action. The soft
    minimum weighs what a sentence says with τ: the same for both."""
    split_gradient: Literal["exact", "reinforce"] = EXACT
    """How the splitter learns: "exact", from the soft minimum over splits, or "reinforce", from
    splits that it draws itself (section IV-E)."""
    split_samples: Annotated[Whole, Field(ge=2)] = 8
    """With "reinforce": how many it draws of a command. One has no other to be compared with."""
    split_spread: PositiveOrZero = 0.3
    """With "reinforce": weight of the entropy at the start; it falls to nothing in the first half
    of the splitter's stage."""
    action_gradient: Literal["exact", "gumbel"] = EXACT
    """How actions learn what they are: "exact", from the soft minimum over them, or "gumbel", from
    straight-through samples as objects do."""
    residual: Flag = True
    """Whether the simulator's output is added to where the reference is. A model without cannot be
    exported."""
    splits: Count = 3
    """How many of the likeliest splits joint training carries out."""
    actions: StageConfig = StageConfig(epochs=30, learning_rate=3e-3, batch=32)
    """(a) One step, one attribute in each description; every choice summed out."""
    selection: StageConfig = StageConfig(epochs=20, learning_rate=1e-3, batch=32)
    """(a) The same episodes; objects by straight-through Gumbel samples."""
    attributes: StageConfig = StageConfig(epochs=8, learning_rate=1e-3, batch=32)
    """(b) One step, any description; the simulator is frozen."""
    splitter: StageConfig = StageConfig(epochs=20, learning_rate=2e-3, batch=32)
    """(c) The splitter alone, on a table of losses of every split."""
    joint: StageConfig = StageConfig(epochs=8, learning_rate=3e-4, batch=32)
    """(d) Everything, on one and two steps."""
    simulator: StageConfig = StageConfig(epochs=800, learning_rate=5e-3, batch=256)
    """(e) The simulator alone, on the model's own choices."""
    perception: StageConfig = StageConfig(epochs=16, learning_rate=2e-3, batch=64)
    """(f) Perception alone, on the model's own choices as far as final scenes confirm them: they
    fit what is said and nothing else in the scene does."""
    parser: StageConfig = StageConfig(epochs=64, learning_rate=2e-3, batch=256)
    """(g) Parser and splitter, on their own choices as far as final scenes confirm them: alone, put
    together, with fillers, and on steps that say nothing or what no program has. Half of a batch
    are steps that follow."""
    explained: Positive = 0.1
    """Greatest loss of a final scene that confirms the choices."""
    nonsense_parser: Positive = 1.0
    """`nonsense` there."""

    @property
    def sample_actions(self) -> bool:
        """Whether actions are sampled, not summed out."""
        return self.action_gradient == GUMBEL


def read_config(path: Path | None) -> TrainingConfig:
    """The configuration of a file, or the defaults; unknown keys and wrong types are refused."""
    if path is None:
        return TrainingConfig()
    document = read_toml(path, ConfigError, "configuration")
    filled = _over(asdict(TrainingConfig()), document)
    return checked(TrainingConfig, filled, str(path), ConfigError)


def _over(defaults: dict[str, Any], given: dict[str, Any]) -> dict[str, Any]:
    """The defaults with what is given; a table that is given in part keeps the rest of its own."""
    both = dict(defaults)
    for key, value in given.items():
        old = defaults.get(key)
        if isinstance(old, dict) and isinstance(value, dict):
            both[key] = _over(old, value)
        else:
            both[key] = value
    return both
