"""The trainer's configuration: a TOML file over the defaults that stand here."""

from __future__ import annotations

import dataclasses
import math
import tomllib
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from nsrm_harness.common.errors import HarnessError
from nsrm_harness.learning.objective import LossWeights

EXACT, REINFORCE, GUMBEL = "exact", "reinforce", "gumbel"
CHOICES = {"split_gradient": (EXACT, REINFORCE), "action_gradient": (EXACT, GUMBEL)}
"""Keys whose values are words, and which."""
LEAST = {"epochs": 0, "square": 0, "overlap": 0, "split_spread": 0, "split_samples": 2}
"""Least values of numbers; all others are above 0. One sample has no other to be compared with."""


QUICK_CONFIG = Path(__file__).resolve().parent / "quick.toml"
"""Of a miniature training."""


class ConfigError(HarnessError):
    """A configuration that cannot be read or does not make sense."""


@dataclass(frozen=True)
class StageConfig:
    """One stage of the curriculum (section IV-F)."""

    epochs: int
    """Passes over the stage's episodes."""
    learning_rate: float
    """Adam's, at the start; it falls to a twentieth along a cosine."""
    batch: int
    """Episodes in a step of the optimiser."""


@dataclass(frozen=True)
class TrainingConfig:
    """Everything that a training run depends on, apart from data and seed."""

    temperature: float = 0.05
    """τ of the soft minimum over choices; from 0.1 on actions merge."""
    loss: LossWeights = field(default_factory=lambda: LossWeights(square=200.0, overlap=1.0))
    polish_loss: LossWeights = field(default_factory=lambda: LossWeights(5000.0, 1.0))
    """For the last stage, which is about millimetres."""
    polish_cap: float = 3.0
    """Most that one object adds there. More means that a choice is wrong, or that a block is
    hidden: a handful of those outweighs all others in the squared error."""
    attempts: int = 4
    """How often the first stage is begun, at most. With few episodes about one start in four learns
    two actions as one; the model's own answers to the domain's phrases show it."""
    exploration: float = 0.8
    """Share of the actions' probability that is spread evenly when learning begins."""
    failed_split: float = 2.0
    """Loss of a split that leaves a step without two objects."""
    indecision: float = 0.02
    """Weight of the entropy over splits: of several that do equally well one is to be preferred."""
    unusual_end: float = 0.05
    """Loss that a split has for each token between it and the end that the first step has if it
    ends as sentences do. Many splits do equally well: a word that joins two steps may be either's,
    and between two habits the splitter would be sure of neither."""
    nonsense: float = 0.05
    """Weight of steps that say nothing, of which the parser is to be sure of no action. The soft
    minimum weighs what a sentence says with τ: the same for both."""
    split_gradient: str = EXACT
    """How the splitter learns: "exact", from the soft minimum over splits, or "reinforce", from
    splits that it draws itself (section IV-E)."""
    split_samples: int = 8
    """With "reinforce": how many it draws of a command."""
    split_spread: float = 0.3
    """With "reinforce": weight of the entropy at the start; it falls to nothing in the first half
    of the splitter's stage."""
    action_gradient: str = EXACT
    """How actions learn what they are: "exact", from the soft minimum over them, or "gumbel", from
    straight-through samples as objects do."""
    residual: bool = True
    """Whether the simulator's output is added to where the reference is. A model without cannot be
    exported."""
    splits: int = 3
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
    explained: float = 0.1
    """Greatest loss of a final scene that confirms the choices."""
    nonsense_parser: float = 1.0
    """`nonsense` there."""

    @property
    def sample_actions(self) -> bool:
        """Whether actions are sampled, not summed out."""
        return self.action_gradient == GUMBEL


def read_config(path: Path | None) -> TrainingConfig:
    """The configuration of a file, or the defaults; unknown keys and wrong types are refused."""
    if path is None:
        return TrainingConfig()
    try:
        document = tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise ConfigError(f"{path}: cannot read the configuration: {error}") from error
    return _filled(TrainingConfig(), document, f"{path}: ")


def _filled(default: Any, values: dict[str, Any], where: str) -> Any:
    """`default` with the values of a table; nested tables fill nested dataclasses."""
    changes: dict[str, Any] = {}
    for key, value in values.items():
        if key not in {entry.name for entry in dataclasses.fields(default)}:
            known = ", ".join(sorted(entry.name for entry in dataclasses.fields(default)))
            raise ConfigError(f"{where}{key}: unknown key; expected some of: {known}")
        old = getattr(default, key)
        if dataclasses.is_dataclass(old):
            if not isinstance(value, dict):
                raise ConfigError(f"{where}{key}: expected a table, got {value!r}")
            changes[key] = _filled(old, value, f"{where}{key}.")
            continue
        if isinstance(old, bool):
            if not isinstance(value, bool):
                raise ConfigError(f"{where}{key}: expected true or false, got {value!r}")
            changes[key] = value
            continue
        if isinstance(old, str):
            if value not in CHOICES[key]:
                expected = " or ".join(map(repr, CHOICES[key]))
                raise ConfigError(f"{where}{key}: expected {expected}, got {value!r}")
            changes[key] = value
            continue
        kinds = (int,) if isinstance(old, int) else (int, float)
        if not isinstance(value, kinds) or isinstance(value, bool):
            raise ConfigError(f"{where}{key}: expected a number like {old}, got {value!r}")
        if not math.isfinite(value):
            raise ConfigError(f"{where}{key}: expected a finite number, got {value}")
        least = LEAST.get(key, 1e-9)
        if value < least:
            raise ConfigError(f"{where}{key}: {value} is too small")
        changes[key] = type(old)(value)
    return dataclasses.replace(default, **changes)
