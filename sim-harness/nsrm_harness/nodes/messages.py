"""The messages that cross processes.

Written by `cargo run -p nsrm-ipc --bin nsrm-bindings`; do not edit.
"""

from __future__ import annotations

import ctypes
from enum import IntEnum
from typing import ClassVar, NamedTuple

REASONS = (
    "no_words",
    "unknown_word",
    "sentence_too_long",
    "too_many_concepts",
    "too_many_steps",
    "too_many_references",
    "incomplete_step",
    "same_reference",
    "unsure",
    "no_such_object",
    "ambiguous",
    "same_object",
    "not_finite",
    "outside_work_space",
    "other_model",
    "invalid_model",
    "no_scene",
    "not_accepted",
    "no_outcome",
    "controller_lost",
    "unsuccessful",
    "not_there",
    "not_seen",
    "cancelled",
    "cancelled_unconfirmed",
    "busy",
    "bad_request",
    "no_such_request",
    "stopping",
    "unanswered",
    "clock_set_back",
    "conflicting_values",
    "calibration",
    "parsed_by_other_model",
    "other",
)
"""Why a request is not followed: `PlanReply.reason` is a place in here, counted from 1."""


class Purpose(IntEnum):
    """Numbers of `PlanRequest.purpose`."""

    # To say what would be done.
    PLAN_ONLY = 1
    # To do it, and look after each step.
    CLOSED_LOOP = 2
    # To do it without looking.
    OPEN_LOOP = 3
    # To cancel the request of this number.
    CANCEL = 4


class Status(IntEnum):
    """Numbers of `PlanReply.status`."""

    # It was understood and grounded; again before each step that is grounded anew.
    PLANNED = 1
    # A step was sent to the controller.
    COMMANDED = 2
    # A step did what it should.
    REACHED = 3
    # A step did not, and is tried again.
    AGAIN = 4
    # All is done. The last reply.
    DONE = 5
    # It won't be followed, or not further. The last reply.
    FAILED = 6
    # Before a step's object is carried, something else is moved out of its way.
    CLEARING = 7


class Kind(IntEnum):
    """Numbers of `SubGoal.kind`."""

    # To bring the object there.
    MOVE = 1
    # To stop.
    STOP = 2


class Outcome(IntEnum):
    """Numbers of `Feedback.outcome`."""

    # It will be executed; another outcome follows.
    ACCEPTED = 1
    # The object is at its sub-goal.
    REACHED = 2
    # No space at the sub-goal, or no collision-free path.
    NO_PATH = 3
    # The gripper did not grasp the object.
    NOT_GRASPED = 4
    # The object was dropped on the way.
    DROPPED = 5
    # Placed, but not at its sub-goal.
    MISPLACED = 6
    # Stopped by a command, a person or a safety function.
    STOPPED = 7
    # Another command is being executed; this one won't be.
    BUSY = 8
    # The command is invalid, or its object isn't visible; it won't be executed.
    IMPOSSIBLE = 9
    # It was read after its deadline; it won't be executed.
    TOO_LATE = 10
    # Nothing supports the object at its sub-goal, or it would fall there.
    WOULD_FALL = 11
    # The object or its sub-goal is out of the arm's reach.
    OUT_OF_REACH = 12
    # The arm's joints do not follow their commands; the arm has stopped.
    NOT_FOLLOWING = 13
    # Another object stands on the object.
    COVERED = 14
    # The gripper can't hold an object of this size.
    CANNOT_HOLD = 15
    # Other objects are moved aside first, or the object itself is regrasped on the way;
    # another outcome follows.
    CLEARING = 16
    # The reference object was moved after the command was sent; the object was not
    # grasped.
    REFERENCE_MOVED = 17


class Role(IntEnum):
    """Numbers of `Heartbeat.role`."""

    # Publishes camera frames.
    CAMERA = 1
    # Makes scenes of them.
    PERCEPTION = 2
    # Answers sentences with plans.
    PLANNER = 3
    # Carries sub-goals out.
    CONTROLLER = 4
    # Asks for sentences to be followed.
    CLIENT = 5
    # Looks on.
    WATCHER = 6


class State(IntEnum):
    """Numbers of `Heartbeat.state`."""

    # Not yet ready.
    STARTING = 1
    # Ready, with nothing to do.
    IDLE = 2
    # At work.
    BUSY = 3
    # Alive, but unable to work; a person must look.
    FAILED = 4


