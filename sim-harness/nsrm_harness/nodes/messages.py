"""The messages between processes.

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
    "low_confidence",
    "unclear_words",
    "too_many_relations",
    "outside_training_view",
    "other_object",
    "unclear_pronoun",
    "several_references",
    "other_number",
    "only_on_table",
    "already_on_table",
    "no_room_on_table",
    "hidden_reference",
    "not_on_table",
    "other",
)
"""Why a request failed: `PlanReply.reason` is a place in this list, counted from 1."""


class Purpose(IntEnum):
    """Values of `PlanRequest.purpose`."""

    # Plan only.
    PLAN_ONLY = 1
    # Execute, and observe the scene after each step.
    CLOSED_LOOP = 2
    # Execute without observing.
    OPEN_LOOP = 3
    # Cancel the request with this number.
    CANCEL = 4


class Status(IntEnum):
    """Values of `PlanReply.status`."""

    # It was parsed and grounded; repeated before each step that is grounded again.
    PLANNED = 1
    # A step was sent to the controller.
    COMMANDED = 2
    # A step succeeded.
    REACHED = 3
    # A step failed and is retried.
    AGAIN = 4
    # The sentence is done. The last reply.
    DONE = 5
    # The request was refused or has failed. The last reply.
    FAILED = 6
    # Other objects are moved aside before a step's object is moved.
    CLEARING = 7


class Kind(IntEnum):
    """Values of `SubGoal.kind`."""

    # Move the object to its sub-goal.
    MOVE = 1
    # Stop.
    STOP = 2


class Outcome(IntEnum):
    """Values of `Feedback.outcome`."""

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
    # The gripper cannot hold an object of this size.
    CANNOT_HOLD = 15
    # Other objects are moved aside first, or the object itself is regrasped on the way;
    # another outcome follows.
    CLEARING = 16
    # The reference object was moved after the command was sent; the object was not
    # grasped.
    REFERENCE_MOVED = 17


class Role(IntEnum):
    """Values of `Heartbeat.role`."""

    # Publishes camera frames.
    CAMERA = 1
    # Turns frames into scenes.
    PERCEPTION = 2
    # Answers sentences with plans.
    PLANNER = 3
    # Executes sub-goals.
    CONTROLLER = 4
    # Sends sentences to the planner.
    CLIENT = 5
    # Observes.
    WATCHER = 6


class State(IntEnum):
    """Values of `Heartbeat.state`."""

    # Not yet ready.
    STARTING = 1
    # Ready and idle.
    IDLE = 2
    # Working.
    BUSY = 3
    # Alive, but unable to work; needs a person.
    FAILED = 4


class Quality(NamedTuple):
    """The guarantees of a publish-subscribe service."""

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
"""By the last part of the service's name."""
ONLOOKERS = 16
"""The greatest number of observers, besides the processes that a robot needs."""
ROOM = 1048576
"""Bytes of shared memory that must be free when a process starts."""
FRAMES_AT_ONCE = 4
"""Frames in memory at once with one reader."""
MAX_STEPS = 8
"""The greatest number of steps of a plan."""


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
        # x of the principal point in pixels, from the image's left edge.
        ("cx", ctypes.c_float),
        # y of the principal point in pixels, from the image's upper edge.
        ("cy", ctypes.c_float),
        # Origin of the optical frame in the world's frame, metres.
        ("position", ctypes.c_float * 3),
        # Orientation of the optical frame in the world's frame: x, y, z, w.
        ("orientation", ctypes.c_float * 4),
    ]
    LAYOUT: ClassVar = (52, 4)
    """Size and alignment in bytes, as in Rust."""
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
    """Bytes before each field, as in Rust."""

    @staticmethod
    def type_name() -> str:
        """The type name that iceoryx2 compares between peers."""
        return "nsrm.v1.CameraMessage.8b20698258a5e70e"


