"""Records the arm over time: its links, the opening of its fingers, its joint speeds, and its
distance to other objects."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import rerun as rr

from nsrm_harness.geometry import panda
from nsrm_harness.geometry.pose import Pose
from nsrm_harness.manipulation.bodies import link_convex_hulls
from nsrm_harness.manipulation.execute import SLIP_M
from nsrm_harness.manipulation.kinematics import Joints
from nsrm_harness.simulation.arm_world import ArmWorld
from nsrm_harness.simulation.world import TIME_STEP_S
from nsrm_harness.visualization.recording.scene import RecordedScene
from nsrm_harness.visualization.recording.timeline import TIMELINE, Log, duration

SAMPLE_S = 0.02
"""Simulated time between two samples of the arm."""
AXES_M = 0.05
"""Length of drawn axes."""

ARM, DISTANCE, PAIR = "world/arm", "distances/nearest_m", "distances/pair"
OPENING, SPEEDS = "hand/opening_m", "joints/speeds_rad_s"


@dataclass(frozen=True, eq=False)
class _Moment:
    """A sample of the arm. Without motors it has only `links`."""

    time_s: float
    links: dict[str, Pose]
    joints: Joints | None = None
    opening_m: float = 0.0
    distance_m: float = 0.0


class Motion:
    """Samples the arm of a world in its ticks."""

    def __init__(self, log: Log, scene: RecordedScene) -> None:
        self._log, self._world, self._scene = log, log.world, scene
        self._moments: list[_Moment] = []
        self._ticks, self._pair = 0, ""
        self._held_m: float | None = None
        for link, hull in link_convex_hulls().items():
            log.always(
                f"{ARM}/{link}",
                rr.Mesh3D(
                    vertex_positions=hull.vertices,
                    vertex_normals=hull.vertex_normals,
                    triangle_indices=hull.faces,
                    albedo_factor=(220, 220, 225),
                ),
            )
        log.always(f"{ARM}/{panda.HAND_FRAME}", rr.TransformAxes3D(AXES_M))
        if isinstance(log.world, ArmWorld):
            names = [f"joint {number}" for number in range(1, panda.JOINTS + 1)]
            log.always(SPEEDS, rr.SeriesLines(names=names))
            self._others_tick = log.world.on_tick
            log.world.on_tick = self._tick

    def grasped(self) -> None:
        """The fingers have grasped something."""
        if isinstance(self._world, ArmWorld):
            self._held_m = self._world.opening_m()
            self._scene.grasp(self._world.arm_links()[panda.HAND_FRAME])

    def look(self) -> None:
        """Takes a sample."""
        world = self._world
        if self._moments and world.time_s <= self._moments[-1].time_s:
            return
        links = world.arm_links()
        if not isinstance(world, ArmWorld):
            self._moments.append(_Moment(world.time_s, links))
            return
        joints, opening_m = world.joints(), world.opening_m()
        self._feel(opening_m, links[panda.HAND_FRAME])
        nearest = self._scene.nearest(joints, opening_m)
        pair = " and ".join(sorted(nearest.pair))
        if pair != self._pair:
            self._log.now(PAIR, rr.TextLog(pair))
            self._pair = pair
        moment = _Moment(world.time_s, links, joints, opening_m, nearest.distance_m)
        self._moments.append(moment)

    def write(self) -> None:
        """Writes all samples at the end."""
        times = np.array([moment.time_s for moment in self._moments])
        index = [rr.TimeColumn(TIMELINE, duration=[duration(time_s) for time_s in times])]
        stream = self._log.stream
        for link in self._moments[0].links:
            poses = [moment.links[link] for moment in self._moments]
            columns = rr.Transform3D.columns(
                translation=[pose.position for pose in poses],
                quaternion=[pose.orientation for pose in poses],
            )
            stream.send_columns(f"{ARM}/{link}", index, columns)
        joints = [moment.joints for moment in self._moments if moment.joints is not None]
        if not joints:
            return
        # The first sample has none.
        turns = np.diff(joints, axis=0, prepend=joints[:1])
        speeds = turns / np.diff(times, prepend=times[0] - SAMPLE_S)[:, None]
        columns = rr.Scalars.columns(scalars=speeds).partition([panda.JOINTS] * len(times))
        stream.send_columns(SPEEDS, index, columns)
        for entity, values in (
            (OPENING, [moment.opening_m for moment in self._moments]),
            (DISTANCE, [moment.distance_m for moment in self._moments]),
        ):
            stream.send_columns(entity, index, rr.Scalars.columns(scalars=values))

    def _tick(self) -> None:
        self._others_tick()
        if self._ticks % round(SAMPLE_S / TIME_STEP_S) == 0:
            self.look()
        self._ticks += 1

    def _feel(self, opening_m: float, hand: Pose) -> None:
        """Checks, as the arm itself does, whether the held object is still held."""
        if self._held_m is None:
            return
        if opening_m > self._held_m + SLIP_M:
            self._scene.let_go(hand)
        elif opening_m < self._held_m - SLIP_M:
            self._scene.lose()
        else:
            return
        self._held_m = None