class Quality(NamedTuple):
    """What a publish-subscribe service promises."""

    buffer: int
    history: int
    overflow: bool
    publishers: int
    subscribers: int


QUALITIES = {
    "camera": Quality(1, 1, True, 1, 16),
    "scene": Quality(1, 1, True, 1, 16),
    "sub_goal": Quality(8, 0, False, 1, 1),
    "feedback": Quality(64, 0, True, 1, 16),
    "heartbeat": Quality(16, 0, True, 16, 16),
}
"""By the end of the service's name."""
ONLOOKERS = 16
"""How many may look on, beside those that a robot needs."""
ROOM = 1048576
"""Bytes of shared memory that must be left for a process to begin."""
FRAMES_AT_ONCE = 4
"""Frames that have memory at once with one reader."""
MAX_STEPS = 8
"""A plan has no more steps."""


class CameraMessage(ctypes.Structure):
    """Intrinsics and pose of a camera: pinhole without distortion; see
    `nsrm_core::camera::Camera`."""

    _fields_: ClassVar = [
        # Width of the image in pixels.
        ("width", ctypes.c_uint32),
        # Height of the image in pixels.
        ("height", ctypes.c_uint32),
        # Focal length along x in pixels.
        ("fx", ctypes.c_float),
        # Focal length along y in pixels.
        ("fy", ctypes.c_float),
        # Principal point's x in pixels, from the image's left edge.
        ("cx", ctypes.c_float),
        # Principal point's y in pixels, from the image's upper edge.
        ("cy", ctypes.c_float),
        # Origin of the optical frame in the world's frame, metres.
        ("position", ctypes.c_float * 3),
        # Orientation of the optical frame in the world's frame: x, y, z, w.
        ("orientation", ctypes.c_float * 4),
    ]
    LAYOUT: ClassVar = (52, 4)
    """Size and alignment in bytes, as Rust has them."""
    OFFSETS: ClassVar = {
        "width": 0,
        "height": 4,
        "fx": 8,
        "fy": 12,
        "cx": 16,
        "cy": 20,
        "position": 24,
        "orientation": 36,
    }
    """Bytes before each field, as Rust has them."""

    @staticmethod
    def type_name() -> str:
        """What iceoryx2 compares between peers."""
        return "nsrm.v1.CameraMessage.8b20698258a5e70e"


class DetectedBox(ctypes.Structure):
    """An object that a detector has found in the image."""

    _fields_: ClassVar = [
        # Who it is across frames; not zero.
        ("id", ctypes.c_uint32),
        # 0 where all of it is seen, 1 where others are known to hide a part of it, 2 where they
        # hide all of it: its look is then that of before, and without one it is left out.
        ("covered", ctypes.c_uint32),
        # Corners x1, y1, x2, y2 of the box around what is seen of it, as fractions of the
        # image's width and height.
        ("visible", ctypes.c_float * 4),
        # Corners of the box around all of it, also of what is hidden behind others as
        # far as that is known, then the mean depth of its pixels along the optical
        # axis, metres.
        ("location", ctypes.c_float * 5),
    ]
    LAYOUT: ClassVar = (44, 4)
    """Size and alignment in bytes, as Rust has them."""
    OFFSETS: ClassVar = {
        "id": 0,
        "covered": 4,
        "visible": 8,
        "location": 24,
    }
    """Bytes before each field, as Rust has them."""

    @staticmethod
    def type_name() -> str:
        """What iceoryx2 compares between peers."""
        return "nsrm.v1.DetectedBox.a804d86f803d6e69"


class CameraFrame(ctypes.Structure):
    """Header of a frame (service `camera`); the bytes of the image follow as a
    slice: RGB rows first, depth rows behind them, both without gaps.

    RGB: three bytes a pixel. Depth: one little-endian `f32` a pixel, metres
    along the optical axis, 0 where nothing was measured."""

    _fields_: ClassVar = [
        # Counts up with each frame of one publisher.
        ("sequence", ctypes.c_uint64),
        # When the image was taken, nanoseconds on the publisher's clock.
        ("timestamp_ns", ctypes.c_uint64),
        # The camera.
        ("camera", CameraMessage),
        # How many of `boxes` are there.
        ("count", ctypes.c_uint32),
        # What the detector found.
        ("boxes", DetectedBox * 16),
    ]
    LAYOUT: ClassVar = (776, 8)
    """Size and alignment in bytes, as Rust has them."""
    OFFSETS: ClassVar = {
        "sequence": 0,
        "timestamp_ns": 8,
        "camera": 16,
        "count": 68,
        "boxes": 72,
    }
    """Bytes before each field, as Rust has them."""

    @staticmethod
    def type_name() -> str:
        """What iceoryx2 compares between peers."""
        return "nsrm.v1.CameraFrame.5791200141f197a9"


