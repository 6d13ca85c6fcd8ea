"""The report's pictures: the worst episodes, actions and concepts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import nsrm
import pytest
from PIL import Image

from nsrm_harness import domain as domains
from nsrm_harness.data.generate import SPLITS, generate
from nsrm_harness.domain.program import Step
from nsrm_harness.evaluation.metrics import JudgedPlans
from nsrm_harness.paper.tables.actions import draw_actions
from nsrm_harness.paper.tables.concepts import draw_concepts
from nsrm_harness.paper.tables.failures import draw_failures, what_went_wrong, worst_episodes

PRETRAINED = Path(__file__).resolve().parents[2] / "weights-codegen/tabletop/tabletop.safetensors"


@pytest.fixture(scope="module")
def episodes(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("episodes") / "test.h5"
    generate(replace(SPLITS["test"], count=5, seed=1), domains.load(), path)
    return path


@pytest.fixture(scope="module")
def worst(episodes: Path) -> list[JudgedPlans]:
    return worst_episodes(nsrm.Model.pretrained(), episodes)


@pytest.fixture(scope="module")
def planned(worst: Sequence[JudgedPlans]) -> JudgedPlans:
    return next(judged for judged in worst if judged.score.program)


def meant(judged: JudgedPlans, **changes: object) -> JudgedPlans:
    """The same plan, judged by another first step."""
    first, *rest = judged.truth.steps
    steps = (replace(first, **changes), *rest)
    return replace(judged, truth=replace(judged.truth, steps=steps))


def test_the_worst_come_first(worst: Sequence[JudgedPlans]) -> None:
    assert len(worst) == 5
    merits = [(judged.score.program, judged.score.iou_3d) for judged in worst]
    assert merits == sorted(merits)


def test_what_went_wrong_is_told(planned: JudgedPlans) -> None:
    assert what_went_wrong(planned).startswith("Understood; errors along x, y, z: step 1 by ")
    step = planned.truth.steps[0].step
    for changes, words in (
        ({"step": Step("Throw", step.object, step.reference)}, "instead of Throw."),
        ({"object_id": 9}, "Step 1: moves block"),
        ({"reference_id": 9}, "Step 1: refers to block"),
        ({"step": Step(step.action, ("lead",), step.reference)}, "instead of lead."),
    ):
        assert words in what_went_wrong(meant(planned, **changes))
    shorter = replace(planned, truth=replace(planned.truth, steps=()))
    assert "instead of 0" in what_went_wrong(shorter)
    assert "detector" in what_went_wrong(replace(planned, outcome=None))


def test_pictures_are_drawn(worst: list[JudgedPlans], episodes: Path, tmp_path: Path) -> None:
    draw_failures(worst, episodes, tmp_path / "failures.png")
    draw_actions(nsrm.Model.pretrained(), domains.load(), tmp_path / "actions.png")
    draw_concepts(PRETRAINED, episodes, tmp_path / "concepts.png")
    for name in ("failures", "actions", "concepts"):
        colors = Image.open(tmp_path / f"{name}.png").convert("RGB").getcolors(1 << 24)
        assert colors is not None and len(colors) > 10
