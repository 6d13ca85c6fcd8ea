"""A plain reference implementation of the pipeline for one sentence and one scene.

The core must agree with it. It returns all intermediate results, for golden vectors, and never
refuses.
"""

from __future__ import annotations

from dataclasses import dataclass

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from nsrm import MAX_TOKENS

from nsrm_harness.domain.tokens import Tokenizer
from nsrm_harness.geometry.camera import Camera
from nsrm_harness.learning.calibrate import terms
from nsrm_harness.learning.model import GROUP_TOKEN, Heard, Model, PixelToCamera, filter_scene


@dataclass(frozen=True)
class ParsedStep:
    """One step of a sentence: tokens `first..end`, with n tokens and g groups."""

    first: int
    end: int
    hazards: np.ndarray
    """At most `[n]`: for each token up to the split; none after a sentence's last token."""
    split: float
    """Probability of the split."""
    words: float
    """Probability that all words are acceptable."""
    states: np.ndarray
    """`[n, 96]`"""
    instruction: np.ndarray
    """`[96]`"""
    action_logits: np.ndarray
    """`[A]`"""
    object_logits: np.ndarray
    """`[g]`"""
    reference_logits: np.ndarray
    """`[g]`"""
    role_logits: np.ndarray
    """`[g, 1 + 2R]`"""
    groups: tuple[tuple[int, ...], ...]
    """Concepts of each group."""


@dataclass(frozen=True)
class PlannedStep:
    """One step executed in a scene with M objects."""

    action: int
    object_scores: np.ndarray
    """`[M]`: filtered cosines."""
    reference_scores: np.ndarray
    object: int
    """Row in the scene."""
    reference: int
    location: np.ndarray
    """`[5]`"""
    position: np.ndarray
    """`[3]`: in the world, metres."""


def parse(model: Model, tokenizer: Tokenizer, sentence: str) -> list[ParsedStep]:
    """Splits a sentence into steps and encodes each."""
    found = tokenizer(sentence)
    rows = np.array(tokenizer.rows(found), np.int32)
    steps: list[ParsedStep] = []
    first, groups = 0, list(found.groups)
    while first < len(rows):
        rest = rows[first:]
        hazards = np.asarray(_hazards(model, *_padded(rest)), np.float64)[: len(rest) - 1]
        split = next((t for t, hazard in enumerate(hazards) if hazard > 0.5), len(rest) - 1)
        count = int((rest[: split + 1] == GROUP_TOKEN).sum())
        kept = np.prod(1.0 - hazards[:split])
        steps.append(
            _encode(
                model,
                rest[: split + 1],
                first=first,
                hazards=hazards[: split + 1],
                split=float(kept * (hazards[split] if split < len(hazards) else 1.0)),
                groups=tuple(groups[:count]),
            )
        )
        groups = groups[count:]
        first += split + 1
    return steps


def _encode(
    model: Model,
    rows: np.ndarray,
    *,
    first: int,
    hazards: np.ndarray,
    split: float,
    groups: tuple[tuple[int, ...], ...],
) -> ParsedStep:
    states, instruction, heard = _encoded(model, *_padded(rows))
    logits = heard.parse
    at = np.flatnonzero(rows == GROUP_TOKEN)
    return ParsedStep(
        first=first,
        end=first + len(rows),
        hazards=hazards.astype(np.float32),
        split=split,
        states=np.asarray(states)[: len(rows)],
        instruction=np.asarray(instruction),
        words=float(np.exp(heard.acceptable)),
        action_logits=np.asarray(logits.action),
        object_logits=np.asarray(logits.object)[at],
        reference_logits=np.asarray(logits.reference)[at],
        role_logits=np.asarray(heard.roles)[at],
        groups=groups,
    )


def _padded(rows: np.ndarray) -> tuple[jax.Array, jax.Array]:
    """Pads to a fixed length, so that each function is compiled once; padding has no influence."""
    tokens = np.zeros(MAX_TOKENS, np.int32)
    tokens[: len(rows)] = rows
    return jnp.asarray(tokens), jnp.arange(MAX_TOKENS) < len(rows)


@eqx.filter_jit
def _hazards(model: Model, tokens: jax.Array, valid: jax.Array) -> jax.Array:
    return jax.nn.sigmoid(model.language.splitter(tokens, valid))


@eqx.filter_jit
def _encoded(
    model: Model, tokens: jax.Array, valid: jax.Array
) -> tuple[jax.Array, jax.Array, Heard]:
    words = model.language.embedding.weight[tokens]
    return *model.language.encoder(words, valid), model.language.heard(tokens, valid)


def plan(
    model: Model,
    steps: list[ParsedStep],
    locations: np.ndarray,
    similarities: np.ndarray,
    camera: Camera,
) -> list[PlannedStep]:
    """Executes parsed steps: locations `[M, 5]`, cosines `[M, C]`; M and g must not be 0."""
    locations = locations.copy()
    planned = []
    for step in steps:
        action = int(np.argmax(step.action_logits))
        object_scores, reference_scores = (
            np.asarray(
                filter_scene(
                    jnp.asarray(similarities), jnp.array(step.groups[int(np.argmax(logits))])
                )
            )
            for logits in (step.object_logits, step.reference_logits)
        )
        moved, reference = int(np.argmax(object_scores)), int(np.argmax(reference_scores))
        one_hot = jax.nn.one_hot(action, len(step.action_logits))
        simulator = model.action.simulator
        placed = np.asarray(simulator(one_hot, locations[moved], locations[reference]))
        locations[moved] = placed
        position = locate(model.camera, placed, camera)
        planned.append(
            PlannedStep(action, object_scores, reference_scores, moved, reference, placed, position)
        )
    return planned


def locate(fitted: PixelToCamera, location: np.ndarray, camera: Camera) -> np.ndarray:
    """The object's centre in the world `[3]`, computed in f64 from the model's f32 map."""
    in_camera = np.asarray(fitted.weight, np.float64) @ terms(location, camera)
    return camera.pose.rotation() @ in_camera + np.asarray(camera.position)


def crop(image: np.ndarray, box: np.ndarray) -> np.ndarray:
    """The crop by its definition, in f64: uint8 `[H, W, 3]`, `[4]` -> `[3, 32, 32]` in 0..1.

    Each value is the mean of 2x2 bilinear samples; pixel centres are at one half, edges are
    repeated.
    """
    height, width, _ = image.shape
    at = (np.arange(64) + 0.5) / 64
    columns = _mix((box[0] + at * (box[2] - box[0])) * width - 0.5, width)
    rows = _mix((box[1] + at * (box[3] - box[1])) * height - 0.5, height)
    sampled = np.einsum("iy,jx,yxc->cij", rows, columns, image.astype(np.float64), optimize=True)
    return sampled.reshape(3, 32, 2, 32, 2).mean(axis=(2, 4)) / 255.0


def _mix(at: np.ndarray, count: int) -> np.ndarray:
    """Weights of `count` pixels in linear samples at `at`: `[len(at), count]`."""
    low = np.floor(at).astype(int)
    share = at - low
    weights = np.zeros((len(at), count))
    index = np.arange(len(at))
    np.add.at(weights, (index, low.clip(0, count - 1)), 1.0 - share)
    np.add.at(weights, (index, (low + 1).clip(0, count - 1)), share)
    return weights
