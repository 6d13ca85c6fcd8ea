"""Sentences and scenes to robot programs and sub-goals: the Rust core's Python module.

SI units. The world's frame: robot base at the origin, x forward, y left, z up. Quaternions are
x, y, z, w. A location is x1, y1, x2, y2 as fractions of the image's width and height, then the
mean depth in metres.
"""

from collections.abc import Sequence
from os import PathLike
from typing import Any, final

import numpy as np
from numpy.typing import ArrayLike, NDArray

__version__: str

class NsrmError(ValueError):
    """What this module raises; its subclasses say what was wrong."""

class Refused(NsrmError):
    """The sentence is not obeyed: refused rather than guessed. `str()` says why, for a person."""

    kind: str
    """Why, in snake case: "unknown_word", "ambiguous", "calibration", ..."""
    details: dict[str, Any]
    """What the kind carries: words, steps from 0, candidates with scores, limits."""
    suggestion: str | None
    """The known word that may have been meant by an unknown one."""

class ModelError(NsrmError):
    """A model file can't be used."""

class SceneError(NsrmError):
    """What is observed makes no scene."""

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

@final
class Step:
    """One step of a program: names of the domain."""

    @property
    def action(self) -> str: ...
    @property
    def object(self) -> list[str]: ...
    @property
    def reference(self) -> list[str]: ...

@final
class Program:
    """What a sentence says is to be done."""

    @property
    def steps(self) -> list[Step]: ...
    @property
    def notation(self) -> str:
        """In the paper's notation, a step a line."""

@final
class PlannedStep:
    """A step of a plan: what it says, the objects meant, and the sub-goal."""

    @property
    def action(self) -> str: ...
    @property
    def object(self) -> list[str]: ...
    @property
    def reference(self) -> list[str]: ...
    @property
    def object_id(self) -> int: ...
    @property
    def reference_id(self) -> int: ...
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
    def pretrained() -> Model:
        """The model that is built in: the domain `tabletop`."""

    @staticmethod
    def load(path: str | PathLike[str]) -> Model:
        """A model file (safetensors). Raises ModelError for what does not fit."""

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

        Raises SceneError for what makes no scene, NsrmError or TypeError for wrong arrays.
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

        Works on all processors. Raises `SceneError`, with the index of the observation, where one
        makes no scene.
        """

    def encode_crop(self, crop: NDArray[np.float32]) -> NDArray[np.float32]:
        """The embedding of a crop [3, 32, 32]: float32 [64]"""

    def similarities(self, embedding: ArrayLike) -> dict[str, float]:
        """The cosine of an embedding [64] with every concept, by its name."""

    def simulate(
        self, action: str, object_location: ArrayLike, reference_location: ArrayLike
    ) -> NDArray[np.float32]:
        """Where the moved object will be seen after an action: float32 [5]"""

    def locate(self, location: ArrayLike, camera: Camera) -> NDArray[np.float32]:
        """The centre of the object seen at a location, world frame, metres: float32 [3]"""

def crop(image: NDArray[np.uint8], box: ArrayLike) -> NDArray[np.float32]:
    """What the encoder sees of a box [4] of an image [H, W, 3]: float32 [3, 32, 32], 0 to 1."""