class ObjectMessage(ctypes.Structure):
    """An object as the camera sees it."""

    _fields_: ClassVar = [
        # Who it is across scenes; not zero.
        ("id", ctypes.c_uint32),
        # Box corners x1, y1, x2, y2 as fractions of the image's width and
        # height, then mean depth in metres.
        ("location", ctypes.c_float * 5),
        # What the crop encoder made of it.
        ("embedding", ctypes.c_float * 64),
    ]
    LAYOUT: ClassVar = (280, 4)
    """Size and alignment in bytes, as Rust has them."""
    OFFSETS: ClassVar = {
        "id": 0,
        "location": 4,
        "embedding": 24,
    }
    """Bytes before each field, as Rust has them."""

    @staticmethod
    def type_name() -> str:
        """What iceoryx2 compares between peers."""
        return "nsrm.v1.ObjectMessage.74f496911c7af3de"


class SceneMessage(ctypes.Structure):
    """The latest scene (service `scene`). The bytes are those of core's
    `RawScene`; `SceneMessage::to_scene` checks them."""

    _fields_: ClassVar = [
        # Version of this layout: `nsrm_core::scene::SCENE_SCHEMA`.
        ("schema", ctypes.c_uint32),
        # Frame of reference of the camera's pose.
        ("frame", ctypes.c_uint32),
        # Tag of the model whose encoder made the embeddings.
        ("model_tag", ctypes.c_uint64),
        # Counts up with each scene of one publisher.
        ("sequence", ctypes.c_uint64),
        # When the image was taken, nanoseconds on the publisher's clock.
        ("timestamp_ns", ctypes.c_uint64),
        # The camera that saw it.
        ("camera", CameraMessage),
        # How many of `objects` are there.
        ("count", ctypes.c_uint32),
        # The objects.
        ("objects", ObjectMessage * 16),
    ]
    LAYOUT: ClassVar = (4568, 8)
    """Size and alignment in bytes, as Rust has them."""
    OFFSETS: ClassVar = {
        "schema": 0,
        "frame": 4,
        "model_tag": 8,
        "sequence": 16,
        "timestamp_ns": 24,
        "camera": 32,
        "count": 84,
        "objects": 88,
    }
    """Bytes before each field, as Rust has them."""

    @staticmethod
    def type_name() -> str:
        """What iceoryx2 compares between peers."""
        return "nsrm.v1.SceneMessage.44a4c1a31d84fbc0"


class PlanRequest(ctypes.Structure):
    """Asks for a sentence to be followed."""

    _fields_: ClassVar = [
        # Who asks: a number that no other has.
        ("client", ctypes.c_uint64),
        # Number of the request, the client's own.
        ("sequence", ctypes.c_uint64),
        # How far it is to be followed, or that it no longer is: the number of a
        # `Purpose`.
        ("purpose", ctypes.c_uint32),
        # Bytes of the sentence; 0 to cancel.
        ("sentence_length", ctypes.c_uint32),
        # The sentence in UTF-8.
        ("sentence", ctypes.c_uint8 * 4096),
    ]
    LAYOUT: ClassVar = (4120, 8)
    """Size and alignment in bytes, as Rust has them."""
    OFFSETS: ClassVar = {
        "client": 0,
        "sequence": 8,
        "purpose": 16,
        "sentence_length": 20,
        "sentence": 24,
    }
    """Bytes before each field, as Rust has them."""

    @staticmethod
    def type_name() -> str:
        """What iceoryx2 compares between peers."""
        return "nsrm.v1.PlanRequest.912596fd2fc37f48"


