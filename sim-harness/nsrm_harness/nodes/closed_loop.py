"""The closed loop within one process: connects the executive to a camera and an arm. A robot's
planner process (`nsrm serve`) runs the same executive."""

from __future__ import annotations

import logging
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field, replace
from typing import Literal, Protocol

import nsrm
import numpy as np
from numpy.typing import NDArray

from nsrm_harness.common.errors import HarnessError
from nsrm_harness.geometry.camera import Camera
from nsrm_harness.geometry.cuboid import Cuboid
from nsrm_harness.manipulation.errors import RefusedError
from nsrm_harness.manipulation.execute import ExecutionResult, Mark, unmarked
from nsrm_harness.manipulation.observing import PAUSE_S, NoObservationError
from nsrm_harness.manipulation.pick_and_place import PickAndPlacePlanner
from nsrm_harness.manipulation.retries import ManipulationError, SubGoalReached
from nsrm_harness.manipulation.robot_interface import RobotInterface, wait
from nsrm_harness.nodes.arm_mover import ArmMover, SceneMonitor, Supervisor, nothing, numbered
from nsrm_harness.nodes.controller import Answer, Tell
from nsrm_harness.nodes.messages import Kind, Outcome, SubGoal
from nsrm_harness.perception.observer import Observation, Observer
from nsrm_harness.perception.relief import PerceptionError

NS_PER_S = 1_000_000_000

_LOG = logging.getLogger(__name__)
# Failures are raised as exceptions; to see the retries too, configure this logger.
_LOG.addHandler(logging.NullHandler())


class LoopMover(Protocol):
    """Moves objects, and keeps the result of the last command in more detail than an `Answer`."""

    @property
    def result(self) -> SubGoalReached | HarnessError | None:
        """How the last command went; None if it was not started."""
        ...

    def __call__(self, command: SubGoal, tell: Tell) -> Answer:
        """Moves the object of a command to its goal."""
        ...


class _Clock:
    """An observer's time in nanoseconds, strictly increasing, also within one tick."""

    def __init__(self, now_s: Callable[[], float]) -> None:
        self._now_s, self._last_ns = now_s, 0

    def __call__(self) -> int:
        self._last_ns = max(round(self._now_s() * NS_PER_S), self._last_ns + 1)
        return self._last_ns


class _Scenes:
    """Turns observations into scenes. A covered object has the location and the appearance that it
    had when it was seen whole."""

    def __init__(self, model: nsrm.Model, camera: Camera) -> None:
        self._model, self._camera = model, camera
        self._looks: dict[int, NDArray[np.float32]] = {}

    def of(self, seen: Observation) -> nsrm.Scene:
        scene = seen.scene(self._model, self._camera)
        looks = dict(zip(seen.locations, scene.embeddings, strict=True))
        for number, look in looks.items():
            if number not in seen.covered or number not in self._looks:
                self._looks[number] = look
        numbers = [number for number in seen.whole if number in self._looks]
        whole = np.array([seen.whole[number] for number in numbers], np.float32).reshape(-1, 5)
        embeddings = [self._looks[number] for number in numbers]
        return self._model.scene_from_embeddings(
            numbers,
            np.ascontiguousarray(whole[:, :4]),
            np.ascontiguousarray(whole[:, 4]),
            np.array(embeddings, np.float32).reshape(-1, scene.embeddings.shape[1]),
            nsrm.Camera(**asdict(self._camera)),
        )


@dataclass
class _Latest:
    """The latest observation.

    * `taken_ns`: when its image was taken, by the loop's clock
    * `is_told`: whether the executive has seen it
    """

    seen: Observation
    taken_ns: int
    is_told: bool = False