class DetectedBox(ctypes.Structure):
    """An object that a detector has found in an image."""

    _fields_: ClassVar = [
        # Id of the object, the same in all frames; not zero.
        ("id", ctypes.c_uint32),
        # 0 if it is completely visible, 1 if others are known to hide part of it, 2 if they hide
        # all of it: it then keeps its earlier appearance, and without one it is left out.
        ("covered", ctypes.c_uint32),
        # Corners x1, y1, x2, y2 of the box around its visible part, as fractions of the image's
        # width and height.
        ("visible", ctypes.c_float * 4),
        # Corners of the box around the whole object, including hidden parts as far as they are
        # known, then the mean depth of its pixels along the optical axis, metres.
        ("location", ctypes.c_float * 5),
    ]
    LAYOUT: ClassVar = (44, 4)
    """Size and alignment in bytes, as in Rust."""
    OFFSETS: ClassVar = {
        "id": 0,
        "covered": 4,
        "visible": 8,
        "location": 24,
    }
    """Bytes before each field, as in Rust."""

    @staticmethod
    def type_name() -> str:
        """The type name that iceoryx2 compares between peers."""
        return "nsrm.v1.DetectedBox.a804d86f803d6e69"


class CameraFrame(ctypes.Structure):
    """Header of a frame (service `camera`); the bytes of the image follow as a slice: first the
    RGB rows, then the depth rows, both without gaps.

    RGB: three bytes per pixel. Depth: one little-endian `f32` per pixel, metres along the
    optical axis, 0 for no measurement."""

    _fields_: ClassVar = [
        # Sequence number: increases with each frame of one publisher.
        ("sequence", ctypes.c_uint64),
        # When the image was taken, nanoseconds on the publisher's clock.
        ("timestamp_ns", ctypes.c_uint64),
        # The camera.
        ("camera", CameraMessage),
        # The number of valid entries in `boxes`.
        ("count", ctypes.c_uint32),
        # The detections.
        ("boxes", DetectedBox * 16),
    ]
    LAYOUT: ClassVar = (776, 8)
    """Size and alignment in bytes, as in Rust."""
    OFFSETS: ClassVar = {
        "sequence": 0,
        "timestamp_ns": 8,
        "camera": 16,
        "count": 68,
        "boxes": 72,
    }
    """Bytes before each field, as in Rust."""

    @staticmethod
    def type_name() -> str:
        """The type name that iceoryx2 compares between peers."""
        return "nsrm.v1.CameraFrame.5791200141f197a9"


class ObjectMessage(ctypes.Structure):
    """An object in the camera's view."""

    _fields_: ClassVar = [
        # Id of the object, the same in all scenes; not zero.
        ("id", ctypes.c_uint32),
        # Box corners x1, y1, x2, y2 as fractions of the image's width and
        # height, then mean depth in metres.
        ("location", ctypes.c_float * 5),
        # The crop encoder's embedding.
        ("embedding", ctypes.c_float * 64),
    ]
    LAYOUT: ClassVar = (280, 4)
    """Size and alignment in bytes, as in Rust."""
    OFFSETS: ClassVar = {
        "id": 0,
        "location": 4,
        "embedding": 24,
    }
    """Bytes before each field, as in Rust."""

    @staticmethod
    def type_name() -> str:
        """The type name that iceoryx2 compares between peers."""
        return "nsrm.v1.ObjectMessage.74f496911c7af3de"


class SceneMessage(ctypes.Structure):
    """The latest scene (service `scene`). Has the same bytes as core's `RawScene`;
    `SceneMessage::to_scene` checks them."""

    _fields_: ClassVar = [
        # Version of this layout: `nsrm_core::scene::SCENE_SCHEMA`.
        ("schema", ctypes.c_uint32),
        # Frame of reference of the camera's pose.
        ("frame", ctypes.c_uint32),
        # Tag of the model whose encoder computed the embeddings.
        ("model_tag", ctypes.c_uint64),
        # Sequence number: increases with each scene of one publisher.
        ("sequence", ctypes.c_uint64),
        # When the image was taken, nanoseconds on the publisher's clock.
        ("timestamp_ns", ctypes.c_uint64),
        # The camera.
        ("camera", CameraMessage),
        # The number of valid entries in `objects`.
        ("count", ctypes.c_uint32),
        # The objects.
        ("objects", ObjectMessage * 16),
    ]
    LAYOUT: ClassVar = (4568, 8)
    """Size and alignment in bytes, as in Rust."""
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
    """Bytes before each field, as in Rust."""

    @staticmethod
    def type_name() -> str:
        """The type name that iceoryx2 compares between peers."""
        return "nsrm.v1.SceneMessage.44a4c1a31d84fbc0"


