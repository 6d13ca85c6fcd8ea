"""Plans through other cameras than that of the training."""

from __future__ import annotations

import json
from dataclasses import asdict, replace
from pathlib import Path

import nsrm
import pytest
from harness_command import run

from nsrm_harness import domain as domains
from nsrm_harness.evaluation.metrics import domain_of
from nsrm_harness.evaluation.viewpoints import VIEWS, CameraPlacement, measure
from nsrm_harness.geometry.pose import Pose
from nsrm_harness.simulation.blocks import block_from_attributes
from nsrm_harness.simulation.render import Light, open_renderer
from nsrm_harness.simulation.segmentation import render_segmented
from nsrm_harness.simulation.world import World

PRETRAINED = Path(__file__).parents[2] / "weights-codegen/tabletop/tabletop.safetensors"
MODEL = nsrm.Model.pretrained()
DOMAIN = domain_of(MODEL, domains.load())
FAR = CameraPlacement(distance_m=1.7, focal_px=1250.0)
BEHIND = CameraPlacement(azimuth=180.0, elevation=60.0, distance_m=1.0, focal_px=720.0)


def test_another_camera_moves_no_sub_goal() -> None:
    views = (None, FAR, replace(FAR, width=320, height=240, focal_px=625.0), BEHIND)
    for row in measure(MODEL, DOMAIN, 12, 3, views):
        assert row.wrong == 0 and row.refused <= 3, row
        # A model that knew nothing of the camera would place the blocks 20 mm off and more.
        assert row.p50_mm is not None and row.p50_mm < 4.0, row
        assert row.p95_mm is not None and row.p95_mm < 15.0, row


def test_what_a_camera_sees_too_steeply_is_refused() -> None:
    (row,) = measure(MODEL, DOMAIN, 12, 3, [CameraPlacement(elevation=85.0)])
    assert row.refused >= 8 and row.wrong == 0


def test_what_a_camera_sees_from_too_low_is_refused() -> None:
    (row,) = measure(MODEL, DOMAIN, 12, 3, [CameraPlacement(elevation=25.0)])
    assert row.refused == 12


@pytest.mark.parametrize("view", [FAR, BEHIND])
def test_what_is_offered_by_place_is_what_the_camera_sees(view: CameraPlacement) -> None:
    values = [
        {"color": "red", "size": "small"},
        {"color": "red", "size": "small"},
        {"color": "blue", "size": "lego"},
        {"color": "white", "size": "lego"},
    ]
    blocks = [block_from_attributes(DOMAIN, each) for each in values]
    height = blocks[0].edges_m[2] / 2
    places = [(0.45, -0.15), (0.45, 0.15), (0.45, 0.0), (0.6, 0.0)]
    poses = [Pose.upright(x, y, height) for x, y in places]
    camera, drawing = view.camera(), open_renderer("auto")
    with World() as world:
        world.spawn(blocks, poses)
        world.settle()
        seen = render_segmented(drawing, world, camera, Light())
    drawing.close()
    scene = MODEL.observe(
        seen.rgb, list(seen.ids), seen.boxes, seen.depths, nsrm.Camera(**asdict(camera))
    )
    with pytest.raises(nsrm.Refused) as refused:
        MODEL.plan(scene, "put the red block on the white block")
    assert refused.value.kind == "ambiguous" and refused.value.question is not None
    moved = {}
    for option in refused.value.question.options:
        (step,) = MODEL.plan(scene, option.sentence).steps
        moved[option.answer] = step.object_id
    # The robot's left is the right of who stands opposite it.
    left, right = (1, 2) if view is FAR else (2, 1)
    assert moved == {
        "the red one to the left of the lego blue one": left,
        "the red one to the right of the lego blue one": right,
    }


def test_the_command_prints_the_figures(capsys: pytest.CaptureFixture[str]) -> None:
    assert run("viewpoints", "--count", 1, "--json") == 0
    rows = json.loads(capsys.readouterr().out)
    assert [row["sentences"] for row in rows] == [1] * len(VIEWS)
    assert rows[0]["view"] == "the camera of the training"
    assert rows[1]["view"] == "azimuth 0°, elevation 40°, 1.25 m, 640×480, focal length 900 px"


def test_without_the_transformation_sub_goals_are_centimetres_off(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert run("viewpoints", "--untransformed") == 2
    assert "--untransformed needs --model" in capsys.readouterr().err
    given = ("--untransformed", "--model", PRETRAINED, "--count", 3, "--seed", 1, "--json")
    assert run("viewpoints", *given) == 0
    rows = {row["view"]: row for row in json.loads(capsys.readouterr().out)}
    assert rows["the camera of the training"]["p50_mm"] < 4.0
    assert rows[str(FAR)]["p50_mm"] > 20.0
