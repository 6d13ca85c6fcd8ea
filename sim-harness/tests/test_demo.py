"""The parts of the demonstration: its scene, the drawn prediction, the outcome."""

from __future__ import annotations

import math
from contextlib import closing

import nsrm
import numpy as np

from nsrm_harness import domain as domains
from nsrm_harness.data.tabletop import tabletop
from nsrm_harness.demo.carry_out import set_down
from nsrm_harness.domain.grammar import Grammar
from nsrm_harness.domain.program import Step
from nsrm_harness.domain.tokens import Tokenizer
from nsrm_harness.geometry.camera import default_camera
from nsrm_harness.geometry.cuboid import Cuboid
from nsrm_harness.geometry.pose import Pose
from nsrm_harness.perception.observer import Observation, Observer
from nsrm_harness.simulation.blocks import block_from_attributes
from nsrm_harness.simulation.render import open_renderer
from nsrm_harness.simulation.simulated_camera import SimulatedCamera
from nsrm_harness.simulation.world import World
from nsrm_harness.visualization.prediction import cut_out, predicted_scene

DOMAIN = domains.load()


def test_a_seed_gives_one_scene_and_a_sentence_about_its_blocks() -> None:
    first, again, other = tabletop(DOMAIN, 5), tabletop(DOMAIN, 5), tabletop(DOMAIN, 6)
    assert first == again
    assert first.arrangement != other.arrangement
    tokens = Tokenizer(DOMAIN)(first.sentence)
    spoken = {DOMAIN.concepts[index].name for group in tokens.groups for index in group}
    shown = {name for block in first.arrangement.blocks for _, name in block.attributes}
    assert spoken and spoken <= shown


def test_the_plain_wording_is_the_first_of_each_list() -> None:
    step = Step("MoveLeft", ("green", "small"), ("lego",))
    assert Grammar(DOMAIN).plain((step, step)) == (
        "put the small green block to the left of the lego block "
        "and put the small green block to the left of the lego block"
    )


def test_a_predicted_scene_has_each_object_at_its_new_place_the_nearest_in_front() -> None:
    rgb = np.zeros((60, 80, 3), np.uint8)
    mask = np.zeros((60, 80), np.int32)
    for object_id, column, color in ((1, 0, (200, 0, 0)), (2, 40, (0, 200, 0))):
        mask[10:20, column : column + 10] = object_id
        rgb[10:20, column : column + 10] = color
    mask[10, 0] = 0  # A corner of the box that is not the object's.
    boxes = {
        1: np.array([0, 10 / 60, 10 / 80, 20 / 60, 1.0], np.float32),
        2: np.array([40 / 80, 10 / 60, 50 / 80, 20 / 60, 0.9], np.float32),
    }
    depth = np.ones(mask.shape, np.float32)
    sight = Observation(rgb, depth, mask, boxes, boxes, frozenset(), {}, 0.0)
    cutouts = {number: cut_out(sight, number) for number in boxes}
    assert np.asarray(cutouts[1])[0, 0, 3] == 0 and np.asarray(cutouts[1])[1, 1, 3] == 255

    background = np.full((60, 80, 3), 50, np.uint8)
    boxes[1] = np.array([45 / 80, 12 / 60, 55 / 80, 22 / 60, 1.0], np.float32)
    far = predicted_scene(background, cutouts, boxes)
    assert far[15, 5].tolist() == [50, 50, 50]  # Gone from where it was.
    assert far[15, 47].tolist() == [0, 200, 0]  # Behind the nearer one,
    assert far[15, 53].tolist() == [200, 0, 0]  # and seen beside it.
    boxes[1][4] = 0.8
    near = predicted_scene(background, cutouts, boxes)
    assert near[15, 47].tolist() == [200, 0, 0]


def test_the_outcome_tells_a_block_that_stays_from_one_that_falls() -> None:
    cube = block_from_attributes(DOMAIN, {"color": "red", "size": "small"})
    with World(robot=False) as world:
        world.spawn([cube, cube], [Pose.upright(0.5, 0.0, 0.02), Pose.upright(0.5, 0.2, 0.02)])
        world.settle()
        cuboids = {
            number: Cuboid(placed.pose, placed.block.edges_m)
            for number, placed in zip((7, 5), world.placed(), strict=True)
        }
        nothing = np.zeros((1, 1, 3), np.uint8)
        depth, labels = nothing[..., 0].astype(np.float32), nothing[..., 0].astype(np.int32)
        sight = Observation(nothing, depth, labels, {}, {}, frozenset(), cuboids, 0.0)
        stays, falls = set_down(
            world,
            sight,
            [(5, Pose.upright(0.5, 0.0, 0.06)), (5, Pose.upright(0.5, 0.032, 0.06))],
        )
    assert stays.at_rest and stays.miss_m < 0.001 and stays.shift_m < 0.001
    assert falls.miss_m > 0.01
    assert f"{1000 * falls.miss_m:.1f} mm from its sub-goal" in str(falls)


def test_what_is_left_of_a_sentence_is_planned_as_the_scene_is_now() -> None:
    model, camera = nsrm.Model.pretrained(), default_camera()
    stage = tabletop(DOMAIN, 3)
    with closing(open_renderer()) as renderer, World() as world:
        world.spawn(stage.arrangement.blocks, stage.arrangement.poses)
        world.settle()
        sight = Observer(SimulatedCamera(renderer, world, camera)).look()
    scene = sight.scene(model, camera)
    whole = model.plan(scene, stage.sentence)
    assert len(whole.steps) == 2
    rest = model.plan(scene, stage.sentence, first=1)
    (step,) = rest.steps
    assert rest.program == whole.program and step.action == whole.steps[1].action
    assert step.explanation.startswith("Step 2: ")
    # The white block has not been moved, as the whole plan holds it would be by then.
    assert math.dist(step.position, whole.steps[1].position) > 0.01
    assert model.plan(scene, stage.sentence, first=2).steps == []
