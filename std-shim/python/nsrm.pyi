"""Sentences and scenes to robot programs and sub-goals: the Rust core's Python module.

SI units. The world's frame: robot base at the origin, x forward, y left, z up. Quaternions are
x, y, z, w. A location is x1, y1, x2, y2 as fractions of the image's width and height, then the
mean depth in metres.
"""

from collections.abc import Sequence
from os import PathLike
from typing import Any, Final, Literal, NotRequired, TypeAlias, TypedDict, final

import numpy as np
from numpy.typing import ArrayLike, NDArray

__version__: str

MAX_OBJECTS: Final[int]
"""Objects in a scene."""
MAX_STEPS: Final[int]
"""Steps in a program."""
MAX_TOKENS: Final[int]
"""Tokens in a sentence, a group of concept words counted as one."""
MAX_STEP_TOKENS: Final[int]
"""Tokens in one step."""
MAX_SENTENCE_BYTES: Final[int]
"""Bytes of UTF-8 in a sentence."""
MAX_CORRECTIONS: Final[int]
"""Misspelt words of a sentence that are read as others."""
MAX_READINGS: Final[int]
"""Readings of a sentence with misspelt words that are tried."""
MAX_FILTERS: Final[int]
"""Concepts that describe one object."""
MAX_RELATIONS: Final[int]
"""Relations in one description: links of its chain."""
MAX_GROUPS: Final[int]
"""Groups of concept words in one step: what is moved, where to, and what these are related to."""
MAX_CANDIDATES: Final[int]
"""Candidates that an ambiguous description lists, the best first."""

class NsrmError(ValueError):
    """The base of this module's exceptions; its subclasses say what was wrong."""

class Refused(NsrmError):
    """The sentence was refused instead of guessed. `str()` explains why to a person."""

    kind: str
    """Why, in snake case: "unknown_word", "ambiguous", "calibration", ..."""
    details: dict[str, Any]
    """What the kind carries: words, steps from 0, candidates with scores, limits."""
    suggestion: str | None
    """The known word that may have been meant by an unknown one."""
    question: Question | None
    """What to ask the person, if an answer can complete the sentence."""

@final
class Choice:
    """One of the possible answers to a question."""

    @property
    def answer(self) -> str:
        """In words: "the small one"."""

    @property
    def sentence(self) -> str:
        """The sentence with it, which the model understands."""

@final
class Question:
    """What is asked back after a refusal; `str()` gives it in words."""

    @property
    def options(self) -> list[Choice]:
        """The possible answers; none if the question is open."""

    def complete(self, answer: str) -> str | None:
        """The sentence that an answer leads to: the number of an option, from 1, words that only
        one of them has, or "yes" if there is only one; to an open question, the words that are
        missing. None if the answer is none of these: it may be a sentence of its own.
        """

class ModelError(NsrmError):
    """A model file cannot be used."""

class SceneError(NsrmError):
    """The observed scene is invalid."""

@final
class Camera:
    """Intrinsics in pixels; pose of the optical frame (x right, y down, z forward) in the world."""

    def __init__(
        self,
        width: int,
        height: int,
        fx: float,
        fy: float,
        cx: float,
        cy: float,
        position: ArrayLike,
        orientation: ArrayLike,
    ) -> None:
        """Raises SceneError for what is no camera."""

    @property
    def width(self) -> int: ...
    @property
    def height(self) -> int: ...
    @property
    def fx(self) -> float: ...
    @property
    def fy(self) -> float: ...
    @property
    def cx(self) -> float: ...
    @property
    def cy(self) -> float: ...
    @property
    def position(self) -> tuple[float, float, float]: ...
    @property
    def orientation(self) -> tuple[float, float, float, float]: ...

@final
class Scene:
    """A checked scene; made by `Model.observe` or `Model.scene_from_embeddings`."""

    @property
    def ids(self) -> NDArray[np.uint32]:
        """uint32 [N]"""
    @property
    def locations(self) -> NDArray[np.float32]:
        """float32 [N, 5]"""
    @property
    def embeddings(self) -> NDArray[np.float32]:
        """float32 [N, 64]"""
    def __len__(self) -> int: ...

