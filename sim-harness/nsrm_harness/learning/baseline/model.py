"""The baseline's network (section V-B), with the same parts and sizes as `learning.model`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
from jax import Array

from nsrm_harness.learning.model import (
    CAMERA_TERMS,
    INSTRUCTION,
    MISSING,
    OBJECT_EMBEDDING,
    WORD,
    Encoder,
    PixelToCamera,
    Simulator,
    ViewEncoder,
    encode_views,
    rows,
)

ACTION = 16
"""Size of the dense action embedding."""
POINTER_HIDDEN = 64
SHARED = 32
"""Size of the space in which instruction and objects are compared."""


class Pointer(eqx.Module):
    """Attention of one argument: compares instruction and objects in one space."""

    said_hidden: eqx.nn.Linear
    said_output: eqx.nn.Linear
    seen_hidden: eqx.nn.Linear
    seen_output: eqx.nn.Linear

    def __init__(self, key: Array):
        keys = jax.random.split(key, 4)
        self.said_hidden = eqx.nn.Linear(INSTRUCTION, POINTER_HIDDEN, key=keys[0])
        self.said_output = eqx.nn.Linear(POINTER_HIDDEN, SHARED, key=keys[1])
        self.seen_hidden = eqx.nn.Linear(OBJECT_EMBEDDING, POINTER_HIDDEN, key=keys[2])
        self.seen_output = eqx.nn.Linear(POINTER_HIDDEN, SHARED, key=keys[3])

    def __call__(self, instruction: Array, objects: Array, present: Array) -> Array:
        """Instruction `[96]`, embeddings `[M, 64]` -> attention `[M]`, which sums to 1.

        The similarity is the inner product, because a cosine would limit the attention.
        """
        said = self.said_output(jax.nn.relu(self.said_hidden(instruction)))
        seen = rows(self.seen_output, jax.nn.relu(rows(self.seen_hidden, objects)))
        return jax.nn.softmax(jnp.where(present, seen @ said, MISSING))


class Meaning(NamedTuple):
    """The S steps of a command: actions `[S, 16]`, and the attention `[S, M]` of each argument."""

    action: Array
    object: Array
    reference: Array


class Baseline(eqx.Module):
    """The whole baseline."""

    embedding: eqx.nn.Embedding
    encoder: Encoder
    action_decoder: eqx.nn.Linear
    color: ViewEncoder
    brightness: ViewEncoder
    object_pointer: Pointer
    reference_pointer: Pointer
    simulator: Simulator
    camera: PixelToCamera
    words: tuple[str, ...] = eqx.field(static=True)
    """The words of the embedding's rows."""

    def __init__(self, words: Sequence[str], key: Array):
        keys = jax.random.split(key, 8)
        self.words = tuple(words)
        self.embedding = eqx.nn.Embedding(len(words), WORD, key=keys[0])
        self.encoder = Encoder(keys[1])
        self.action_decoder = eqx.nn.Linear(INSTRUCTION, ACTION, key=keys[2])
        self.color = ViewEncoder(3, keys[3])
        self.brightness = ViewEncoder(1, keys[4])
        self.object_pointer = Pointer(keys[5])
        self.reference_pointer = Pointer(keys[6])
        self.simulator = Simulator(ACTION, keys[7])
        # Until it is fitted (learning/calibrate.py): the centre of the visible surface.
        self.camera = PixelToCamera(jnp.eye(3, CAMERA_TERMS))

    def encode(self, crop: Array, tint: Array | float = 1.0) -> Array:
        """RGB in 0..1 `[3, 32, 32]` -> embedding `[64]`; see `encode_views`."""
        return encode_views(self.color, self.brightness, crop, tint)

    def understand(self, tokens: Array, length: Array, objects: Array, present: Array) -> Meaning:
        """Words `[S, T]`, their numbers `[S]`, object embeddings `[M, 64]` -> meaning."""

        def step(tokens: Array, length: Array) -> Meaning:
            valid = jnp.arange(tokens.shape[0]) < length
            _, instruction = self.encoder(self.embedding.weight[tokens], valid)
            return Meaning(
                self.action_decoder(instruction),
                self.object_pointer(instruction, objects, present),
                self.reference_pointer(instruction, objects, present),
            )

        return jax.vmap(step)(tokens, length)


def carry_out(
    simulator: Simulator, meaning: Meaning, before: Array, count: Array, hard: bool = False
) -> tuple[Array, Array]:
    """Executes the first `count` steps in order, from locations `before` `[M, 5]`.

    Returns the locations at the end `[M, 5]` and each step's sub-goal `[S, 5]`. The simulator gets
    blends of locations. The sub-goal goes to the object with the largest attention if `hard`,
    otherwise to all objects in proportion to their attention.
    """

    def step(locations: Array, at: tuple[Meaning, Array]) -> tuple[Array, Array]:
        (action, chosen, reference), number = at
        goal = simulator(action, chosen @ locations, reference @ locations)
        share = jax.nn.one_hot(jnp.argmax(chosen), len(chosen)) if hard else chosen
        moved = locations + share[:, None] * (goal - locations)
        return jnp.where(number < count, moved, locations), goal

    return jax.lax.scan(step, before, (meaning, jnp.arange(len(meaning.action))))
