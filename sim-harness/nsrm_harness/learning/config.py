"""The trainer's configuration: defaults, which a TOML file can override."""

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
from nsrm_harness.learning.objective import LossWeights, Objective

EXACT: Final = "exact"
REINFORCE: Final = "reinforce"
GUMBEL: Final = "gumbel"

QUICK_CONFIG = Path(__file__).resolve().parent / "quick.toml"
"""Configuration of a reduced training."""


class ConfigError(HarnessError):
    """A configuration that cannot be read or is invalid."""


@dataclass(frozen=True)
class StageConfig:
    """One stage of the curriculum (section IV-F)."""

    __pydantic_config__ = NO_OTHER_KEYS

    epochs: CountOrZero
    """Passes over the stage's episodes."""
    learning_rate: Positive
    """Adam's learning rate at the start; it decays to a twentieth along a cosine."""
    batch: Count
    """Episodes per optimiser step."""


@dataclass(frozen=True)
class TrainingConfig:
    """Everything that a training run depends on, except data and seed."""

    __pydantic_config__ = NO_OTHER_KEYS

    temperature: Positive = 0.05
    """τ of the soft minimum over choices; from 0.1 on, actions merge."""
    loss: LossWeights = field(default_factory=lambda: LossWeights(square=200.0, overlap=1.0))
    polish_loss: LossWeights = field(default_factory=lambda: LossWeights(5000.0, 1.0))
    """Loss weights of the last stage, where millimetres matter."""
    polish_cap: Positive = 3.0
    """Largest loss of one object there. More means that a choice is wrong, or that a block is
    hidden: a few of those would dominate the squared error."""
    attempts: Count = 4
    """Largest number of attempts at the first stage. With few episodes, about one start in four
    learns two actions as one, which the model's own answers to the domain's phrases show."""
    exploration: Positive = 0.8
    """Share of the action probability that is uniform at the start of training."""
    failed_split: Positive = 2.0
    """Loss of a split that leaves a step without two objects."""
    indecision: Positive = 0.02
    """Weight of the entropy over splits, so that one of several equally good splits
    is preferred."""
    unusual_end: Positive = 0.05
    """Loss of a split per token between it and the usual end of the first step, the end that
    sentences have. Many splits are equally good, since a word that joins two steps may belong to
    either; without a preference the splitter would be sure of none."""
    nonsense: Positive = 0.05
    """Weight of meaningless steps, for which the parser must be sure of no action. The soft minimum
    weights what a sentence says with τ: the same for both."""
    split_gradient: Literal["exact", "reinforce"] = EXACT
    """How the splitter is trained: "exact", by the soft minimum over splits, or "reinforce", by
    sampled splits (section IV-E)."""
    split_samples: Annotated[Whole, Field(ge=2)] = 8
    """With "reinforce": samples per command, at least two, which are compared with each other."""
    split_spread: PositiveOrZero = 0.3
    """With "reinforce": initial weight of the entropy; it decays to zero in the first half of the
    splitter's stage."""
    action_gradient: Literal["exact", "gumbel"] = EXACT
    """How actions are trained: "exact", by the soft minimum over them, or "gumbel", by
    straight-through samples, like objects."""
    residual: Flag = True
    """Whether the simulator's output is added to the reference's location. A model without it
    cannot be exported."""
    splits: Count = 3
    """Number of most likely splits that joint training evaluates."""
    actions: StageConfig = StageConfig(epochs=30, learning_rate=3e-3, batch=32)
    """(a) One step, one attribute per description; every choice is marginalised."""
    selection: StageConfig = StageConfig(epochs=20, learning_rate=1e-3, batch=32)
    """(a) The same episodes, with objects by straight-through Gumbel samples."""
    attributes: StageConfig = StageConfig(epochs=8, learning_rate=1e-3, batch=32)
    """(b) One step, any description; the simulator is frozen."""
    splitter: StageConfig = StageConfig(epochs=20, learning_rate=2e-3, batch=32)
    """(c) Only the splitter, on a table of the losses of all splits."""
    joint: StageConfig = StageConfig(epochs=8, learning_rate=3e-4, batch=32)
    """(d) Everything, on one and two steps."""
    simulator: StageConfig = StageConfig(epochs=800, learning_rate=5e-3, batch=256)
    """(e) Only the simulator, on the model's own choices."""
    perception: StageConfig = StageConfig(epochs=16, learning_rate=2e-3, batch=64)
    """(f) Only perception, on the model's own choices where final scenes confirm them: the chosen
    objects must match their descriptions, and no others in the scene."""
    parser: StageConfig = StageConfig(epochs=64, learning_rate=2e-3, batch=256)
    """(g) Parser and splitter, on their own choices where final scenes confirm them: single steps,
    combined steps, steps with fillers, and steps that are meaningless or that no program contains.
    Half of a batch are steps that follow another one."""
    explained: Positive = 0.1
    """Largest loss of a final scene that confirms the choices."""
    nonsense_parser: Positive = 1.0
    """`nonsense` in stage (g)."""

    @property
    def objective(self) -> Objective:
        """The loss of the stages (a), (b) and (d)."""
        return Objective(self.loss, self.temperature, self.action_gradient == GUMBEL)


def read_config(path: Path | None) -> TrainingConfig:
    """Reads a file, or returns the defaults; rejects unknown keys and wrong types."""
    if path is None:
        return TrainingConfig()
    document = read_toml(path, ConfigError, "configuration")
    filled = _over(asdict(TrainingConfig()), document)
    return checked(TrainingConfig, filled, str(path), ConfigError)


def _over(defaults: dict[str, Any], given: dict[str, Any]) -> dict[str, Any]:
    """Merges the given values into the defaults, table by table."""
    both = dict(defaults)
    for key, value in given.items():
        old = defaults.get(key)
        if isinstance(old, dict) and isinstance(value, dict):
            both[key] = _over(old, value)
        else:
            both[key] = value
    return both