@final
class Observed:
    """Crops and locations of the objects in one image: what every model sees of it."""

    def __init__(
        self,
        image: NDArray[np.uint8],
        ids: Sequence[int],
        boxes: ArrayLike,
        depths: ArrayLike,
        camera: Camera,
    ) -> None:
        """As for `Model.observe`."""

    def __len__(self) -> int: ...

class Relation(TypedDict):
    """A relation to another object, named by the action that brings it about, or ``Nearest`` or
    ``Farthest``: of all that fit the concepts. ``And`` relates nothing: it names the second of two
    between which something is."""

    name: str
    to: Described
    """What describes the other object."""

class Related(TypedDict):
    """What describes an object by more than its values."""

    concepts: list[str]
    """Its own values; none in "the block left of the yellow one"."""
    which: NotRequired[str]
    """Which one of those that fit: that which lies farthest in a direction, ``leftmost``, or what
    is counted from there, ``second leftmost``; ``all``, ``both`` or, in plans, ``each`` of several
    that are moved, and as the reference ``both`` of two between which something is put; the
    ``table``; or ``itself``, from where an object is moved, and of several each other one."""
    relation: NotRequired[Relation]
    """What it is related to."""

Described: TypeAlias = list[str] | Related
"""What describes an object: the names of its values, or with more than these a dict."""

@final
class Step:
    """One step of a program: names of the domain."""

    @property
    def action(self) -> str: ...
    @property
    def object(self) -> Described: ...
    @property
    def reference(self) -> Described: ...
    @property
    def distance_mm(self) -> int | None:
        """The distance between the faces of the two; None where the sentence names none. With
        "itself" as the reference, that by which the object is moved."""

@final
class Correction:
    """A misspelt word, and what it was read as."""

    @property
    def word(self) -> str: ...
    @property
    def read_as(self) -> str: ...
    @property
    def explanation(self) -> str:
        """For the person, as `str()`: `"yelow" was read as "yellow"`."""

@final
class Program:
    """What a sentence says is to be done."""

    @property
    def steps(self) -> list[Step]: ...
    @property
    def notation(self) -> str:
        """In the paper's notation, a step a line."""

    @property
    def corrections(self) -> list[Correction]:
        """Misspelt words, and what they were read as: tell the person."""

@final
class PlannedStep:
    """A step of a plan: what it says, the objects meant, and the sub-goal."""

    @property
    def action(self) -> str: ...
    @property
    def object(self) -> Described: ...
    @property
    def reference(self) -> Described: ...
    @property
    def distance_mm(self) -> int | None:
        """The distance between the faces of the two; None where the sentence names none. With
        "itself" as the reference, that by which the object is moved."""
    @property
    def object_id(self) -> int: ...
    @property
    def reference_id(self) -> int:
        """The reference; of the table, the object beside which there is room; of the object itself,
        which is moved from where it is, that object."""
    @property
    def object_anchor_ids(self) -> list[int]:
        """The objects that its description relates it to: its own anchor, then the anchor's."""
    @property
    def reference_anchor_ids(self) -> list[int]:
        """The objects that its description relates the reference to."""
    @property
    def object_score(self) -> float:
        """How well the object fits its words: the least cosine."""
    @property
    def reference_score(self) -> float:
        """How well the reference fits its words: the least cosine."""
    @property
    def confidence(self) -> float:
        """Probability that every choice of the step is right."""
    @property
    def position(self) -> tuple[float, float, float]:
        """Of the moved object's centre, world frame, metres."""
    @property
    def orientation(self) -> tuple[float, float, float, float]:
        """Of the moved object in the world's frame: x, y, z, w."""
    @property
    def location(self) -> NDArray[np.float32]:
        """Where the moved object will be seen: float32 [5]"""
    @property
    def explanation(self) -> str: ...

