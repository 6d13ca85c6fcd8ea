"""Blocks fall and come to rest, the same way every time."""

from __future__ import annotations

import hashlib
import json
import math
import os
import subprocess
import sys

import numpy as np
import pytest
from another_process import TESTS, elsewhere
from world_scenes import build_scene, on_top, random_blocks

from nsrm_harness.geometry.pose import Pose
from nsrm_harness.simulation import world as world_module
from nsrm_harness.simulation.bullet import connect_direct, pybullet
from nsrm_harness.simulation.layout import sample_layout
from nsrm_harness.simulation.world import DROP_M, World


def digest(world: World) -> str:
    values = [pose.position + pose.orientation for pose in world.poses().values()]
    return hashlib.sha256(np.array(values).tobytes()).hexdigest()


def digests(seeds: list[int]) -> dict[int, str]:
    """Of the final poses of one world that goes through all seeds, in that order."""
    result = {}
    with World() as world:
        for seed in seeds:
            build_scene(world, seed, tower=3)
            result[seed] = digest(world)
    return result


def test_final_poses_are_the_same_bytes_in_any_order_and_process():
    seeds = list(range(12))
    here = digests(seeds)
    assert here == digests(seeds[::-1])
    assert here[7] == digests([7])[7]
    code = "import json, test_physics as t;print(json.dumps(t.digests([11, 5, 7, 3])))"
    for seed, value in json.loads(elsewhere(code)).items():
        assert here[int(seed)] == value, f"seed {seed}"


def test_another_client_can_not_change_what_settles():
    alone = digests([3])
    client = connect_direct()
    try:
        with World() as world:
            build_scene(world, 3)
            for moved in (2, 3, 4):
                pybullet.setPhysicsEngineParameter(
                    contactBreakingThreshold=0.2, physicsClientId=client
                )
                world.place(moved, on_top(world, moved, moved - 1))
                world.settle()
            assert digest(world) == alone[3]
    finally:
        pybullet.disconnect(physicsClientId=client)


def test_towers_stand_where_they_are_put():
    for seed in range(15):
        rng = np.random.default_rng(seed)
        blocks = random_blocks(rng, 5)
        with World() as world:
            world.spawn(blocks, sample_layout(rng, blocks))
            world.settle()
            for moved in (2, 3, 4):
                goal = on_top(world, moved, moved - 1)
                before = world.poses()
                world.place(moved, goal)
                settled = world.settle()
                after = world.poses()
                assert settled.at_rest, f"seed {seed}"
                assert after[moved].distance_m(goal) < 0.002, f"seed {seed}"
                assert after[moved].angle_rad(goal) < math.radians(2), f"seed {seed}"
                for other in set(after) - {moved}:
                    assert after[other].distance_m(before[other]) < 0.002, f"seed {seed}"


def test_a_block_without_support_falls():
    """What rests on a corner of its centre must not count as settled in the air."""
    rng = np.random.default_rng(0)
    blocks = random_blocks(rng, 2)
    with World(robot=False) as world:
        world.spawn(blocks, [Pose((0.45, 0.0, blocks[0].edges_m[2] / 2)), Pose((0.6, 0.2, 0.03))])
        world.settle()
        goal = on_top(world, 2, 1)
        x, y, z = goal.position
        world.place(2, Pose((x + blocks[0].edges_m[0] / 2 + 0.004, y, z)))
        assert world.settle().at_rest
        assert world.pose(2).position[2] < z - 0.01


@pytest.mark.parametrize(("slope", "slides"), [(0.33, False), (0.39, True)])
def test_blocks_slide_from_the_slope_on_that_the_docs_say(slope: float, slides: bool):
    with World() as world:
        blocks = random_blocks(np.random.default_rng(3), 1)
        world.spawn(blocks, [Pose.upright(0.45, 0.0, blocks[0].edges_m[2] / 2)])
        world.settle()
        before = world.pose(1)
        tilt = math.atan(slope)
        along, down = 9.81 * math.sin(tilt), -9.81 * math.cos(tilt)
        pybullet.setGravity(along, 0.0, down, physicsClientId=world._client)
        for _ in range(300):
            world._step()
        assert (world.pose(1).distance_m(before) > 0.002) == slides


def test_placing_holds_the_block_above_its_goal_at_rest():
    with World(robot=False) as world:
        build_scene(world, 1)
        goal = on_top(world, 2, 1)
        world.place(2, goal)
        assert world.pose(2).position[2] == pytest.approx(goal.position[2] + DROP_M)


def test_settling_is_bounded(monkeypatch: pytest.MonkeyPatch):
    with World(robot=False) as world:
        build_scene(world, 1)
        world.place(2, on_top(world, 2, 1))
        monkeypatch.setattr(world_module, "MAX_STEPS", 5)
        settled = world.settle()
    assert not settled.at_rest
    assert settled.steps == 5


def test_ids_count_from_one_and_unknown_ones_are_named():
    with World() as world:
        build_scene(world, 2)
        assert list(world.poses()) == list(range(1, len(world.placed()) + 1))
        with pytest.raises(KeyError, match="no block 99"):
            world.pose(99)
        with pytest.raises(ValueError, match="reset"):
            world.spawn([], [])
        world.reset()
        assert world.poses() == {}
        assert "panda_hand" in world.arm_links()


def test_the_arm_rests_out_of_the_way():
    with World() as world:
        links = world.arm_links()
    assert links["panda_link0"].position == (0.0, 0.0, 0.0)
    x, _, z = links["panda_hand"].position
    assert x < 0.35 and z > 0.45


def test_nothing_is_printed():
    code = "from nsrm_harness.simulation.world import World\nwith World() as w: w.settle()"
    done = subprocess.run(
        [sys.executable, "-c", code],
        env={**os.environ, "PYTHONPATH": str(TESTS.parent)},
        capture_output=True,
        check=True,
    )
    assert (done.stdout, done.stderr) == (b"", b"")
