"""The demonstrator: programs executed in the physics and seen by the camera."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
import pytest

from nsrm_harness import domain as domains
from nsrm_harness.common.errors import EpisodeSettingsError
from nsrm_harness.data import demonstrator as module
from nsrm_harness.data.demonstrator import Demonstrator, Episode, EpisodeRequest
from nsrm_harness.data.moves import Move, target
from nsrm_harness.data.programs import Descriptions
from nsrm_harness.domain.tokens import Tokenizer
from nsrm_harness.geometry.pose import Pose
from nsrm_harness.simulation.blocks import Block
from nsrm_harness.simulation.render import Frame, open_renderer
from nsrm_harness.simulation.segmentation import SegmentedImage, segmented_image
from nsrm_harness.simulation.world import Settled, World

DOMAIN = domains.load()
WANTED = EpisodeRequest(2, (4, 5), Descriptions(1, 2))


@pytest.fixture(scope="module")
def demonstrator() -> Iterator[Demonstrator]:
    renderer = open_renderer("pybullet")
    with World() as world:
        yield Demonstrator(DOMAIN, world, renderer)
    renderer.close()


def make(demonstrator: Demonstrator, index: int, wanted: EpisodeRequest = WANTED) -> Episode:
    return demonstrator.episode(np.random.default_rng([77, index]), wanted)


def moves(episode: Episode) -> list[Move]:
    return [
        Move(DOMAIN.action(step.action), goal.moved, goal.reference)
        for step, goal in zip(episode.program, episode.sub_goals, strict=True)
    ]


def test_blocks_end_where_the_steps_put_them(demonstrator: Demonstrator) -> None:
    for index in range(4):
        episode = make(demonstrator, index)
        poses = list(episode.initial_poses)
        for move, goal in zip(moves(episode), episode.sub_goals, strict=True):
            aimed = target(move, episode.blocks, poses)
            assert goal.pose.distance_m(aimed) <= module.MAX_MISS_M
            assert goal.pose.angle_rad(aimed) <= module.MAX_TURN_RAD
            poses[move.moved] = goal.pose
        for expected, final in zip(poses, episode.final_poses, strict=True):
            assert final.distance_m(expected) <= 2 * module.MAX_SHIFT_M


def test_the_camera_sees_what_is_where(demonstrator: Demonstrator) -> None:
    episode = make(demonstrator, 1)
    count = len(episode.blocks)
    for seen, poses in (
        (episode.initial, episode.initial_poses),
        (episode.final, episode.final_poses),
    ):
        assert seen.ids == tuple(range(1, count + 1))
        for box, pose in zip(seen.boxes, poses, strict=True):
            column, row, _ = episode.camera.project(pose.position)
            assert box[0] < column / episode.camera.width < box[2]
            assert box[1] - 0.05 < row / episode.camera.height < box[3] + 0.05
    last = episode.sub_goals[-1]
    assert last.location[:4] == pytest.approx(episode.final.boxes[last.moved])
    assert last.location[4] == pytest.approx(episode.final.depths[last.moved])
    assert (episode.initial.rgb != episode.final_picture.rgb).any()


def test_the_sentence_says_the_program(demonstrator: Demonstrator) -> None:
    episode = make(demonstrator, 2)
    groups = Tokenizer(DOMAIN)(episode.sentence.text).groups
    named = sorted(sorted(DOMAIN.concepts[index].name for index in group) for group in groups)
    meant = [sorted(each) for step in episode.program for each in (step.object, step.reference)]
    assert named == sorted(meant)


def test_novel_combinations_are_in_the_scene_and_named(demonstrator: Demonstrator) -> None:
    pairs = (frozenset(("cyan", "lego")), frozenset(("green", "small")))
    for index in range(4):
        episode = make(demonstrator, index, replace(WANTED, novel=pairs))
        assert any(pair <= set(block.values.values()) for pair in pairs for block in episode.blocks)
        named = [set(said) for step in episode.program for said in (step.object, step.reference)]
        assert any(pair <= said for pair in pairs for said in named)


def test_the_same_draws_give_the_same_episode_after_any_other(demonstrator: Demonstrator) -> None:
    first = make(demonstrator, 3)
    make(demonstrator, 4)
    again = make(demonstrator, 3)
    assert again.final_poses == first.final_poses
    assert again.sentence == first.sentence
    assert (again.final_picture.rgb == first.final_picture.rgb).all()
    assert (again.final.boxes == first.final.boxes).all()


def stack(blocks: Sequence[Block], poses: Sequence[Pose]) -> tuple[int, int] | None:
    """The upper and the lower block of the scene's only stack; None if all stand on the table."""
    upper = max(range(len(blocks)), key=lambda index: bottom_m(blocks, poses, index))
    others = [index for index in range(len(blocks)) if index != upper]
    assert all(abs(bottom_m(blocks, poses, index)) < 0.001 for index in others)
    if abs(bottom_m(blocks, poses, upper)) < 0.001:
        return None
    x, y, _ = poses[upper].position
    (lower,) = (
        index
        for index in others
        if poses[index].position[:2] == pytest.approx((x, y), abs=module.MAX_SHIFT_M)
    )
    top_m = poses[lower].position[2] + blocks[lower].edges_m[2] / 2
    assert bottom_m(blocks, poses, upper) == pytest.approx(top_m, abs=0.001)
    return upper, lower