@final
class Plan:
    """What is to be done in a scene."""

    @property
    def program(self) -> Program: ...
    @property
    def steps(self) -> list[PlannedStep]: ...
    @property
    def confidence(self) -> float:
        """Probability that every choice of the plan is right: its steps' multiplied."""

@final
class Model:
    """A trained model: the one that is built in, or one from a file."""

    @staticmethod
    def pretrained(precision: Literal["f32", "int8"] = "f32") -> Model:
        """The model that is built in: the domain `tabletop`.

        precision: of the weights of its large layers; int8 as in a controller's program
        """

    @staticmethod
    def load(path: str | PathLike[str], precision: Literal["f32", "int8"] = "f32") -> Model:
        """A model file (safetensors), rounded to a precision. Raises ModelError for what does not
        fit."""

    def info(self) -> dict[str, Any]:
        """Domain, dimensions, capacities, sizes, thresholds, training and metrics."""

    def parse(self, sentence: str) -> Program:
        """What a sentence says is to be done, whatever the scene. Raises Refused."""

    def check(self, scene: Scene) -> None:
        """Whether what is seen agrees with the camera's calibration, as planning asks first.

        Raises Refused, of the kind "calibration", where it disagrees.
        """

    def plan(self, scene: Scene, sentence: str, first: int = 0) -> Plan:
        """A plan for a sentence in a scene of this model. Raises Refused.

        `first`: from which step on, counted from 0: what is left to do in the scene as it is now.
        """

    def observe(
        self,
        image: NDArray[np.uint8],
        ids: Sequence[int],
        boxes: ArrayLike,
        depths: ArrayLike,
        camera: Camera,
    ) -> Scene:
        """A scene from an image [H, W, 3] and a detector's boxes [N, 4] and mean depths [N].

        Raises SceneError for an invalid scene, NsrmError or TypeError for wrong arrays.
        """

    def scene_from_embeddings(
        self,
        ids: Sequence[int],
        boxes: ArrayLike,
        depths: ArrayLike,
        embeddings: ArrayLike,
        camera: Camera,
    ) -> Scene:
        """A scene from embeddings [N, 64] that this model's encoder made before."""

    def plan_all(
        self, observed: Sequence[Observed], sentences: Sequence[str]
    ) -> list[Plan | Refused]:
        """A plan or a refusal, not raised, for each sentence in the observation beside it.

        Works on all processors. Raises `SceneError`, with the index of the observation, if one is
        invalid.
        """

    def encode_crop(self, crop: NDArray[np.float32]) -> NDArray[np.float32]:
        """The embedding of a crop [3, 32, 32]: float32 [64]"""

    def similarities(self, embedding: ArrayLike) -> dict[str, float]:
        """The cosine of an embedding [64] with every concept, by its name."""

    def simulate(
        self, action: str, object_location: ArrayLike, reference_location: ArrayLike
    ) -> NDArray[np.float32]:
        """Where the moved object will be seen after an action: float32 [5]

        All locations are in the image of the training's camera (`info()["training_camera"]`).
        """

    def locate(self, location: ArrayLike, camera: Camera) -> NDArray[np.float32]:
        """The centre of the object seen at a location, world frame, metres: float32 [3]"""

