"""A robot's services, the same as in `nsrm_ipc::service`.

Ports belong to the process that opened them: a process that uses them must not fork.
"""

from __future__ import annotations

import contextlib
import ctypes
import logging
import os
import re
import time
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nsrm_harness.common.errors import HarnessError
from nsrm_harness.nodes.config import RobotConfig, iox2
from nsrm_harness.nodes.controller import Answer
from nsrm_harness.nodes.leftovers import SEGMENTS, remove_segments
from nsrm_harness.nodes.messages import (
    FRAMES_AT_ONCE,
    ONLOOKERS,
    QUALITIES,
    ROOM,
    CameraFrame,
    Feedback,
    Heartbeat,
    SubGoal,
)

BEAT_NS = 100_000_000
"""Time between two heartbeats."""
IN_FLUX_S = 4.0
"""Timeout for services that others are creating, and for slots of dead nodes."""
BETWEEN_TRIES_S = 0.01
LINE_NS = 1_000_000_000
"""Shortest time between two log lines about rejected messages."""
NAME = re.compile(r"[a-z0-9_-]{1,32}")


_LOG = logging.getLogger(__name__)


class PortError(HarnessError):
    """A service cannot be used."""


_clock = time.monotonic_ns


def now_ns() -> int:
    """The time by the common clock of a robot's processes (`nsrm_ipc::clock`): the machine's
    monotonic clock, or the wall clock after `use_wall_clock`."""
    return _clock()


def use_wall_clock() -> None:
    """Switches this process to the clock that several hosts synchronise."""
    global _clock
    _clock = time.time_ns