class StepMessage(ctypes.Structure):
    """A step as understood and, where it is still to be done, as grounded."""

    _fields_: ClassVar = [
        # Index of the action in the model.
        ("action", ctypes.c_uint32),
        # How many concepts describe the object to be moved.
        ("object_count", ctypes.c_uint32),
        # Those concepts, by their index in the model; 0 behind the last.
        ("object", ctypes.c_uint8 * 4),
        # How many concepts describe the reference.
        ("reference_count", ctypes.c_uint32),
        # Those concepts.
        ("reference", ctypes.c_uint8 * 4),
        # Id of the object to be moved; 0 where the step is not grounded, and
        # then all below is 0.
        ("object_id", ctypes.c_uint32),
        # Id of the reference.
        ("reference_id", ctypes.c_uint32),
        # How well the object fits its description, a cosine.
        ("object_score", ctypes.c_float),
        # How well the reference fits.
        ("reference_score", ctypes.c_float),
        # Probability of each choice: split, action, words of the object, words
        # of the reference, object, reference.
        ("confidence", ctypes.c_float * 6),
        # Where the object's centre is to be: world frame, metres.
        ("position", ctypes.c_float * 3),
        # How it is to be turned, world frame: x, y, z, w.
        ("orientation", ctypes.c_float * 4),
        # Where the camera will see it, as predicted: x1, y1, x2, y2 as
        # fractions of the image, mean depth in metres.
        ("location", ctypes.c_float * 5),
    ]
    LAYOUT: ClassVar = (108, 4)
    """Size and alignment in bytes, as Rust has them."""
    OFFSETS: ClassVar = {
        "action": 0,
        "object_count": 4,
        "object": 8,
        "reference_count": 12,
        "reference": 16,
        "object_id": 20,
        "reference_id": 24,
        "object_score": 28,
        "reference_score": 32,
        "confidence": 36,
        "position": 60,
        "orientation": 72,
        "location": 88,
    }
    """Bytes before each field, as Rust has them."""

    @staticmethod
    def type_name() -> str:
        """What iceoryx2 compares between peers."""
        return "nsrm.v1.StepMessage.9da5fff08c49f54d"


class PlanReply(ctypes.Structure):
    """What has become of a `PlanRequest`."""

    _fields_: ClassVar = [
        # Who asked.
        ("client", ctypes.c_uint64),
        # Number of the request.
        ("request", ctypes.c_uint64),
        # Number of the plan; 0 if there is none.
        ("plan", ctypes.c_uint64),
        # Counts the replies to a request from 1: a gap is a loss.
        ("number", ctypes.c_uint32),
        # What has happened: the number of a `Status`.
        ("status", ctypes.c_uint32),
        # Which step it is about, from 0.
        ("step", ctypes.c_uint32),
        # How many steps the program has; from 1 when planned, else 0.
        ("count", ctypes.c_uint32),
        # Why not: place in `REASONS` from 1; 0 where all is well.
        ("reason", ctypes.c_uint32),
        # How far from its sub-goal an object was seen, metres.
        ("off_m", ctypes.c_float),
        # Bytes of the message.
        ("message_length", ctypes.c_uint32),
        # Always 0.
        ("reserved", ctypes.c_uint32),
        # For a person, in UTF-8: the program in the paper's notation when
        # planned, else why not.
        ("message", ctypes.c_uint8 * 1024),
        # The program's steps when planned.
        ("steps", StepMessage * 8),
    ]
    LAYOUT: ClassVar = (1944, 8)
    """Size and alignment in bytes, as Rust has them."""
    OFFSETS: ClassVar = {
        "client": 0,
        "request": 8,
        "plan": 16,
        "number": 24,
        "status": 28,
        "step": 32,
        "count": 36,
        "reason": 40,
        "off_m": 44,
        "message_length": 48,
        "reserved": 52,
        "message": 56,
        "steps": 1080,
    }
    """Bytes before each field, as Rust has them."""

    @staticmethod
    def type_name() -> str:
        """What iceoryx2 compares between peers."""
        return "nsrm.v1.PlanReply.a56839637ffd4920"