@dataclass
class ClosedLoop:
    """Executes sentences with one arm and one camera.

    * `planner`: plans the arm's motions
    * `limits`: limits of the executive
    * `name`: the name of an object, by its number
    * `looked`: called with each observation
    * `begin`, `end`: called with the index of a step before and after each command for it
    * `reached`: called with the index of a step and how its sub-goal was reached
    * `mover`: executes the commands instead of the arm that the camera guides
    * `performed`: all sub-goals that were reached; `tries` counts the commands for each
    """

    body: RobotInterface
    planner: PickAndPlacePlanner
    observer: Observer
    model: nsrm.Model
    name: Callable[[int], str] = numbered
    mark: Mark = unmarked
    limits: nsrm.Limits = field(default_factory=nsrm.Limits)
    looked: Callable[[Observation], object] = nothing
    begin: Callable[[int], object] = nothing
    end: Callable[[int], None] = nothing
    reached: Callable[[int, SubGoalReached], None] = nothing
    mover: LoopMover | None = None
    performed: list[SubGoalReached] = field(default_factory=list, init=False)

    def __post_init__(self) -> None:
        self._clock = _Clock(lambda: self.observer.now_s)
        self._scenes = _Scenes(self.model, self.observer.camera)
        self._latest: _Latest | None = None
        self._blind: PerceptionError | None = None
        self._tries: Counter[int] = Counter()
        self._failed: dict[int, ExecutionResult] = {}
        self._arm = ArmMover(
            self.body,
            SceneMonitor(self._look, lambda: self.observer.now_s, self.seen),
            Supervisor(mark=self.mark),
            planner=self.planner,
            name=self.name,
            log=_LOG,
        )

    @property
    def _mover(self) -> LoopMover:
        return self.mover or self._arm

    def seen(self) -> Mapping[int, Cuboid]:
        """All objects that are assumed to be there, by number, as of the latest observation."""
        return {} if self._latest is None else self._latest.seen.cuboids

    def follow(
        self, sentence: str, mode: Literal["closed_loop", "open_loop"] = "closed_loop"
    ) -> None:
        """Executes a sentence to its end.

        Raises `nsrm.Refused` if it has no plan, `RefusedError` if a sub-goal cannot be reached as
        things stand, and `ManipulationError` if it was tried and failed; the arm is in its ready
        pose then. Raises `StuckError` if the arm stopped where it is.
        """
        executive = nsrm.Executive(self.model, self.limits, first_plan=self._clock())
        executive.ask(sentence, mode)
        self._tries.clear()
        self._failed.clear()
        while True:
            event = self._poll(executive)
            if isinstance(event, nsrm.Waiting):
                self._observe_for(executive)
            elif isinstance(event, nsrm.Command):
                self._carry_out(executive, event)
            elif isinstance(event, nsrm.Ended):
                if event.why is not None:
                    raise self._error(event.why) from None
                return

    def _poll(self, executive: nsrm.Executive) -> nsrm.Event:
        """The executive's next event other than `Working`."""
        while True:
            event = executive.poll(self._clock())
            if not isinstance(event, nsrm.Working):
                return event

    def _observe_for(self, executive: nsrm.Executive) -> None:
        """Gives the executive the latest observation, or waits and makes a new one."""
        latest = self._latest
        if latest is None or latest.is_told or self._blind is not None:
            if latest is not None or self._blind is not None:
                wait(self.body, PAUSE_S)
            try:
                latest = self._observe()
            except PerceptionError as error:
                self._blind = error
                return
        self._tell(executive, latest)

    def _tell(self, executive: nsrm.Executive, latest: _Latest) -> None:
        latest.is_told = True
        executive.on_scene(self._scenes.of(latest.seen), latest.taken_ns, self._clock())

    def _observe(self) -> _Latest:
        """Observes; a frozen camera gives its old image again. Raises `PerceptionError`."""
        now_ns, begun_s = self._clock(), self.observer.now_s
        seen = self.observer.look()
        latest = self._latest
        if seen.taken_s >= begun_s:
            self._blind = None
            taken_ns = now_ns
        elif latest is not None and seen.taken_s == latest.seen.taken_s:
            taken_ns = latest.taken_ns
        else:
            taken_ns = round(seen.taken_s * NS_PER_S)
        self._latest = _Latest(seen, taken_ns)
        self.looked(seen)
        return self._latest

    def _look(self) -> Mapping[int, Cuboid]:
        """Observes for the arm; an old image is an error. Raises `PerceptionError`."""
        begun_s = self.observer.now_s
        latest = self._observe()
        if latest.seen.taken_s < begun_s:
            age_s = self.observer.now_s - latest.seen.taken_s
            raise PerceptionError(f"the camera's image is {age_s:.1f} s old")
        return latest.seen.cuboids

    def _carry_out(self, executive: nsrm.Executive, command: nsrm.Command) -> None:
        self._tries[command.step] += 1
        self.begin(command.step)
        try:
            # The executive is not polled meanwhile, so feedback in between takes effect at the end.
            answer = self._mover(
                _message(command), lambda told: self._hear(executive, command, told)
            )
            result = self._mover.result
            if isinstance(result, NoObservationError):
                raise result
            if isinstance(result, SubGoalReached):
                self._note_reached(command.step, result)
            elif isinstance(result, ManipulationError) and (done := result.done or result.after):
                self._failed[command.step] = done
        finally:
            self.end(command.step)
        self._hear(executive, command, answer)

    def _note_reached(self, step: int, result: SubGoalReached) -> None:
        self._failed.pop(step, None)
        result = replace(result, tries=self._tries.pop(step))
        self.performed.append(result)
        self.reached(step, result)

    def _hear(self, executive: nsrm.Executive, command: nsrm.Command, answer: Answer) -> None:
        """Passes the mover's feedback on.

        The end of a command is dated before the latest image: the arm has stood still since.
        """
        now_ns = self._clock()
        at_ns = now_ns
        if answer.outcome is not Outcome.CLEARING and self._latest is not None:
            at_ns = min(now_ns, self._latest.taken_ns - 1)
        one, other = (*answer.objects, 0, 0)[:2]
        executive.on_feedback(
            command.plan,
            command.command,
            answer.outcome,
            now_ns,
            at_ns=at_ns,
            objects=(one, other),
        )

    def _error(self, why: nsrm.Failure) -> Exception:
        """The exception for a failure; the arm's own where the arm failed."""
        if why.refusal is not None:
            return why.refusal
        if why.kind == "no_scene":
            return NoObservationError(f"{self._blind or why}; giving up")
        result = self._mover.result
        if why.kind == "unsuccessful" and why.step is not None and isinstance(result, HarnessError):
            return self._after_others(why.step, result)
        what = f"{why}" if why.object_id is None else f"{self.name(why.object_id)}: {why}"
        return ManipulationError(what, ExecutionResult.PLACED)

    def _after_others(self, step: int, error: HarnessError) -> HarnessError:
        """The arm's error, with how its earlier tries ended."""
        tries, before = self._tries[step], self._failed.get(step)
        if isinstance(error, RefusedError) and before is not None:
            what = f"{before.value} at try {tries - 1}, and now {error}"
            return ManipulationError(what, why=error.why, after=before)
        if type(error) is ManipulationError and tries > 1:
            what = f"try {tries}: {error.what}"
            return ManipulationError(what, error.done, error.why, error.shifted, error.after)
        return error


def _message(command: nsrm.Command) -> SubGoal:
    """The command as the message that a controller process receives."""
    message = SubGoal(
        plan=command.plan,
        until_ns=command.until_ns,
        command=command.command,
        kind=Kind.MOVE,
        step=command.step,
        steps=command.steps,
        object_id=command.object_id,
        reference_id=command.reference_id,
        confidence=command.confidence,
    )
    message.position[:] = command.position
    message.orientation[:] = command.orientation
    message.location[:] = command.location.tolist()
    message.keep[: len(command.keep)] = command.keep
    return message