def bottom_m(blocks: Sequence[Block], poses: Sequence[Pose], index: int) -> float:
    return poses[index].position[2] - blocks[index].edges_m[2] / 2


def test_a_block_stands_on_another_where_wanted(demonstrator: Demonstrator) -> None:
    named = 0
    pairs: set[tuple[int, int]] = set()
    wanted = replace(WANTED, steps=1)
    for index in range(12):
        flat = make(demonstrator, index, wanted)
        assert stack(flat.blocks, flat.initial_poses) is None
        episode = make(demonstrator, index, replace(wanted, stacked=True))
        found = stack(episode.blocks, episode.initial_poses)
        assert found is not None
        upper, lower = found
        pairs.add(found)
        assert episode.initial.ids == tuple(range(1, len(episode.blocks) + 1))
        (move,) = moves(episode)
        assert move.moved != lower, "it bears the upper one"
        named += bool({move.moved, move.reference} & {upper, lower})
    assert named >= 6
    assert len(pairs) > 4, "any block on any other"


def test_a_stack_needs_an_action_that_makes_one() -> None:
    beside = replace(DOMAIN, actions=tuple(each for each in DOMAIN.actions if each.direction))
    renderer = open_renderer("pybullet")
    with World() as world, pytest.raises(EpisodeSettingsError, match="no action that puts a block"):
        make(Demonstrator(beside, world, renderer), 0, replace(WANTED, stacked=True))
    renderer.close()


class Disturbed:
    """A world in which something goes wrong at the first step of the first attempts."""

    def __init__(self, world: World, fault: str) -> None:
        self._world = world
        self._fault = fault
        self._spawned = 0

    def __getattr__(self, name: str) -> object:
        return getattr(self._world, name)

    def spawn(self, blocks: Sequence[object], poses: Sequence[Pose]) -> None:
        self._spawned += 1
        if self._spawned <= 2 and self._fault == "unstable stack":
            # The upper block's centre is beyond the lower one's edge.
            upper = max(range(len(poses)), key=lambda index: poses[index].position[2])
            x, y, z = poses[upper].position
            poses = [*poses[:upper], Pose.upright(x + 0.035, y, z), *poses[upper + 1 :]]
        self._world.spawn(blocks, poses)  # type: ignore[arg-type]

    def place(self, block_id: int, pose: Pose) -> None:
        x, y, z = pose.position
        bad = self._spawned <= 2
        if bad and self._fault == "missed the target":
            pose = Pose((x + 0.008, y, z), pose.orientation)
        self._world.place(block_id, pose)
        if bad and self._fault == "shifted another":
            other = 2 if block_id == 1 else 1
            x, y, z = self._world.pose(other).position
            self._world.place(other, Pose((x + 0.003, y, z), self._world.pose(other).orientation))

    def settle(self) -> Settled:
        settled = self._world.settle()
        bad = self._spawned <= 2 and self._fault == "not at rest"
        return Settled(settled.at_rest and not bad, settled.steps)


@pytest.mark.parametrize("fault", ["missed the target", "shifted another", "not at rest"])
def test_what_goes_wrong_is_left_out_and_counted(fault: str) -> None:
    renderer = open_renderer("pybullet")
    with World() as world:
        disturbed = Demonstrator(DOMAIN, Disturbed(world, fault), renderer)  # type: ignore[arg-type]
        episode = make(disturbed, 5)
    renderer.close()
    assert episode.rejected[fault] == 2
    assert len(episode.sub_goals) == 2


def test_a_stack_that_falls_is_left_out_and_counted() -> None:
    renderer = open_renderer("pybullet")
    with World() as world:
        disturbed = Demonstrator(DOMAIN, Disturbed(world, "unstable stack"), renderer)  # type: ignore[arg-type]
        episode = make(disturbed, 5, replace(WANTED, stacked=True))
    renderer.close()
    assert episode.rejected["unstable stack"] == 2
    assert stack(episode.blocks, episode.initial_poses) is not None


def test_a_block_that_the_camera_does_not_see_is_left_out(
    demonstrator: Demonstrator, monkeypatch: pytest.MonkeyPatch
) -> None:
    calls = 0

    def observe_less(frame: Frame) -> SegmentedImage:
        nonlocal calls
        calls += 1
        seen = segmented_image(frame)
        return replace(seen, ids=seen.ids[:-1]) if calls <= 2 else seen

    monkeypatch.setattr(module, "segmented_image", observe_less)
    assert make(demonstrator, 6).rejected["hidden"] == 2


def test_settings_that_allow_no_episode_are_refused(demonstrator: Demonstrator) -> None:
    no_share = EpisodeRequest(1, (4, 4), Descriptions(1, 2), shares=())
    with pytest.raises(EpisodeSettingsError, match=r"after 400 attempts \(no program 400\)"):
        make(demonstrator, 0, no_share)