class SubGoal(ctypes.Structure):
    """A command (service `sub_goal`): bring an object to its sub-goal, or stop
    doing so. Each is acknowledged by a `crate::message::Feedback`; one that
    comes again is answered again and not carried out again.

    A controller may have been held up, and find commands that nobody wants any
    more: of all that wait it obeys stops first, and it answers without a move what
    is read after `until_ns` or comes before a command that it has had (of a smaller
    plan, or of the same one with a smaller number)."""

    _fields_: ClassVar = [
        # Number of the plan; a later plan has a greater one.
        ("plan", ctypes.c_uint64),
        # Until when it may be begun, nanoseconds on the clock that the robot's processes go
        # by: the machine's monotonic one, or the wall clock over several hosts. Then the
        # planner gives it up. 0 for a stop, which is never too late.
        ("until_ns", ctypes.c_uint64),
        # Counts the plan's commands from 1; a stop has that of what it stops.
        ("command", ctypes.c_uint32),
        # The number of a `Kind`; of a stop all below is 0.
        ("kind", ctypes.c_uint32),
        # Place in the plan, from 0.
        ("step", ctypes.c_uint32),
        # Steps of the plan.
        ("steps", ctypes.c_uint32),
        # Index of the action in the model.
        ("action", ctypes.c_uint32),
        # The object to be moved.
        ("object_id", ctypes.c_uint32),
        # The object in relation to which it is moved.
        ("reference_id", ctypes.c_uint32),
        # Product of the step's probabilities, 0 to 1.
        ("confidence", ctypes.c_float),
        # Where the object's centre is to be: world frame, metres.
        ("position", ctypes.c_float * 3),
        # How it is to be turned, world frame: x, y, z, w.
        ("orientation", ctypes.c_float * 4),
        # Where the camera will see it, as predicted: x1, y1, x2, y2 as
        # fractions of the image, mean depth in metres.
        ("location", ctypes.c_float * 5),
        # Ids of what is to stay where it is besides the reference: what the steps that are done
        # have put somewhere, and what they have put it beside or on; 0 for none.
        ("keep", ctypes.c_uint32 * 16),
    ]
    LAYOUT: ClassVar = (160, 8)
    """Size and alignment in bytes, as Rust has them."""
    OFFSETS: ClassVar = {
        "plan": 0,
        "until_ns": 8,
        "command": 16,
        "kind": 20,
        "step": 24,
        "steps": 28,
        "action": 32,
        "object_id": 36,
        "reference_id": 40,
        "confidence": 44,
        "position": 48,
        "orientation": 60,
        "location": 76,
        "keep": 96,
    }
    """Bytes before each field, as Rust has them."""

    @staticmethod
    def type_name() -> str:
        """What iceoryx2 compares between peers."""
        return "nsrm.v1.SubGoal.027c01d730571850"


class Feedback(ctypes.Structure):
    """The outcome of a command (service `feedback`)."""

    _fields_: ClassVar = [
        # Number of the plan, as in `crate::message::SubGoal::plan`.
        ("plan", ctypes.c_uint64),
        # Counts up with each feedback of one controller: a gap is a loss.
        ("sequence", ctypes.c_uint64),
        # When the outcome occurred, nanoseconds on the sender's clock.
        ("timestamp_ns", ctypes.c_uint64),
        # Number of the command, as in `crate::message::SubGoal::command`.
        ("command", ctypes.c_uint32),
        # The number of an `Outcome`.
        ("outcome", ctypes.c_uint32),
        # Ids of up to two objects: those in the way, or for `Outcome::Clearing` those that
        # are moved aside; 0 for none.
        ("objects", ctypes.c_uint32 * 2),
    ]
    LAYOUT: ClassVar = (40, 8)
    """Size and alignment in bytes, as Rust has them."""
    OFFSETS: ClassVar = {
        "plan": 0,
        "sequence": 8,
        "timestamp_ns": 16,
        "command": 24,
        "outcome": 28,
        "objects": 32,
    }
    """Bytes before each field, as Rust has them."""

    @staticmethod
    def type_name() -> str:
        """What iceoryx2 compares between peers."""
        return "nsrm.v1.Feedback.343e85d0c8daab6b"


class Heartbeat(ctypes.Structure):
    """A sign of life."""

    _fields_: ClassVar = [
        # Counts up with each heartbeat of one node.
        ("sequence", ctypes.c_uint64),
        # When it was sent, nanoseconds on the sender's clock.
        ("timestamp_ns", ctypes.c_uint64),
        # When the node was started: tells it from one started in its place.
        ("started_ns", ctypes.c_uint64),
        # How many messages it has received and passed over since then, because they
        # made no sense or came too late.
        ("rejected", ctypes.c_uint64),
        # Who sends: the number of a `Role`.
        ("role", ctypes.c_uint32),
        # What it does: the number of a `State`.
        ("state", ctypes.c_uint32),
    ]
    LAYOUT: ClassVar = (40, 8)
    """Size and alignment in bytes, as Rust has them."""
    OFFSETS: ClassVar = {
        "sequence": 0,
        "timestamp_ns": 8,
        "started_ns": 16,
        "rejected": 24,
        "role": 32,
        "state": 36,
    }
    """Bytes before each field, as Rust has them."""

    @staticmethod
    def type_name() -> str:
        """What iceoryx2 compares between peers."""
        return "nsrm.v1.Heartbeat.6f9d992f9581fe82"
