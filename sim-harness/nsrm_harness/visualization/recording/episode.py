"""Records a demonstration as Rerun entities; `docs/arm/README.md` lists them."""

from __future__ import annotations

from collections.abc import Sequence

import nsrm
import numpy as np
import rerun as rr

from nsrm_harness.geometry.camera import Camera
from nsrm_harness.geometry.cuboid import Cuboid
from nsrm_harness.geometry.pose import Pose
from nsrm_harness.perception.observer import ObjectNames, Observation, sub_goal
from nsrm_harness.simulation.world import TABLE_HIGH, TABLE_LOW, World
from nsrm_harness.visualization.demo_listener import DemoListener, StepResult, Stopped
from nsrm_harness.visualization.recording.motion import AXES_M, Motion
from nsrm_harness.visualization.recording.scene import RecordedScene
from nsrm_harness.visualization.recording.shapes import RGB, boxes, frame
from nsrm_harness.visualization.recording.timeline import Log
from nsrm_harness.visualization.recording.view import View

WORLD, TABLE, SUB_GOALS = "world", "world/table", "world/sub_goals"
PLAN, EVENTS = "plan", "events"
TABLE_RGB: RGB = (0.65, 0.6, 0.55)

UNPLANNED = ("not grasped", "slipped", "put back", "clearing")
"""Events that happen only if something goes wrong."""


class Recording(DemoListener):
    """A listener that records all events."""

    def __init__(self, stream: rr.RecordingStream) -> None:
        self._stream = stream
        self._steps: Sequence[nsrm.PlannedStep] = ()
        self._sight: Observation | None = None

    def begin(self, world: World, camera: Camera, known: ObjectNames, sentence: str) -> None:
        """Records the table and the sentence."""
        self._log, self._sentence = Log(self._stream, world), sentence
        self._scene = RecordedScene(self._log, known)
        self._view = View(self._log, camera, self._scene)
        self._motion = Motion(self._log, self._scene)
        self._log.always(WORLD, rr.ViewCoordinates.RIGHT_HAND_Z_UP)
        size_m = np.subtract(TABLE_HIGH, TABLE_LOW)
        self._log.always(TABLE, rr.Boxes3D(mins=[TABLE_LOW], sizes=[size_m], colors=[TABLE_RGB]))
        self._event(f"sentence: {sentence}")

    def looked(self, sight: Observation) -> None:
        """Records the image and the objects seen in it."""
        if self._sight is not None and sight.taken_s <= self._sight.taken_s:
            return  # Nothing has moved since then.
        self._sight = sight
        self._scene.seen(sight.cuboids)
        self._view.show(sight)
        if self._steps:
            self._view.ground(sight, self._steps)
        self._motion.look()

    def refused(self, refusal: nsrm.Refused) -> None:
        """Records why there is no plan."""
        self._say(f"Refused: {refusal}")
        self._event(f"refused: {refusal}", rr.TextLogLevel.ERROR)

    def planned(self, plan: nsrm.Plan) -> None:
        """Records the program, its objects and their sub-goals."""
        assert self._sight is not None
        self._steps = plan.steps
        program = [f"`{line}`" for line in plan.program.notation.splitlines()]
        self._say(*program, *(step.explanation for step in plan.steps))
        self._view.ground(self._sight, plan.steps)
        for index, step in enumerate(plan.steps, start=1):
            number = step.object_id
            moved = Cuboid(Pose((0.0, 0.0, 0.0)), self._sight.cuboids[number].edges_m)
            label = f"sub-goal {index}"
            self._log.now(
                f"{SUB_GOALS}/step_{index}",
                frame(sub_goal(step)),
                rr.TransformAxes3D(AXES_M),
                boxes([moved], [label], [self._scene.rgb(number)]),
            )

    def mark(self, event: str) -> None:
        """Records what the arm did."""
        if event == "grasped":
            self._motion.grasped()
        level = rr.TextLogLevel.WARN if event in UNPLANNED else rr.TextLogLevel.INFO
        self._event(event, level)

    def ended(self, index: int, outcome: StepResult) -> None:
        """Records how a step ended."""
        level = rr.TextLogLevel.ERROR if isinstance(outcome, Stopped) else rr.TextLogLevel.INFO
        self._event(f"step {index + 1}: {outcome}", level)

    def end(self) -> None:
        """Records the last sample."""
        self._motion.look()
        self._motion.write()

    def _event(self, text: str, level: rr.TextLogLevel = rr.TextLogLevel.INFO) -> None:
        self._log.now(EVENTS, rr.TextLog(text, level=level))

    def _say(self, *paragraphs: str) -> None:
        text = "\n\n".join((f"> {self._sentence}", *paragraphs))
        self._log.now(PLAN, rr.TextDocument(text, media_type=rr.MediaType.MARKDOWN))