class PlanRequest(ctypes.Structure):
    """A request to execute a sentence, or to cancel one."""

    _fields_: ClassVar = [
        # The client: a unique number.
        ("client", ctypes.c_uint64),
        # Number of the request, the client's own.
        ("sequence", ctypes.c_uint64),
        # What is requested: the number of a `Purpose`.
        ("purpose", ctypes.c_uint32),
        # Bytes of the sentence; 0 to cancel.
        ("sentence_length", ctypes.c_uint32),
        # The sentence in UTF-8.
        ("sentence", ctypes.c_uint8 * 4096),
    ]
    LAYOUT: ClassVar = (4120, 8)
    """Size and alignment in bytes, as in Rust."""
    OFFSETS: ClassVar = {
        "client": 0,
        "sequence": 8,
        "purpose": 16,
        "sentence_length": 20,
        "sentence": 24,
    }
    """Bytes before each field, as in Rust."""

    @staticmethod
    def type_name() -> str:
        """The type name that iceoryx2 compares between peers."""
        return "nsrm.v1.PlanRequest.912596fd2fc37f48"


class RelationMessage(ctypes.Structure):
    """A relation in a description: to what, and where this lies from it."""

    _fields_: ClassVar = [
        # 0: the state that an action brings about; 1: nearest; 2: farthest; 3: none, a further
        # reference of what is between two.
        ("kind", ctypes.c_uint32),
        # Index of that action in the model; 0 for the other kinds.
        ("action", ctypes.c_uint32),
        # How many concepts describe the other object.
        ("count", ctypes.c_uint32),
        # Those concepts: indices in the model; 0 after the last.
        ("concepts", ctypes.c_uint8 * 4),
        # Which of several such objects: 0 if that is left open, 1 for the largest, 2 for the
        # smallest, or 3 plus the index of the action in whose direction it lies farthest.
        ("which", ctypes.c_uint32),
    ]
    LAYOUT: ClassVar = (20, 4)
    """Size and alignment in bytes, as in Rust."""
    OFFSETS: ClassVar = {
        "kind": 0,
        "action": 4,
        "count": 8,
        "concepts": 12,
        "which": 16,
    }
    """Bytes before each field, as in Rust."""

    @staticmethod
    def type_name() -> str:
        """The type name that iceoryx2 compares between peers."""
        return "nsrm.v1.RelationMessage.c033a237e5f05959"