@final
class Limits:
    """Limits of the closed loop: timeouts, tolerances and retries.

    The defaults are those of `nsrm serve`.
    """

    def __init__(
        self,
        *,
        scene_age_ns: int | None = None,
        scene_wait_ns: int | None = None,
        accept_wait_ns: int | None = None,
        move_wait_ns: int | None = None,
        silence_ns: int | None = None,
        tolerance_m: float | None = None,
        moved_m: float | None = None,
        covered_m: float | None = None,
        attempts: int | None = None,
        retries: int | None = None,
    ) -> None:
        """Raises NsrmError for an invalid limit: one that would allow nothing, or everything."""

    @property
    def scene_age_ns(self) -> int:
        """The greatest age of a scene that is used, nanoseconds since its image was taken."""
    @property
    def scene_wait_ns(self) -> int:
        """How long to wait for a usable scene."""
    @property
    def accept_wait_ns(self) -> int:
        """How long the controller may take to accept a command, or a stop."""
    @property
    def move_wait_ns(self) -> int:
        """How long it may take to execute a command."""
    @property
    def silence_ns(self) -> int:
        """How long another node may be silent before it is considered dead."""
    @property
    def tolerance_m(self) -> float:
        """How far from its sub-goal an object may be observed."""
    @property
    def moved_m(self) -> float:
        """How far apart two observations of an unmoved object may be."""
    @property
    def covered_m(self) -> float:
        """The same for an object that is partly covered by another one."""
    @property
    def attempts(self) -> int:
        """The greatest number of commands for one step."""
    @property
    def retries(self) -> int:
        """The greatest number of retries in a whole sentence."""

@final
class Failure:
    """Why a sentence was not executed, or a step is retried. `str()` gives text for a person."""

    @property
    def kind(self) -> str:
        """Why, in snake case: "unsuccessful", "not_there", "no_scene", or a refusal's kind."""
    @property
    def message(self) -> str: ...
    @property
    def step(self) -> int | None:
        """Which step, from 0, if there is one."""
    @property
    def object_id(self) -> int | None:
        """The object that is elsewhere ("not_there"), not observed ("not_seen"), or meant now
        instead of the one before ("other_object")."""
    @property
    def off_m(self) -> float | None:
        """Its distance from where it should be, metres ("not_there")."""
    @property
    def outcome(self) -> int | None:
        """The reported outcome ("unsuccessful"): a number of the messages' `Outcome`."""
    @property
    def objects(self) -> tuple[int, int]:
        """Objects in the way, as reported by the controller; 0 for none."""
    @property
    def refusal(self) -> Refused | None:
        """The refusal, not raised."""

@final
class Waiting:
    """Nothing to do until something arrives or time passes."""

@final
class Working:
    """Some work was done; more is left."""

@final
class Planned:
    """The sentence was parsed, and its steps grounded from the next one on."""

    @property
    def plan(self) -> Plan: ...
    @property
    def first(self) -> int:
        """The step of the program at which the plan's steps start, from 0."""

@final
class Command:
    """A command for the controller."""

    @property
    def plan(self) -> int:
        """Number of the plan; plans of later executives have greater numbers."""
    @property
    def command(self) -> int:
        """Number of the command within its plan, from 1; a retry is a new command."""
    @property
    def until_ns(self) -> int:
        """The deadline for starting it, nanoseconds; then it is abandoned, and a `Stop` follows."""
    @property
    def step(self) -> int:
        """Which step of the program, from 0."""
    @property
    def steps(self) -> int: ...
    @property
    def action(self) -> str: ...
    @property
    def object_id(self) -> int: ...
    @property
    def reference_id(self) -> int: ...
    @property
    def confidence(self) -> float: ...
    @property
    def position(self) -> tuple[float, float, float]:
        """Sub-goal position of the object's centre: world frame, metres."""
    @property
    def orientation(self) -> tuple[float, float, float, float]:
        """Sub-goal orientation, world frame: x, y, z, w."""
    @property
    def location(self) -> NDArray[np.float32]:
        """Predicted location in the image: float32 [5]"""
    @property
    def keep(self) -> list[int]:
        """Objects that must stay in place, besides the reference: those of completed steps."""

@final
class Stop:
    """Send the controller a stop of this command."""

    @property
    def plan(self) -> int: ...
    @property
    def command(self) -> int: ...

@final
class Clearing:
    """Other objects are moved aside before a step's object is moved."""

    @property
    def step(self) -> int: ...
    @property
    def object_id(self) -> int: ...
    @property
    def first(self) -> tuple[int, int]:
        """Objects that are moved aside, or the object itself if it is regrasped; 0 for none."""

@final
class Reached:
    """A step succeeded."""

    @property
    def step(self) -> int: ...
    @property
    def off_m(self) -> float:
        """How far from its sub-goal the object was observed, metres; NaN in open loop."""

