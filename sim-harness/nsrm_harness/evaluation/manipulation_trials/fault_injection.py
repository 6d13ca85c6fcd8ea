"""Faults that a person, a camera or a controller may cause while the arm works.

The arm learns of them only through its images and joints."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import replace
from typing import ClassVar

import numpy as np

from nsrm_harness.data.moves import Move, target
from nsrm_harness.evaluation.manipulation_trials.rows import Drawn
from nsrm_harness.geometry.camera import Camera
from nsrm_harness.geometry.panda import FINGERTIP_M, HAND_FRAME
from nsrm_harness.geometry.pose import Pose
from nsrm_harness.manipulation.execute import ExecutionResult
from nsrm_harness.manipulation.gripper import GripperError
from nsrm_harness.manipulation.kinematics import Joints
from nsrm_harness.manipulation.observing import NoObservationError
from nsrm_harness.manipulation.retries import ManipulationError
from nsrm_harness.manipulation.robot_interface import StuckError
from nsrm_harness.perception.camera_source import RgbdImage
from nsrm_harness.simulation.arm_world import ArmWorld
from nsrm_harness.simulation.blocks import Block
from nsrm_harness.simulation.layout import LayoutError, footprint, sample_layout
from nsrm_harness.simulation.render import Renderer
from nsrm_harness.simulation.simulated_camera import SimulatedCamera

BEGUN = "begun"
"""The event of starting an attempt at a step; later ones are the marks of `execute.execute`."""
GONE_S = 1.0
"""How long a camera is dark, or a scene is frozen that is not frozen for ever."""
ASTRAY_RAD = 0.02
"""Joints that are farther than this from their target have not reached it."""
NOT_HELD = (ExecutionResult.NOT_GRASPED, ExecutionResult.SLIPPED)
"""Results of a pick and place whose fingers cannot hold the block."""
FINGERS = Block((), (0.12, 0.12, 0.06), (0.0, 0.0, 0.0))
"""The space that open fingers take in any orientation."""


class FaultyArm(ArmWorld):
    """An arm in which faults can be injected.

    * `is_jammed`: the fingers do not close
    * `has_opened_astray`: the fingers were opened while the arm was away from its target
    """

    def __init__(self) -> None:
        super().__init__()
        self.is_jammed, self.has_opened_astray = False, False
        self._told: Joints | None = None

    def stop(self) -> None:
        """Makes the controller hold the joints where they are, whatever it is commanded later."""
        self._told = self.joints()
        super().drive(self._told, np.zeros_like(self._told))

    def drive(self, joints: Joints, speeds: Joints) -> None:
        """See `ArmWorld`."""
        if self._told is None:
            super().drive(joints, speeds)
        else:
            self._told = joints

    def grip(self, opening_m: float, force_n: float) -> None:
        """See `ArmWorld`."""
        if self._told is not None and opening_m > self.opening_m():
            astray_rad = float(np.abs(self.joints() - self._told).max())
            self.has_opened_astray |= astray_rad > ASTRAY_RAD
        if opening_m > 0.0 or not self.is_jammed:
            super().grip(opening_m, force_n)

    def make_slippery(self) -> None:
        """Removes the friction of the fingers, so that they hold nothing."""
        self._arm.rub(0.0)

    def fingers_at(self) -> Pose:
        """The pose of the fingers, seen from above."""
        hand = self.arm_links()[HAND_FRAME]
        x, y, z = (hand @ Pose((0.0, 0.0, FINGERTIP_M))).position
        return Pose.upright(x, y, z)


class InjectedFault(ABC):
    """A fault that disturbs one step of an episode once: after a random delay from `since`, and no
    later than `until`.

    * `meddled`: indices of the blocks that it has moved
    * `has_acted`: whether it has begun

    The constructor raises `LayoutError` if the fault is impossible in the scene.
    """

    title: ClassVar[str]
    is_stack: ClassVar[bool] = False
    """Whether it needs a stack."""
    since: str = BEGUN
    until: str = "reached"
    longest_s: float = 0.0

    def __init__(self, arm: FaultyArm, drawn: Drawn, rng: np.random.Generator) -> None:
        self._arm, self._rng = arm, rng
        self._blocks, self._moves = drawn.arrangement.blocks, drawn.task.moves
        self.meddled, self.has_acted = set[int](), False
        self.step = int(rng.integers(len(self._moves)))
        self._delay_s = float(rng.uniform())
        self._ticks: int | None = None

    def mark(self, step: int, event: str) -> None:
        """Call this with each event of a step; steps count from 0."""
        if self.has_acted or step != self.step:
            return
        if event == self.since and self._ticks is None:
            self._ticks = round(self._delay_s * self.longest_s / self._arm.tick_s)
        if self._ticks == 0 or (event == self.until and self._ticks is not None):
            self._act_once()

    def tick(self) -> None:
        """Call this in each tick of the arm."""
        if self._ticks is not None and not self.has_acted:
            self._ticks -= 1
            if self._ticks <= 0:
                self._act_once()

    def picture(self, image: RgbdImage) -> RgbdImage:
        """Returns the image that the camera gives instead of one taken now; its time may differ,
        too."""
        return image

    def explains(self, _error: Exception) -> bool:
        """Whether it makes the sentence impossible, and the arm gave up with the right error."""
        return False

    @abstractmethod
    def _act(self) -> None: ...

    def _act_once(self) -> None:
        self.has_acted = True
        self._act()

    @property
    def _move(self) -> Move:
        return self._moves[self.step]

    def _poses(self) -> list[Pose]:
        return [placed.pose for placed in self._arm.placed()]

    def _put(self, index: int, pose: Pose) -> None:
        self.meddled.add(index)
        self._arm.place(index + 1, pose)

    def _put_aside(self, index: int) -> None:
        """Moves a block to a free place on the table that no step needs."""
        poses = self._poses()
        taken = [footprint(block, pose) for block, pose in zip(self._blocks, poses, strict=True)]
        taken += [
            footprint(self._blocks[move.moved], target(move, self._blocks, poses))
            for move in self._moves
        ]
        taken.append(footprint(FINGERS, self._arm.fingers_at()))
        (pose,) = sample_layout(self._rng, [self._blocks[index]], around=taken)
        self._put(index, pose)


class BlockMoved(InjectedFault):
    """The block that the arm is about to grasp is moved elsewhere."""

    title = "the block moved while the arm approaches"
    longest_s = 1.0

    def _act(self) -> None:
        self._put_aside(self._move.moved)


class BlockPushedOut(InjectedFault):
    """The block that the arm has grasped is taken out of its hand."""

    title = "the block pushed out of the grasp"
    since, until, longest_s = "grasped", "above", 1.5

    def _act(self) -> None:
        self._put_aside(self._move.moved)


class StackToppled(InjectedFault):
    """The top block of a stack falls on the table: right after it was placed, or while the arm
    brings the next one."""

    title = "the top of a stack toppled"
    is_stack = True

    def __init__(self, arm: FaultyArm, drawn: Drawn, rng: np.random.Generator) -> None:
        super().__init__(arm, drawn, rng)
        self._top = self._move.moved
        if self.step > 0 and rng.random() < 0.5:
            self._top = self._moves[self.step - 1].moved
            self.until, self.longest_s = "above", 3.0
        else:
            self.since, self.until, self.longest_s = "let go", "home", 0.5

    def _act(self) -> None:
        self._put_aside(self._top)


class GoalTaken(InjectedFault):
    """A block that the sentence does not name is put onto the goal of the step."""

    title = "another block put onto the goal"
    longest_s = 1.0
    AWAY_M = 0.12
    """Smallest distance to where the fingers grasp at that time."""

    def __init__(self, arm: FaultyArm, drawn: Drawn, rng: np.random.Generator) -> None:
        super().__init__(arm, drawn, rng)
        arrangement = drawn.arrangement
        for move in self._moves[: self.step]:
            arrangement = arrangement.after(move)
        spoken_of = {index for move in self._moves for index in (move.moved, move.reference)}
        goal = target(self._move, arrangement.blocks, arrangement.poses)
        unmoved = arrangement.poses[self._move.moved]
        others = [
            index
            for index in range(len(self._blocks))
            if index not in spoken_of
            and arrangement.allowed(replace(self._move, moved=index))
            and goal.distance_m(unmoved) > self.AWAY_M
        ]
        if not others:
            raise LayoutError("no block can be put onto the goal")
        self._other = others[int(rng.integers(len(others)))]

    def _act(self) -> None:
        move = replace(self._move, moved=self._other)
        self._put(self._other, target(move, self._blocks, self._poses()))


class CameraDark(InjectedFault):
    """Images are black from the first observation on."""

    title = "the camera dark for a second"
    _since_s: float | None = None

    def picture(self, image: RgbdImage) -> RgbdImage:
        """See `InjectedFault`."""
        if self._since_s is None and self.has_acted:
            self._since_s = image.taken_s
        if self._since_s is not None and image.taken_s < self._since_s + GONE_S:
            return replace(image, rgb=np.zeros_like(image.rgb))
        return image

    def _act(self) -> None: ...


class SceneFrozen(InjectedFault):
    """The camera repeats its last image, for a second or for ever, from the first observation for
    which that image is old."""

    title = "the scene frozen"
    _last: RgbdImage | None = None
    _since_s: float | None = None

    def __init__(self, arm: FaultyArm, drawn: Drawn, rng: np.random.Generator) -> None:
        super().__init__(arm, drawn, rng)
        self._is_for_ever = bool(rng.random() < 0.5)

    def picture(self, image: RgbdImage) -> RgbdImage:
        """See `InjectedFault`."""
        if not self.has_acted or self._last is None:
            self._last = image
            return image
        if self._since_s is None and image.taken_s > self._last.taken_s:
            self._since_s = image.taken_s
        if self._since_s is None or self._is_for_ever or image.taken_s < self._since_s + GONE_S:
            return self._last
        return image

    def explains(self, error: Exception) -> bool:
        """See `InjectedFault`."""
        return self._is_for_ever and isinstance(error, NoObservationError)

    def _act(self) -> None: ...


class ControllerStops(InjectedFault):
    """The joints stay where they are, whatever they are commanded."""

    title = "a controller that stops"
    until, longest_s = "let go", 4.5

    def explains(self, error: Exception) -> bool:
        """See `InjectedFault`."""
        return isinstance(error, StuckError) and not isinstance(error, GripperError)

    def _act(self) -> None:
        self._arm.stop()


class GraspFails(InjectedFault):
    """The fingers do not close, or have no friction."""

    title = "a grasp that always fails"

    def __init__(self, arm: FaultyArm, drawn: Drawn, rng: np.random.Generator) -> None:
        super().__init__(arm, drawn, rng)
        self._is_jam = bool(rng.random() < 0.5)

    def explains(self, error: Exception) -> bool:
        """See `InjectedFault`."""
        if isinstance(error, GripperError):
            return self._is_jam
        if not isinstance(error, ManipulationError):
            return False
        # After such a try, planning the next one may have failed.
        return (error.done or error.after) in NOT_HELD

    def _act(self) -> None:
        if self._is_jam:
            self._arm.is_jammed = True
        else:
            self._arm.make_slippery()


FAULTS: dict[str, type[InjectedFault]] = {
    "block_moved": BlockMoved,
    "block_pushed_out": BlockPushedOut,
    "stack_toppled": StackToppled,
    "goal_taken": GoalTaken,
    "camera_dark": CameraDark,
    "scene_frozen": SceneFrozen,
    "controller_stops": ControllerStops,
    "grasp_fails": GraspFails,
}
"""Faults by name. Append new ones: what is drawn depends on the position."""


class FaultyCamera(SimulatedCamera):
    """A camera whose images a fault can change."""

    def __init__(
        self, renderer: Renderer, arm: FaultyArm, camera: Camera, fault: InjectedFault
    ) -> None:
        super().__init__(renderer, arm, camera)
        self._fault = fault

    def take(self) -> RgbdImage:
        """See `CameraSource`."""
        return self._fault.picture(super().take())