class RobotServices:
    """A robot process's node, which opens the robot's services."""

    def __init__(self, config: RobotConfig, role: str) -> None:
        """Raises `PortError` for an invalid robot name, and if processes cannot meet."""
        name, shared_memory = config.robot, config.shared_memory or iox2.config.global_config()
        if config.several_hosts:
            use_wall_clock()
        if NAME.fullmatch(name) is None:
            raise PortError(
                f"{name!r}: a robot's name has 1 to 32 characters: a to z, 0 to 9, '-' and '_'"
            )
        self.name = name
        self._find_room("node", ROOM)
        self._several_hosts = config.several_hosts
        places = shared_memory.global_cfg
        # Only `cleanup_dead_nodes` cleans up dead nodes; it first checks whether that would hang.
        places.node.cleanup_dead_nodes_on_creation = False
        places.node.cleanup_dead_nodes_on_destruction = False
        places.service.cleanup_dead_nodes_on_open = False
        self._prefix = places.prefix.to_string()
        self._folder = Path(places.root_path.to_string())
        builder = (
            iox2.NodeBuilder.new()
            .name(iox2.NodeName.new(f"nsrm/{name}/{role}"))
            # Python handles signals: KeyboardInterrupt.
            .signal_handling_mode(iox2.SignalHandlingMode.Disabled)
            .config(shared_memory)
        )
        try:
            self._node = builder.create(iox2.ServiceType.Ipc)
        except iox2.NodeCreationFailure as error:
            raise PortError(self._of_other_user() or f"robot `{name}`: {error}") from None
        end = time.monotonic() + IN_FLUX_S
        while not self.cleanup_dead_nodes() and time.monotonic() < end:
            time.sleep(BETWEEN_TRIES_S)

    def _of_other_user(self) -> str | None:
        """An error text if the processes meet in another user's folder: iceoryx2 gives no other
        user access, and has no error of its own for this. Root has access to everything."""
        user = os.geteuid()
        if user == 0 or not self._folder.exists() or self._folder.stat().st_uid == user:
            return None
        return (
            f"robot `{self.name}`: its processes meet in {self._folder}, which belongs to another "
            "user; start all of them as that user"
        )

    def _find_room(self, service: str, wanted: int) -> None:
        """Raises `PortError` if shared memory is almost full: the system kills a process that
        writes to full shared memory without a message."""
        found = os.statvfs(SEGMENTS)
        free = found.f_bavail * found.f_frsize
        # A file system without blocks has no limit.
        if found.f_blocks > 0 and free < wanted:
            raise PortError(
                f"robot `{self.name}`: `{service}` needs {wanted / 1e6:.1f} MB of shared memory, "
                f"but {free / 1e6:.1f} are left in {SEGMENTS}; remove unused files there, or "
                "enlarge it (`mount -o remount,size=...`; for a container `--shm-size`)"
            )

    def cleanup_dead_nodes(self) -> bool:
        """Cleans up dead nodes, at most a few times a second; returns whether that was possible
        now, which it is not while something is being created."""
        if remove_segments(self._prefix, self._folder):
            return False
        self._node.try_cleanup_dead_nodes()
        return True

    def _nodes(self) -> list[Any]:
        """The states of the nodes of all processes that meet here; none if they
        cannot be listed."""
        with contextlib.suppress(iox2.NodeListFailure):
            return iox2.Node.list(iox2.ServiceType.Ipc, self._node.config)
        return []

    def _has_dead(self) -> bool:
        """Whether there are dead nodes that have not been cleaned up yet."""
        return any(isinstance(state, iox2.NodeState.Dead) for state in self._nodes())

    def _namesake(self) -> int | None:
        """The process whose node has the same name as this one, if any."""
        for state in self._nodes():
            if not isinstance(state, iox2.NodeState.Alive):
                continue
            view = state[0]
            details = view.details
            if view.id != self._node.id and details and details.name == self._node.name:
                return details.process_id
        return None

    def publisher(self, service: str, message: type[ctypes.Structure]) -> Any:
        """A publisher for messages of one type."""
        factory = self._stream(service, message)
        builder = factory.publisher_builder()
        return self._create(service, builder.backpressure_strategy(_DISCARD))

    def subscriber(self, service: str, message: type[ctypes.Structure]) -> Any:
        """A subscriber for messages of one type."""
        builder = self._stream(service, message).subscriber_builder()
        return self._create(service, builder.buffer_size(QUALITIES[service].buffer))

    def frames_out(self, size: int) -> Any:
        """A publisher for frames of up to `size` bytes."""
        self._find_room("camera", FRAMES_AT_ONCE * size + ROOM)
        builder = self._builder("camera").publish_subscribe(iox2.Slice[ctypes.c_uint8])
        factory = self._open("camera", self._with(builder.user_header(CameraFrame), "camera"))
        publisher = factory.publisher_builder().backpressure_strategy(_DISCARD)
        return self._create("camera", publisher.initial_max_slice_len(size))

    def notifier(self, service: str) -> Any:
        """The notifier that wakes the listeners of a service."""
        return self._create(service, self._events(service).notifier_builder())

    def listener(self, service: str) -> Any:
        """The listener that is woken by new messages of a service."""
        return self._create(service, self._events(service).listener_builder())

    def _stream(self, service: str, message: type[ctypes.Structure]) -> Any:
        builder = self._builder(service).publish_subscribe(message)
        return self._open(service, self._with(builder, service))

    def _with(self, builder: Any, service: str) -> Any:
        quality = QUALITIES[service]
        if self._several_hosts:
            # As in `nsrm_ipc::service::Quality::over`.
            quality = quality._replace(
                history=0,
                overflow=True,
                publishers=quality.publishers + 1,
                subscribers=quality.subscribers + 1,
            )
        return (
            builder.subscriber_max_buffer_size(quality.buffer)
            .history_size(quality.history)
            .enable_safe_overflow(quality.overflow)
            .max_publishers(quality.publishers)
            .max_subscribers(quality.subscribers)
            .max_nodes(ONLOOKERS + quality.publishers)
        )

    def _events(self, service: str) -> Any:
        builder = self._builder(service).event()
        # As in `nsrm_ipc::service::RobotServices::events`.
        builder = builder.event_id_max_value(0)
        builder = builder.max_notifiers(ONLOOKERS).max_listeners(ONLOOKERS)
        return self._open(service, builder.max_nodes(2 * ONLOOKERS))

    def _builder(self, service: str) -> Any:
        name = iox2.ServiceName.new(f"nsrm/v1/{self.name}/{service}")
        return self._node.service_builder(name)

    def _open(self, service: str, builder: Any) -> Any:
        try:
            return builder.open_or_create()
        except Exception as error:
            opened = f"robot `{self.name}`: `{service}` cannot be opened: {error}"
            raise PortError(self._of_other_user() or opened) from None

    def _create(self, service: str, builder: Any) -> Any:
        """Takes a slot of a service. If a dead process still holds it, waits until this process or
        another one has cleaned that up."""
        end = time.monotonic() + IN_FLUX_S
        while True:
            try:
                return builder.create()
            except Exception as error:
                if time.monotonic() >= end or not self._has_dead():
                    raise self._not_created(service, error) from None
            self.cleanup_dead_nodes()
            time.sleep(BETWEEN_TRIES_S)

    def _not_created(self, service: str, error: Exception) -> PortError:
        if str(error).startswith("ExceedsMaxSupported"):
            process = self._namesake()
            who = "the process that holds it" if process is None else f"process {process}"
            told = f"all slots are taken; choose another name, or stop {who}"
        else:
            told = (
                f"{error}; the folder in which processes meet may not be writable, or its path may "
                "be too long for sockets"
            )
        return PortError(f"robot `{self.name}`: `{service}`: {told}")


