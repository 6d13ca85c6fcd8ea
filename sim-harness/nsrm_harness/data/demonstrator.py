"""The demonstrator: draws a scene and a program, executes it in the simulation, and records what
the camera saw before and after.

An attempt is rejected, counted by reason and drawn again if

* the scene allows no program of the requested kind, or has no room for the blocks;
* the blocks do not come to rest within the world's limit of steps;
* the initial scene's stack has shifted by more than `MAX_SHIFT_M` or `MAX_TURN_RAD` at rest;
* a block other than the moved one shifts by more than `MAX_SHIFT_M` or `MAX_TURN_RAD`;
* the moved block ends farther than `MAX_MISS_M` or `MAX_TURN_RAD` from its target;
* a block is hidden from the camera before or after, or the moved one after its step.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from nsrm_harness.common.errors import EpisodeSettingsError
from nsrm_harness.data.disturbance import UNDISTURBED, Disturbance
from nsrm_harness.data.moves import Arrangement, Move, stacking_action, target
from nsrm_harness.data.programs import Descriptions, Task, sample_blocks, sample_task
from nsrm_harness.domain import Domain
from nsrm_harness.domain.grammar import Grammar, Sentence
from nsrm_harness.domain.program import Program
from nsrm_harness.geometry.camera import Camera, default_camera
from nsrm_harness.geometry.pose import Pose
from nsrm_harness.simulation.blocks import Block
from nsrm_harness.simulation.layout import LayoutError, sample_layout
from nsrm_harness.simulation.render import Light, Renderer
from nsrm_harness.simulation.segmentation import (
    SegmentedImage,
    SegmentedObjects,
    render_objects,
    segmented_image,
)
from nsrm_harness.simulation.world import World

Seen = TypeVar("Seen", bound=SegmentedObjects)

MAX_SHIFT_M = 0.002
MAX_MISS_M = 0.005
MAX_TURN_RAD = math.radians(2.0)
#: Share of episodes with a stack whose first step names a block of it, if possible; the others name
#: any blocks.
ABOUT_STACK = 0.5
#: Attempts at one episode before the settings count as impossible.
MAX_ATTEMPTS = 400


@dataclass(frozen=True)
class EpisodeRequest:
    """The requirements on an episode."""

    steps: int
    #: Smallest and largest number of blocks.
    objects: tuple[int, int]
    descriptions: Descriptions
    #: No block has all values of one of these.
    exclude: tuple[frozenset[str], ...] = ()
    #: The shares from which 1-step programs are drawn.
    shares: tuple[int, ...] | None = None
    #: The program names a block by all values of one of these.
    novel: tuple[frozenset[str], ...] = ()
    #: Whether the sentence uses word orders held out from training.
    held_out_wordings: bool = False
    #: Whether it also uses relations held out from training.
    held_out_phrases: bool = False
    #: Whether the light varies between episodes.
    vary_light: bool = True
    #: Whether the image of the final scene is kept; nothing learns from it.
    final_image: bool = True
    disturbance: Disturbance = UNDISTURBED
    #: Whether a block stands on another one in the initial scene.
    stacked: bool = False


@dataclass(frozen=True)
class DemonstratedSubGoal:
    """Where a step left the block that it moved."""

    #: Index of the moved block, from 0.
    moved: int
    reference: int
    #: At rest, in the world.
    pose: Pose
    #: Box corners and mean depth as the camera saw it, float32 `[5]`.
    location: np.ndarray


@dataclass(frozen=True)
class Episode:
    """A demonstration. The first four fields are for learning; the rest is ground truth."""

    initial: SegmentedImage
    final: SegmentedObjects
    sentence: Sentence
    camera: Camera
    program: Program
    blocks: tuple[Block, ...]
    initial_poses: tuple[Pose, ...]
    final_poses: tuple[Pose, ...]
    sub_goals: tuple[DemonstratedSubGoal, ...]
    #: Attempts rejected before this one, by reason.
    rejected: Counter[str]

    @property
    def final_picture(self) -> SegmentedImage:
        """The final scene as the camera saw it, if requested."""
        if not isinstance(self.final, SegmentedImage):
            raise EpisodeSettingsError("the episode has no image of its final scene")
        return self.final


class RejectedError(Exception):
    """An attempt that is rejected; the message is the reason."""


class Demonstrator:
    """Generates episodes of one domain in one world with one renderer."""

    def __init__(self, domain: Domain, world: World, renderer: Renderer) -> None:
        self._domain = domain
        self._world = world
        self._renderer = renderer
        self._grammars = {(False, False): Grammar(domain)}
        if domain.held_out is not None:
            for phrases in (False, True):
                self._grammars[True, phrases] = Grammar(
                    domain, held_out=True, held_out_phrases=phrases
                )

    def episode(self, rng: np.random.Generator, wanted: EpisodeRequest) -> Episode:
        """Draws the next episode that the rules accept.

        Raises `EpisodeSettingsError` after `MAX_ATTEMPTS` attempts.
        """
        rejected: Counter[str] = Counter()
        for _ in range(MAX_ATTEMPTS):
            try:
                return self._attempt(rng, wanted, rejected)
            except RejectedError as error:
                rejected[str(error)] += 1
        raise EpisodeSettingsError(
            f"no episode with {wanted.steps} steps after {MAX_ATTEMPTS} attempts "
            f"({describe(rejected)}): use fewer steps, or other numbers of objects"
        )

    def _attempt(
        self, rng: np.random.Generator, wanted: EpisodeRequest, rejected: Counter[str]
    ) -> Episode:
        arrangement, task = self._draw(rng, wanted)
        grammar = self._grammars[wanted.held_out_wordings, wanted.held_out_phrases]
        sentence = grammar.sentence(rng, task.program)
        # A separate generator: scene and program do not depend on the size of the disturbance.
        (disturbing,) = rng.spawn(1)
        disturbance = wanted.disturbance
        light = Light.sample(rng) if wanted.vary_light else Light()
        light = disturbance.lit(light, disturbing)
        camera = disturbance.moved(default_camera(), disturbing)

        def observe() -> SegmentedImage:
            frame = self._renderer.render(self._world, camera, light)
            seen = segmented_image(disturbance.measured(frame, disturbing))
            return _all_seen(seen, range(len(arrangement.blocks)))

        self._world.reset()
        self._world.spawn(disturbance.painted(arrangement.blocks, disturbing), arrangement.poses)
        self._settle()
        initial_poses = self._poses()
        if wanted.stacked and any(map(_shifted, arrangement.poses, initial_poses)):
            raise RejectedError("unstable stack")
        initial = observe()
        sub_goals: list[DemonstratedSubGoal] = []
        final: SegmentedObjects = initial
        # A disturbance acts on rendered images, so one is needed.
        pictured = wanted.final_image or disturbance != UNDISTURBED
        for number, move in enumerate(task.moves, start=1):
            pose = self._carry_out(arrangement.blocks, move)
            last = number == len(task.moves)
            if last and pictured:
                seen = final = observe()
            else:
                needed = range(len(arrangement.blocks)) if last else [move.moved]
                seen = final = _all_seen(
                    render_objects(self._renderer, self._world, camera), needed
                )
            location = seen.location(move.moved + 1)
            sub_goals.append(DemonstratedSubGoal(move.moved, move.reference, pose, location))
        return Episode(
            initial,
            final,
            sentence,
            camera,
            task.program,
            arrangement.blocks,
            initial_poses,
            self._poses(),
            tuple(sub_goals),
            rejected,
        )

    def _draw(self, rng: np.random.Generator, wanted: EpisodeRequest) -> tuple[Arrangement, Task]:
        least, most = wanted.objects
        count = int(rng.integers(least, most + 1))
        blocks = sample_blocks(rng, self._domain, count, wanted.exclude, wanted.novel)
        about: tuple[int, ...] = ()
        try:
            if wanted.stacked:
                arrangement, about = self._stack(rng, blocks)
            else:
                arrangement = Arrangement.on_table(blocks, sample_layout(rng, blocks))
        except LayoutError as error:
            raise RejectedError("no room") from error
        task = sample_task(
            rng,
            self._domain,
            arrangement,
            wanted.steps,
            wanted.descriptions,
            wanted.shares,
            wanted.novel,
            about,
        )
        if task is None:
            raise RejectedError("no program")
        return arrangement, task

    def _stack(
        self, rng: np.random.Generator, blocks: Sequence[Block]
    ) -> tuple[Arrangement, tuple[int, ...]]:
        """An arrangement with one block on another and the rest on the table, and the indices of
        the blocks that the program should be about."""
        upper, lower = (int(index) for index in rng.choice(len(blocks), 2, replace=False))
        poses = sample_layout(rng, [*blocks[:upper], *blocks[upper + 1 :]])
        # The upper block's pose on the table is a placeholder: nothing depends on it.
        poses.insert(upper, Pose.upright(0.0, 0.0, 0.0))
        table = Arrangement.on_table(blocks, poses)
        move = Move(stacking_action(self._domain), upper, lower)
        if not table.allowed(move):
            raise RejectedError("no room")
        return table.after(move), (upper, lower) if rng.random() < ABOUT_STACK else ()

    def _carry_out(self, blocks: Sequence[Block], move: Move) -> Pose:
        """Puts the block at the reference's present place, releases it, and checks the result."""
        before = self._poses()
        goal = target(move, blocks, before)
        self._world.place(move.moved + 1, goal)
        self._settle()
        after = self._poses()
        for index, (old, new) in enumerate(zip(before, after, strict=True)):
            if index != move.moved and _shifted(old, new):
                raise RejectedError("shifted another")
        reached = after[move.moved]
        if reached.distance_m(goal) > MAX_MISS_M or reached.angle_rad(goal) > MAX_TURN_RAD:
            raise RejectedError("missed the target")
        return reached

    def _settle(self) -> None:
        if not self._world.settle().at_rest:
            raise RejectedError("not at rest")

    def _poses(self) -> tuple[Pose, ...]:
        return tuple(pose for _, pose in sorted(self._world.poses().items()))


def _shifted(old: Pose, new: Pose) -> bool:
    return new.distance_m(old) > MAX_SHIFT_M or new.angle_rad(old) > MAX_TURN_RAD


def _all_seen(seen: Seen, needed: Sequence[int]) -> Seen:
    if not {index + 1 for index in needed} <= set(seen.ids):
        raise RejectedError("hidden")
    return seen


def describe(rejected: Counter[str]) -> str:
    """The counts as text: ``missed the target 3, no program 1``."""
    counts = [f"{reason} {count}" for reason, count in sorted(rejected.items())]
    return ", ".join(counts) if counts else "none"
