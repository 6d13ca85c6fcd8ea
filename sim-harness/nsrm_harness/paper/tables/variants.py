"""Defines what the models of the tables are compared with: other trainings, other data, and
disturbed scenes."""

from __future__ import annotations

from dataclasses import dataclass, replace

from nsrm_harness.data.disturbance import Disturbance
from nsrm_harness.data.generate import Settings
from nsrm_harness.learning.config import GUMBEL, REINFORCE, StageConfig, TrainingConfig
from nsrm_harness.paper.tables.study import QUICK, Study

BEFORE_LAST = "perception"
"""The second to last stage."""
JUDGED = ("test", "steps_3")
"""The splits on which variants are judged."""
DATA_SIZES = (500, 1000, 5000, 10000)
"""Numbers of training episodes, in addition to the study's."""
DISTURBED, UNDISTURBED = "disturbed", "none"
VARIED = Disturbance(camera_m=0.01, camera_deg=1.0, light=0.3, color=0.2, depth_m=0.01)
"""The disturbances at size 1."""
TRAIN_VARIED = "train_varied"
"""Training data with all disturbances up to size 1."""
SIZES = (0.5, 1.0, 2.0)
KINDS = {
    "camera": ("camera_m", "camera_deg"),
    "light": ("light",),
    "colors": ("color",),
    "depth noise": ("depth_m",),
    "all at once": ("camera_m", "camera_deg", "light", "color", "depth_m"),
}
"""The disturbances that each kind scales."""


@dataclass(frozen=True)
class Variant:
    """A training to compare with."""

    name: str
    config: TrainingConfig
    seeds: tuple[int, ...]
    train: str = "train"
    """Name of the data file."""
    before_last: bool = False
    """Whether the model is also judged as it was before the last stage."""

    @property
    def folder(self) -> str:
        """Its name as a folder name."""
        return self.name.replace(" ", "-").replace(",", "")


EXACT, SAMPLED = "exact splits", "REINFORCE"


def variants(study: Study) -> list[Variant]:
    """All variants, in the order of the report; a quick study has one."""
    config, seeds = study.config, study.seeds
    if study.name == QUICK:
        return [Variant("no joint training", replace(config, joint=_none(config.joint)), seeds)]
    two, five = seeds[:2], (*seeds, *range(max(seeds) + 1, max(seeds) + 3))
    return [
        Variant(EXACT, config, five, before_last=True),
        Variant(SAMPLED, replace(config, split_gradient=REINFORCE), five, before_last=True),
        Variant("no curriculum", _at_once(config), two),
        Variant("sampled actions", replace(config, action_gradient=GUMBEL), two),
        Variant("no residual", replace(config, residual=False), two),
        Variant("no joint training", replace(config, joint=_none(config.joint)), two),
        Variant("no polishing", replace(config, simulator=_none(config.simulator)), two),
        *(Variant(f"{size} episodes", config, seeds[:1], f"train_{size}") for size in DATA_SIZES),
        Variant("varied training", config, seeds[:1], TRAIN_VARIED),
    ]


def _none(stage: StageConfig) -> StageConfig:
    return replace(stage, epochs=0)


def _at_once(config: TrainingConfig) -> TrainingConfig:
    """Starts with the joint stage, with the epochs and the learning rate of the stages it
    replaces."""
    stages = (config.actions, config.selection, config.attributes)
    joint = replace(
        config.joint,
        epochs=config.joint.epochs + sum(stage.epochs for stage in stages),
        learning_rate=config.actions.learning_rate,
    )
    actions, selection, attributes = map(_none, stages)
    return replace(
        config,
        actions=actions,
        selection=selection,
        attributes=attributes,
        splitter=_none(config.splitter),
        joint=joint,
    )


@dataclass(frozen=True)
class DisturbedSet:
    """Episodes with one kind of disturbance at one size; size 0 means none."""

    kind: str
    size: float
    settings: Settings

    @property
    def name(self) -> str:
        """Name of the data file."""
        return f"{DISTURBED}_{self.kind.replace(' ', '_')}_{self.size:g}"


def training_sets(study: Study) -> dict[str, Settings]:
    """Settings of the training data of variants, in addition to the study's."""
    train = study.settings("train")
    sizes = {f"train_{size}": replace(train, count=size) for size in DATA_SIZES}
    return sizes | {TRAIN_VARIED: replace(train, disturbance=VARIED)}


def disturbed_sets(study: Study) -> list[DisturbedSet]:
    """The disturbed sets, all with the same scenes and sentences."""
    none = study.settings(DISTURBED)
    kinds, sizes = (KINDS, SIZES) if study.name != QUICK else ({"camera": KINDS["camera"]}, (1.0,))
    return [DisturbedSet(UNDISTURBED, 0.0, none)] + [
        DisturbedSet(kind, size, replace(none, disturbance=_sized(names, size)))
        for kind, names in kinds.items()
        for size in sizes
    ]


def _sized(names: tuple[str, ...], size: float) -> Disturbance:
    return Disturbance(**{name: size * getattr(VARIED, name) for name in names})