_DISCARD = iox2.BackpressureStrategy.DiscardData


def _is_due(next_ns: int, now_ns: int, every_ns: int) -> bool:
    """Whether a periodic action is due. A wait longer than the period shows that the clock was set
    back."""
    return not 0 < next_ns - now_ns <= every_ns


class Heartbeats:
    """Sends ten heartbeats a second, with the number of rejected messages."""

    def __init__(self, robot: RobotServices, role: int) -> None:
        self._publisher = robot.publisher("heartbeat", Heartbeat)
        self._beat = Heartbeat(started_ns=now_ns(), role=role)
        self._next_ns = self._next_line_ns = 0

    def reject(self, service: str, why: str) -> None:
        """Counts a rejected message; logs at most one a second."""
        self._beat.rejected += 1
        now = now_ns()
        if _is_due(self._next_line_ns, now, LINE_NS):
            self._next_line_ns = now + LINE_NS
            _LOG.warning("%s rejected: %s (%d so far)", service, why, self._beat.rejected)

    def beat(self, state: int) -> None:
        """Sends a heartbeat if one is due."""
        now = now_ns()
        if not _is_due(self._next_ns, now, BEAT_NS):
            return
        self._next_ns = now + BEAT_NS
        self._beat.sequence += 1
        self._beat.timestamp_ns = now
        self._beat.state = state
        self._publisher.send_copy(self._beat)


class CommandsIn:
    """The commands for the controller, in order."""

    def __init__(self, robot: RobotServices) -> None:
        self._subscriber = robot.subscriber("sub_goal", SubGoal)

    def __iter__(self) -> CommandsIn:
        return self

    def __next__(self) -> SubGoal:
        sample = self._subscriber.receive()
        if sample is None:
            raise StopIteration
        return SubGoal.from_buffer_copy(sample.payload().contents)


class FeedbackOut:
    """The controller's feedback on commands."""

    def __init__(self, robot: RobotServices) -> None:
        self._publisher = robot.publisher("feedback", Feedback)
        self._notifier = robot.notifier("feedback")
        self._sequence = 0

    def say(self, plan: int, command: int, answer: Answer) -> None:
        """Reports the current outcome of a command."""
        self._sequence += 1
        feedback = Feedback(
            plan=plan,
            sequence=self._sequence,
            timestamp_ns=now_ns(),
            command=command,
            outcome=answer.outcome,
        )
        for place, number in enumerate(answer.objects[: len(feedback.objects)]):
            feedback.objects[place] = number
        self._publisher.send_copy(feedback)
        self._notifier.notify()


class FramesOut:
    """Publishes camera frames, written in place in shared memory."""

    def __init__(self, robot: RobotServices, width: int, height: int) -> None:
        self._size = width * height * 7
        self._publisher = robot.frames_out(self._size)
        self._notifier = robot.notifier("camera")

    def send(self, header: CameraFrame, rgb: NDArray[np.uint8], depth: NDArray[np.float32]) -> None:
        """Publishes a frame; `header` describes its content."""
        sample = self._publisher.loan_slice_uninit(self._size)
        ctypes.pointer(sample.user_header().contents)[0] = header
        image = np.frombuffer(sample.payload().as_memory_view(), dtype=np.uint8)
        image[: rgb.size] = rgb.ravel()
        image[rgb.size :] = depth.astype("<f4", copy=False).view(np.uint8).ravel()
        sample.assume_init().send()
        self._notifier.notify()
