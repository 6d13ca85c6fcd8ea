"""Runs a simulated world as a process of a robot: its camera with the detector, and its
controller."""

from __future__ import annotations

import threading
import time
from collections.abc import Mapping

from nsrm_harness.data.tabletop import tabletop
from nsrm_harness.domain import Domain
from nsrm_harness.geometry.camera import Camera, default_camera
from nsrm_harness.geometry.cuboid import Cuboid
from nsrm_harness.geometry.pose import Vector3
from nsrm_harness.nodes.arm_mover import ArmMover, SceneMonitor, Supervisor
from nsrm_harness.nodes.config import RobotConfig
from nsrm_harness.nodes.controller import Controller, Mover, stops_first
from nsrm_harness.nodes.messages import CameraFrame, CameraMessage, Role, State, SubGoal
from nsrm_harness.nodes.ports import (
    CommandsIn,
    FeedbackOut,
    FramesOut,
    Heartbeats,
    RobotServices,
    now_ns,
)
from nsrm_harness.nodes.teleport_mover import TeleportMover
from nsrm_harness.perception.observer import Observer
from nsrm_harness.perception.relief import PerceptionError
from nsrm_harness.simulation.arm_world import ArmWorld
from nsrm_harness.simulation.render import Renderer
from nsrm_harness.simulation.simulated_camera import SimulatedCamera
from nsrm_harness.simulation.world import World

FRAME_S = 0.1
"""Shortest time between two frames."""
HIDDEN = 2
"""`covered` of a box of whose object nothing is visible."""
CLEANUP_FRAMES = 2
"""Number of frames between two checks for dead nodes."""


class SimulatedRobot:
    """The tabletop of a seed, observed and moved only through messages."""

    def __init__(
        self,
        domain: Domain,
        renderer: Renderer,
        seed: int,
        config: RobotConfig,
        *,
        with_arm: bool,
    ) -> None:
        """Raises `PortError` if the robot already has a camera or a controller."""
        self._camera = default_camera()
        self._robot = RobotServices(config, "controller")
        self._commands = CommandsIn(self._robot)
        self._feedback = FeedbackOut(self._robot)
        self._frames = FramesOut(self._robot, self._camera.width, self._camera.height)
        self._life = Heartbeats(self._robot, Role.CONTROLLER)
        self._listener = self._robot.listener("sub_goal")
        self._seen: Mapping[int, Cuboid] = {}
        self._sequence = 0
        scene = tabletop(domain, seed)
        self.sentence = scene.sentence
        """A sentence that fits the scene."""
        self.world = ArmWorld() if with_arm else World()
        self.world.spawn(scene.arrangement.blocks, scene.arrangement.poses)
        self.world.settle()
        self._observer = Observer(SimulatedCamera(renderer, self.world, self._camera))
        self._ending = threading.Event()
        self._waiting: list[SubGoal] = []
        self._arm = self._arm_of(self.world) if isinstance(self.world, ArmWorld) else None
        mover: Mover = self._arm or TeleportMover(self.world, self._position)
        self._controller = Controller(mover, self._feedback.say, self._life.reject, now_ns)

    def _arm_of(self, world: ArmWorld) -> ArmMover:
        arm = ArmMover(
            world,
            SceneMonitor(self._look_again, lambda: world.time_s, lambda: self._seen),
            Supervisor(self._work, self._is_stopped),
        )
        world.on_tick = arm.tick
        return arm

    def close(self) -> None:
        """Closes the world."""
        self.world.close()

    def run(self, stop: threading.Event) -> None:
        """Publishes frames and executes commands until `stop` is set; then the arm stands still."""
        self._ending = stop
        while not stop.is_set():
            begun_s = time.monotonic()
            self.turn()
            rest_s = FRAME_S - (time.monotonic() - begun_s)
            if rest_s > 0:
                stop.wait(rest_s)

    def turn(self) -> None:
        """Executes the waiting commands, then takes an image and publishes it."""
        self._life.beat(State.IDLE)
        self._hear()
        while self._waiting:
            self._waiting = stops_first(self._waiting)
            self._controller.obey(self._waiting.pop(0))
            self._work()
        if self._ending.is_set():
            return
        if self._arm is not None:
            self._arm.tidy_up()
        self._look_on()
        if self._sequence % CLEANUP_FRAMES == 0:
            self._robot.cleanup_dead_nodes()

    def _work(self) -> None:
        self._life.beat(State.BUSY)

    def _hear(self) -> None:
        self._waiting += self._commands

    def _is_stopped(self) -> bool:
        self._hear()
        return self._ending.is_set() or self._controller.is_stopped_by(self._waiting)

    def _look_again(self) -> Mapping[int, Cuboid]:
        self.look()
        return self._seen

    def _position(self, number: int) -> Vector3 | None:
        seen = self._seen.get(number)
        return None if seen is None else seen.pose.position

    def _look_on(self) -> None:
        """Publishes a frame, if objects can be found in it; otherwise scenes become too old, which
        the planner reports."""
        try:
            self.look()
        except PerceptionError as error:
            self._life.reject("camera", str(error))

    def look(self) -> None:
        """Publishes an image with its detections. Raises `PerceptionError`."""
        taken_ns = now_ns()
        sight = self._observer.look(self._arm.held if self._arm is not None else ())
        self._seen = sight.cuboids
        self._sequence += 1
        header = CameraFrame(
            sequence=self._sequence,
            timestamp_ns=taken_ns,
            camera=_camera_message(self._camera),
        )
        header.count = min(len(sight.whole), len(header.boxes))
        for box, (number, whole) in zip(header.boxes, sight.whole.items(), strict=False):
            box.id, box.covered = number, number in sight.covered
            if number not in sight.locations:
                box.covered = HIDDEN
            box.visible[:] = sight.locations.get(number, whole)[:4].tolist()
            box.location[:] = whole.tolist()
        self._frames.send(header, sight.rgb, sight.depth)


def _camera_message(camera: Camera) -> CameraMessage:
    message = CameraMessage(
        width=camera.width,
        height=camera.height,
        fx=camera.fx,
        fy=camera.fy,
        cx=camera.cx,
        cy=camera.cy,
    )
    message.position[:] = camera.position
    message.orientation[:] = camera.orientation
    return message
