"""Records the scene that the arm assumes from images and fingers alone: the objects on the table,
the one in the hand, and the arm's distance to them."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import combinations

import rerun as rr

from nsrm_harness.geometry import panda
from nsrm_harness.geometry.cuboid import Cuboid
from nsrm_harness.geometry.pose import Pose
from nsrm_harness.manipulation.bodies import link_convex_hulls
from nsrm_harness.manipulation.collision import HELD, CollisionChecker, Nearest
from nsrm_harness.manipulation.kinematics import Joints, Kinematics
from nsrm_harness.perception.observer import ObjectNames
from nsrm_harness.visualization.recording.shapes import RGB, boxes
from nsrm_harness.visualization.recording.timeline import Log

OBJECTS = "world/objects"
IN_HAND = f"world/arm/{panda.HAND_FRAME}/held"
UNKNOWN_RGB: RGB = (0.6, 0.6, 0.6)
"""Colour of objects that appeared after the objects were named."""


class RecordedScene:
    """The objects between two images."""

    def __init__(self, log: Log, known: ObjectNames) -> None:
        self._log, self._known, self._kinematics = log, known, Kinematics()
        self._standing: dict[int, Cuboid] = {}
        self._held: tuple[int, Cuboid] | None = None
        self._guard = self._watching(None)

    def name(self, number: int) -> str:
        """The name of an object for people."""
        return f"object {number} ({self._known.words.get(number, 'new')})"

    def rgb(self, number: int) -> RGB:
        """The colour in which an object is drawn."""
        return self._known.colors.get(number, UNKNOWN_RGB)

    def seen(self, cuboids: Mapping[int, Cuboid]) -> None:
        """Sets all objects on the table, from an image."""
        self._standing = dict(cuboids)
        self._change(None)

    def grasp(self, hand: Pose) -> None:
        """Moves the object that is closest to the fingertips into the hand."""
        tip = hand @ Pose((0.0, 0.0, panda.FINGERTIP_M))
        number = min(self._standing, key=lambda key: self._standing[key].pose.distance_m(tip))
        cuboid = self._standing.pop(number)
        in_hand = Cuboid(hand.inverse() @ cuboid.pose, cuboid.edges_m)
        self._change((number, in_hand))

    def let_go(self, hand: Pose) -> None:
        """Puts the held object down where the hand is."""
        if self._held is not None:
            number, in_hand = self._held
            self._standing[number] = Cuboid(hand @ in_hand.pose, in_hand.edges_m)
            self._change(None)

    def lose(self) -> None:
        """Removes the held object, whose place is now unknown."""
        if self._held is not None:
            self._change(None)

    def nearest(self, joints: Joints, opening_m: float) -> Nearest:
        """The smallest distance of the arm and the held object to the other objects and the table;
        0 in contact, also with the object being grasped or the support at release."""
        return self._guard.nearest(joints, opening_m)

    def _change(self, held: tuple[int, Cuboid] | None) -> None:
        if held is not None:
            self._log.now(IN_HAND, self._boxes(dict([held])))
        elif self._held is not None:
            self._log.now(IN_HAND, rr.Clear(recursive=False))
        self._held = held
        self._log.now(OBJECTS, self._boxes(self._standing))
        self._guard = self._watching(held and held[1])

    def _watching(self, in_hand: Cuboid | None) -> CollisionChecker:
        objects = {self.name(number): cuboid for number, cuboid in self._standing.items()}
        return CollisionChecker(
            self._kinematics, objects, in_hand, combinations([*link_convex_hulls(), HELD], 2)
        )

    def _boxes(self, cuboids: Mapping[int, Cuboid]) -> rr.Boxes3D:
        names = [self.name(number) for number in cuboids]
        colors = [self.rgb(number) for number in cuboids]
        return boxes([*cuboids.values()], names, colors, solid=True)