class StepMessage(ctypes.Structure):
    """A step as parsed and, if it is still to be done, as grounded."""

    _fields_: ClassVar = [
        # Index of the action in the model.
        ("action", ctypes.c_uint32),
        # How many concepts describe the object to move.
        ("object_count", ctypes.c_uint32),
        # Those concepts: indices in the model; 0 after the last.
        ("object", ctypes.c_uint8 * 4),
        # Which of several such objects is moved, as in a relation.
        ("object_which", ctypes.c_uint32),
        # How many concepts describe objects that are not moved though all else fits; 0 if none is
        # left out.
        ("object_except_count", ctypes.c_uint32),
        # Those concepts.
        ("object_except", ctypes.c_uint8 * 4),
        # Whether a single such object is left out, 0, or any number, as which of several.
        ("object_except_which", ctypes.c_uint32),
        # How many relations the description of the object to move has.
        ("object_relation_count", ctypes.c_uint32),
        # Those relations: its own to another object, then that one's to a third; all 0 after the
        # last.
        ("object_relations", RelationMessage * 2),
        # How many concepts describe the reference.
        ("reference_count", ctypes.c_uint32),
        # Those concepts.
        ("reference", ctypes.c_uint8 * 4),
        # Which of several such objects is the reference, as in a relation.
        ("reference_which", ctypes.c_uint32),
        # How many concepts describe objects that are not the reference though all else fits.
        ("reference_except_count", ctypes.c_uint32),
        # Those concepts.
        ("reference_except", ctypes.c_uint8 * 4),
        # Whether a single such object is left out, 0, or any number.
        ("reference_except_which", ctypes.c_uint32),
        # How many relations the description of the reference has.
        ("reference_relation_count", ctypes.c_uint32),
        # Those relations.
        ("reference_relations", RelationMessage * 2),
        # The distance between the faces of the two, or by which the object is moved from where it
        # is, millimetres; 0 where the sentence names none.
        ("distance_mm", ctypes.c_uint32),
        # Id of the object to move; 0 if the step is not grounded, and then all fields below are
        # 0.
        ("object_id", ctypes.c_uint32),
        # Id of the reference; of the table, that of the object beside which there is room; of the
        # object itself, its own.
        ("reference_id", ctypes.c_uint32),
        # How well the object fits its description, a cosine.
        ("object_score", ctypes.c_float),
        # How well the reference fits.
        ("reference_score", ctypes.c_float),
        # Probability of each choice: split, acceptable words, action, relations between the words,
        # words of the object, words of the reference, object, reference.
        ("confidence", ctypes.c_float * 8),
        # Sub-goal position of the object's centre: world frame, metres.
        ("position", ctypes.c_float * 3),
        # Sub-goal orientation, world frame: x, y, z, w.
        ("orientation", ctypes.c_float * 4),
        # Predicted location in the image: x1, y1, x2, y2 as fractions of the image, mean depth in
        # metres.
        ("location", ctypes.c_float * 5),
    ]
    LAYOUT: ClassVar = (240, 4)
    """Size and alignment in bytes, as in Rust."""
    OFFSETS: ClassVar = {
        "action": 0,
        "object_count": 4,
        "object": 8,
        "object_which": 12,
        "object_except_count": 16,
        "object_except": 20,
        "object_except_which": 24,
        "object_relation_count": 28,
        "object_relations": 32,
        "reference_count": 72,
        "reference": 76,
        "reference_which": 80,
        "reference_except_count": 84,
        "reference_except": 88,
        "reference_except_which": 92,
        "reference_relation_count": 96,
        "reference_relations": 100,
        "distance_mm": 140,
        "object_id": 144,
        "reference_id": 148,
        "object_score": 152,
        "reference_score": 156,
        "confidence": 160,
        "position": 192,
        "orientation": 204,
        "location": 220,
    }
    """Bytes before each field, as in Rust."""

    @staticmethod
    def type_name() -> str:
        """The type name that iceoryx2 compares between peers."""
        return "nsrm.v1.StepMessage.cf0090730a3b4daa"


class PlanReply(ctypes.Structure):
    """An event in the execution of a `PlanRequest`."""

    _fields_: ClassVar = [
        # The client.
        ("client", ctypes.c_uint64),
        # Number of the request.
        ("request", ctypes.c_uint64),
        # Number of the plan; 0 if there is none.
        ("plan", ctypes.c_uint64),
        # Number of the reply to its request, from 1: a gap is a loss.
        ("number", ctypes.c_uint32),
        # The event: the number of a `Status`.
        ("status", ctypes.c_uint32),
        # Which step it is about, from 0.
        ("step", ctypes.c_uint32),
        # How many steps the program has; at least 1 with `Status::Planned`, else 0.
        ("count", ctypes.c_uint32),
        # Why it failed: place in `REASONS` from 1; 0 if it did not fail.
        ("reason", ctypes.c_uint32),
        # How far from its sub-goal an object was observed, metres.
        ("off_m", ctypes.c_float),
        # Bytes of the message.
        ("message_length", ctypes.c_uint32),
        # Always 0.
        ("reserved", ctypes.c_uint32),
        # Text for a person, UTF-8: the program in the paper's notation with `Status::Planned`,
        # and a line for each misspelt word that says what it was read as; else the reason.
        ("message", ctypes.c_uint8 * 1024),
        # The program's steps with `Status::Planned`.
        ("steps", StepMessage * 8),
    ]
    LAYOUT: ClassVar = (3000, 8)
    """Size and alignment in bytes, as in Rust."""
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
    """Bytes before each field, as in Rust."""

    @staticmethod
    def type_name() -> str:
        """The type name that iceoryx2 compares between peers."""
        return "nsrm.v1.PlanReply.a2af30d8382126dc"