@final
class Again:
    """A step will be retried."""

    @property
    def step(self) -> int: ...
    @property
    def why(self) -> Failure: ...

@final
class Ended:
    """The sentence was executed, or why not."""

    @property
    def why(self) -> Failure | None: ...

Event: TypeAlias = Waiting | Working | Planned | Command | Stop | Clearing | Reached | Again | Ended
"""The result of `Executive.poll`; a name for type checkers only."""

@final
class Executive:
    """The closed loop: executes one sentence at a time, with scenes and a controller.

    It knows neither processes nor clocks: pass in scenes, feedback and the time, and `poll` returns
    what to do. `nsrm serve` is the same with services around it.
    """

    def __init__(self, model: Model, limits: Limits | None = None, first_plan: int = 1) -> None:
        """`first_plan`: number of its first plan, above those that the controller has received."""

    @property
    def plan(self) -> int | None:
        """Number of the plan that is being executed."""

    def ask(
        self,
        sentence: str,
        mode: Literal["closed_loop", "open_loop", "plan_only"] = "closed_loop",
    ) -> int:
        """Starts a sentence; returns the number of its plan.

        Raises Refused for a sentence that is too long, NsrmError while another one is executed.
        """

    def on_scene(self, scene: Scene, taken_ns: int, now_ns: int) -> str | None:
        """Takes a scene that has arrived; returns why it is rejected, if it is.

        `taken_ns`: when its image was taken.
        """

    def on_feedback(
        self,
        plan: int,
        command: int,
        outcome: int,
        now_ns: int,
        *,
        at_ns: int | None = None,
        objects: tuple[int, int] = (0, 0),
    ) -> None:
        """Takes the outcome of a command: a number of the messages' `Outcome`.

        `at_ns`: when it occurred, by default now; the result is observed in later scenes.
        `objects`: those in the way, or moved aside; 0 for none. Feedback about any other than the
        current command is ignored. Raises NsrmError for an unknown outcome.
        """

    def cancel(self) -> None:
        """Cancels the sentence: a running motion is stopped, and it ends with "cancelled"."""

    def on_controller_lost(self) -> None:
        """The controller died, hangs, or was replaced."""

    def on_command_undelivered(self) -> None:
        """The last command could not be delivered."""

    def poll(self, now_ns: int) -> Event:
        """Does one bounded unit of work; returns its result."""

def crop(image: NDArray[np.uint8], box: ArrayLike) -> NDArray[np.float32]:
    """What the encoder sees of a box [4] of an image [H, W, 3]: float32 [3, 32, 32], 0 to 1."""

@final
class Accepted:
    """Which judged plans are accepted at a confidence."""

    @property
    def threshold(self) -> float:
        """Plans of at least this confidence are accepted."""
    @property
    def count(self) -> int: ...
    @property
    def wrong(self) -> int: ...
    @property
    def bound(self) -> float:
        """The greatest share of wrong ones that agrees with these numbers, at the given level for
        all thresholds together."""

def least_confidence(
    confidences: NDArray[np.float32],
    right: NDArray[np.bool_],
    wrong: float = 0.001,
    level: float = 0.95,
) -> Accepted:
    """The smallest of some fixed thresholds on the confidence of a plan at which, with probability
    `level`, at most the share `wrong` of the accepted plans are wrong (Learn then Test).

    * `confidences`: float32 [N], `Plan.confidence` of sentences whose meaning is known; NaN if
      refused
    * `right`: bool [N], whether the plan does what was meant

    Raises NsrmError if the plans guarantee that at no threshold.
    """

def accepted(
    confidences: NDArray[np.float32], right: NDArray[np.bool_], level: float = 0.95
) -> list[Accepted]:
    """What is accepted at each of these thresholds, from the smallest."""

def with_confidence(model: bytes, confidence: float) -> bytes:
    """The content of a model file with another least confidence of a plan; its hash and its
    identity follow. Raises ModelError."""
