"""The Franka Panda from PyBullet's data: poses and meshes of its links."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from xml.etree import ElementTree

import numpy as np

from nsrm_harness.geometry.mesh import Mesh, load_obj
from nsrm_harness.geometry.panda import MAX_OPENING_M, READY_RAD, URDF
from nsrm_harness.geometry.pose import Pose
from nsrm_harness.simulation.bullet import connect_direct, pybullet

REST_JOINTS_RAD: tuple[float, ...] = tuple(READY_RAD.tolist())
"""The hand is 0.49 m above the table at x = 0.31, outside the camera's view of the workspace."""

FINGER_REST_M = MAX_OPENING_M / 2
"""Distance of each open finger from the middle."""

BASE_LINK = "panda_link0"


@dataclass(frozen=True, eq=False)
class LinkVisual:
    """The visual of one link: meshes in the link's frame."""

    link: str
    meshes: tuple[Mesh, ...]
    center: np.ndarray
    """Centre of the bounding sphere `[3]`, in the link's frame, metres."""
    radius_m: float


@lru_cache(maxsize=1)
def link_visuals() -> tuple[LinkVisual, ...]:
    """The visual meshes named in the URDF, loaded once per process."""
    visuals = []
    for link in ElementTree.parse(URDF).getroot().iter("link"):
        meshes: list[Mesh] = []
        for visual in link.iter("visual"):
            shape = visual.find("geometry/mesh")
            if shape is None:
                continue
            path = URDF.parent / shape.attrib["filename"].removeprefix("package://")
            meshes += [_placed(mesh, visual.find("origin")) for mesh in load_obj(path)]
        if meshes:
            low = np.min([mesh.bounds_m()[0] for mesh in meshes], axis=0)
            high = np.max([mesh.bounds_m()[1] for mesh in meshes], axis=0)
            radius = float(np.linalg.norm(high - low)) / 2
            visuals.append(LinkVisual(link.attrib["name"], tuple(meshes), (low + high) / 2, radius))
    return tuple(visuals)


def _placed(mesh: Mesh, origin: ElementTree.Element | None) -> Mesh:
    """The mesh in the link's frame; this URDF rotates visuals only about z."""
    if origin is None:
        return mesh
    offset = np.array([float(v) for v in origin.get("xyz", "0 0 0").split()], np.float32)
    roll, pitch, yaw = (float(v) for v in origin.get("rpy", "0 0 0").split())
    if roll or pitch:
        raise ValueError(f"{URDF}: a visual is rotated about x or y, which is not supported")
    turn = np.array(
        [[np.cos(yaw), -np.sin(yaw), 0], [np.sin(yaw), np.cos(yaw), 0], [0, 0, 1]], np.float32
    )
    return Mesh(mesh.vertices @ turn.T + offset, mesh.normals @ turn.T, mesh.triangles, mesh.rgb)


@lru_cache(maxsize=1)
def rest_links() -> tuple[tuple[str, Pose], ...]:
    """The frame of each link in the world, by name, when the arm is at rest.

    Computed once per process, in a separate client that is then closed.
    """
    client = connect_direct()
    try:
        robot = pybullet.loadURDF(
            str(URDF),
            useFixedBase=True,
            flags=pybullet.URDF_IGNORE_VISUAL_SHAPES | pybullet.URDF_IGNORE_COLLISION_SHAPES,
            physicsClientId=client,
        )
        revolute = iter(REST_JOINTS_RAD)
        names = []
        for joint in range(pybullet.getNumJoints(robot, physicsClientId=client)):
            info = pybullet.getJointInfo(robot, joint, physicsClientId=client)
            if info[2] == pybullet.JOINT_REVOLUTE:
                angle = next(revolute)
                pybullet.resetJointState(robot, joint, angle, physicsClientId=client)
            elif info[2] == pybullet.JOINT_PRISMATIC:
                pybullet.resetJointState(robot, joint, FINGER_REST_M, physicsClientId=client)
            names.append(info[12].decode())
        states = pybullet.getLinkStates(
            robot, list(range(len(names))), computeForwardKinematics=1, physicsClientId=client
        )
    finally:
        pybullet.disconnect(physicsClientId=client)
    links = [(BASE_LINK, Pose((0.0, 0.0, 0.0)))]
    # Entries 4 and 5: the link's frame; 0 and 1 would be its centre of mass.
    for name, state in zip(names, states, strict=True):
        links.append((name, Pose(tuple(state[4]), tuple(state[5]))))
    return tuple(links)