class SubGoal(ctypes.Structure):
    """A command (service `sub_goal`): move an object to its sub-goal, or stop doing so. Each is
    acknowledged by a `crate::message::Feedback`; a repeated command gets the same answer and
    is not executed again.

    A delayed controller may read commands that are obsolete. Of all waiting commands it obeys
    stops first. It answers, but does not execute, a command that it reads after `until_ns`, or
    that is older than one it has received (with a smaller plan number, or with the same one and
    a smaller command number)."""

    _fields_: ClassVar = [
        # Number of the plan; a later plan has a greater number.
        ("plan", ctypes.c_uint64),
        # The deadline for starting it, nanoseconds on the clock of the robot's processes: the
        # machine's monotonic clock, or the wall clock on several hosts. Then the planner abandons
        # it. 0 for a stop, which is never too late.
        ("until_ns", ctypes.c_uint64),
        # Number of the command within its plan, from 1; a stop has the number of the command that
        # it stops.
        ("command", ctypes.c_uint32),
        # The number of a `Kind`; in a stop all fields below are 0.
        ("kind", ctypes.c_uint32),
        # Number of the step, from 0.
        ("step", ctypes.c_uint32),
        # Number of steps in the program.
        ("steps", ctypes.c_uint32),
        # Index of the action in the model.
        ("action", ctypes.c_uint32),
        # Id of the object to move.
        ("object_id", ctypes.c_uint32),
        # Id of the reference object; of the table, of the object beside which there is room; of the
        # object itself, its own.
        ("reference_id", ctypes.c_uint32),
        # Product of the step's probabilities, 0 to 1.
        ("confidence", ctypes.c_float),
        # Sub-goal position of the object's centre: world frame, metres.
        ("position", ctypes.c_float * 3),
        # Sub-goal orientation, world frame: x, y, z, w.
        ("orientation", ctypes.c_float * 4),
        # Predicted location in the image: x1, y1, x2, y2 as fractions of the image, mean depth in
        # metres.
        ("location", ctypes.c_float * 5),
        # Ids of objects that must stay where they are, besides the reference: the objects and
        # references of completed steps; 0 for none.
        ("keep", ctypes.c_uint32 * 16),
    ]
    LAYOUT: ClassVar = (160, 8)
    """Size and alignment in bytes, as in Rust."""
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
    """Bytes before each field, as in Rust."""

    @staticmethod
    def type_name() -> str:
        """The type name that iceoryx2 compares between peers."""
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
    """Size and alignment in bytes, as in Rust."""
    OFFSETS: ClassVar = {
        "plan": 0,
        "sequence": 8,
        "timestamp_ns": 16,
        "command": 24,
        "outcome": 28,
        "objects": 32,
    }
    """Bytes before each field, as in Rust."""

    @staticmethod
    def type_name() -> str:
        """The type name that iceoryx2 compares between peers."""
        return "nsrm.v1.Feedback.343e85d0c8daab6b"


class Heartbeat(ctypes.Structure):
    """A heartbeat (service `heartbeat`)."""

    _fields_: ClassVar = [
        # Sequence number: increases with each heartbeat of one node.
        ("sequence", ctypes.c_uint64),
        # When it was sent, nanoseconds on the sender's clock.
        ("timestamp_ns", ctypes.c_uint64),
        # When the node was started: distinguishes it from a later one in its place.
        ("started_ns", ctypes.c_uint64),
        # How many messages it has rejected since then, because they were invalid or too late.
        ("rejected", ctypes.c_uint64),
        # The sender's role: the number of a `Role`.
        ("role", ctypes.c_uint32),
        # The sender's state: the number of a `State`.
        ("state", ctypes.c_uint32),
    ]
    LAYOUT: ClassVar = (40, 8)
    """Size and alignment in bytes, as in Rust."""
    OFFSETS: ClassVar = {
        "sequence": 0,
        "timestamp_ns": 8,
        "started_ns": 16,
        "rejected": 24,
        "role": 32,
        "state": 36,
    }
    """Bytes before each field, as in Rust."""

    @staticmethod
    def type_name() -> str:
        """The type name that iceoryx2 compares between peers."""
        return "nsrm.v1.Heartbeat.6f9d992f9581fe82"
