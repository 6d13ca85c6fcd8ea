"""The network in Equinox: the paper's parts, with the names of the model file.

Every module works on one example; `jax.vmap` makes batches. Matrices are row-major `[out, in]`. The
order of gates in recurrent cells is reset, update, new, as in `equinox.nn.GRUCell`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple, TypeVar

import equinox as eqx
import jax
import jax.numpy as jnp
from jax import Array

from nsrm_harness.domain.program import SUPERLATIVES

if TYPE_CHECKING:
    from nsrm_harness.domain import Domain

WORD = 32
ENCODER_HIDDEN = 48
INSTRUCTION = 2 * ENCODER_HIDDEN
ACCEPTABILITY_HIDDEN = 16
SPLITTER_WORD = 24
SPLITTER_HIDDEN = 32
LOOKAHEAD = 6
"""Tokens that the splitter sees behind the one at which a step may end."""
CROP = 32
PATCH_CHANNELS = 24
MERGE_CHANNELS = 32
VIEW_EMBEDDING = 32
OBJECT_EMBEDDING = 2 * VIEW_EMBEDDING
OPERATOR_HIDDEN = 32
CONCEPT = 16
SIMULATOR_HIDDEN = 64
LOCATION = 5
CAMERA_TERMS = 6

GROUP_TOKEN = 0
"""Row of the embeddings for a group of concept words, `[[X]]`."""
UNIQUE_SCALE = 10.0
"""Factor from cosine to logit in `Unique` (section IV-C)."""
MATCH_SCORE = 0.5
"""Score at which, in training, an object is as likely to match a description as not."""
SIMULATOR_SCALE = 0.1
"""Factor on the simulator's output, which keeps initial predictions near the reference."""
NORM_EPSILON = 1e-6
"""Smallest norm in a cosine."""
ACCEPTED = 20.0
"""Log odds of a word's acceptability in a model that was not taught which words are acceptable, and
of a description without relations in one that was not taught those."""
MISSING = -1e9
"""Logit of padding and missing objects."""

Network = TypeVar("Network", bound=eqx.Module)
"""The model, or another network with the same parts."""


@dataclass(frozen=True)
class AttributeShape:
    """An attribute type: its name, its operator's view, its number of values."""

    name: str
    view: str
    values: int


@dataclass(frozen=True)
class Dimensions:
    """The network's dimensions that depend on the domain."""

    words: int
    attributes: tuple[AttributeShape, ...]
    actions: int

    @property
    def relations(self) -> int:
        """Number of relations in descriptions: those of actions, then the superlatives."""
        return self.actions + len(SUPERLATIVES)

    @property
    def concepts(self) -> int:
        """Number of attribute values."""
        return sum(attribute.values for attribute in self.attributes)

    @classmethod
    def of(cls, domain: Domain) -> Dimensions:
        """The dimensions of a domain; the group token counts as a word."""
        attributes = tuple(AttributeShape(a.name, a.view, len(a.values)) for a in domain.attributes)
        return cls(len(domain.vocabulary()), attributes, len(domain.actions))


def rows(layer: eqx.nn.Linear, inputs: Array) -> Array:
    """Applies a layer to each row: `[T, I]` -> `[T, O]`."""
    assert layer.bias is not None, "layers have a bias"
    return inputs @ layer.weight.T + layer.bias


def run_gru(cell: eqx.nn.GRUCell, inputs: Array, valid: Array) -> Array:
    """States of a GRU from a zero state: inputs `[T, I]`, valid `[T]` -> `[T, H]`.

    Where `valid` is false, the state does not change, so padding has no influence.
    `n = tanh(i_n + r * (W_hn h + b_n))`, `h' = n + z * (h - n)`.
    """
    assert cell.bias is not None and cell.bias_n is not None, "cells have biases"
    gates, bias_n = inputs @ cell.weight_ih.T + cell.bias, cell.bias_n

    def step(hidden: Array, at: tuple[Array, Array]) -> tuple[Array, Array]:
        gate, is_valid = at
        in_reset, in_update, in_new = jnp.split(gate, 3)
        hid_reset, hid_update, hid_new = jnp.split(cell.weight_hh @ hidden, 3)
        reset = jax.nn.sigmoid(in_reset + hid_reset)
        update = jax.nn.sigmoid(in_update + hid_update)
        new = jnp.tanh(in_new + reset * (hid_new + bias_n))
        hidden = jnp.where(is_valid, new + update * (hidden - new), hidden)
        return hidden, hidden

    _, states = jax.lax.scan(step, jnp.zeros(cell.hidden_size), (gates, valid))
    return states


class Encoder(eqx.Module):
    """Sentence encoder: one GRU in each direction (section IV-B)."""

    forward: eqx.nn.GRUCell
    backward: eqx.nn.GRUCell

    def __init__(self, key: Array):
        first, second = jax.random.split(key)
        self.forward = eqx.nn.GRUCell(WORD, ENCODER_HIDDEN, key=first)
        self.backward = eqx.nn.GRUCell(WORD, ENCODER_HIDDEN, key=second)

    def __call__(self, words: Array, valid: Array) -> tuple[Array, Array]:
        """Embeddings `[T, 32]`, right-padded -> states `[T, 96]`, instruction `[96]`."""
        # One loop for both directions halves the code to compile.
        cells = jax.tree.map(lambda *pair: jnp.stack(pair), self.forward, self.backward)
        inputs = jnp.stack([words, words[::-1]])
        states = jax.vmap(run_gru)(cells, inputs, jnp.stack([valid, valid[::-1]]))
        ahead, back = states[0], states[1, ::-1]
        return jnp.concatenate([ahead, back], axis=1), jnp.concatenate([ahead[-1], back[0]])


class Splitter(eqx.Module):
    """Predicts where the first step of a command ends: a hazard at each token (section IV-B)."""

    embedding: eqx.nn.Embedding
    gru: eqx.nn.GRUCell
    hidden: eqx.nn.Linear
    hazard: eqx.nn.Linear

    def __init__(self, words: int, key: Array):
        keys = jax.random.split(key, 4)
        self.embedding = eqx.nn.Embedding(words, SPLITTER_WORD, key=keys[0])
        self.gru = eqx.nn.GRUCell(SPLITTER_WORD, SPLITTER_HIDDEN, key=keys[1])
        inputs = SPLITTER_HIDDEN + LOOKAHEAD * SPLITTER_WORD
        self.hidden = eqx.nn.Linear(inputs, SPLITTER_HIDDEN, key=keys[2])
        self.hazard = eqx.nn.Linear(SPLITTER_HIDDEN, 1, key=keys[3])

    def __call__(self, tokens: Array, valid: Array) -> Array:
        """Tokens `[T]`, right-padded -> logit of the hazard after each token `[T]`."""
        words = jnp.where(valid[:, None], self.embedding.weight[tokens], 0.0)
        states = run_gru(self.gru, words, valid)
        padded = jnp.concatenate([words, jnp.zeros((LOOKAHEAD, SPLITTER_WORD))])
        ahead = [padded[first : first + len(words)] for first in range(1, LOOKAHEAD + 1)]
        seen = jnp.concatenate([states, *ahead], axis=1)
        return rows(self.hazard, jnp.tanh(rows(self.hidden, seen)))[:, 0]


class Acceptability(eqx.Module):
    """Predicts whether each word stands where commands have it, so that what nobody says is not
    understood; not in the paper."""

    hidden: eqx.nn.Linear
    output: eqx.nn.Linear

    def __init__(self, key: Array, odds: float = ACCEPTED):
        """`odds`: the log odds of every word until it is trained."""
        self.hidden = eqx.nn.Linear(INSTRUCTION, ACCEPTABILITY_HIDDEN, key=key)
        self.output = jax.tree.map(jnp.zeros_like, eqx.nn.Linear(ACCEPTABILITY_HIDDEN, 1, key=key))
        self.output = eqx.tree_at(lambda layer: layer.bias, self.output, jnp.array([odds]))

    def __call__(self, states: Array) -> Array:
        """Encoder states `[T, 96]` -> log odds `[T]`."""
        return rows(self.output, jnp.tanh(rows(self.hidden, states)))[:, 0]


def without_relations(relations: int, odds: float = ACCEPTED) -> eqx.nn.Linear:
    """The relation decoder of a model that knows none of so many relations in descriptions.

    `odds`: the log odds of having none against having a certain one
    """
    decoder = eqx.nn.Linear(INSTRUCTION, 2 * relations, key=jax.random.key(0))
    return eqx.tree_at(
        lambda layer: (layer.weight, layer.bias),
        decoder,
        (jnp.zeros((2 * relations, INSTRUCTION)), jnp.full(2 * relations, -odds)),
    )


class Parse(NamedTuple):
    """The parse of one step: logits `[A]` of actions, `[T]` of each argument."""

    action: Array
    object: Array
    reference: Array


class Heard(NamedTuple):
    """All that the parser makes of one step."""

    parse: Parse
    roles: Array
    """Logits `[T, 1 + 2R]` of the role that each group has; see `structures`."""
    acceptable: Array
    """Log probability that all words are acceptable."""


class Language(eqx.Module):
    """Language reasoning: splitter, encoder and decoders (section IV-B)."""

    embedding: eqx.nn.Embedding
    encoder: Encoder
    action_decoder: eqx.nn.Linear
    object_decoder: eqx.nn.Linear
    reference_decoder: eqx.nn.Linear
    relation_decoder: eqx.nn.Linear
    """Logits of what a group's values do, if they are not themselves an argument's, for each of the
    R relations, those of actions and then the superlatives: first those of describing the object
    before it further, then those of describing, in place of an object without values, what it is
    related to."""
    acceptability: Acceptability
    splitter: Splitter

    def __init__(self, dimensions: Dimensions, key: Array):
        keys = jax.random.split(key, 6)
        self.embedding = eqx.nn.Embedding(dimensions.words, WORD, key=keys[0])
        self.encoder = Encoder(keys[1])
        self.action_decoder = eqx.nn.Linear(INSTRUCTION, dimensions.actions, key=keys[2])
        self.object_decoder = eqx.nn.Linear(INSTRUCTION, INSTRUCTION, key=keys[3])
        self.reference_decoder = eqx.nn.Linear(INSTRUCTION, INSTRUCTION, key=keys[4])
        self.splitter = Splitter(dimensions.words, keys[5])
        self.acceptability = Acceptability(jax.random.fold_in(key, 6))
        self.relation_decoder = without_relations(dimensions.relations)

    def parse(self, tokens: Array, valid: Array) -> Parse:
        """Tokens of one step `[T]`, right-padded -> logits; only group tokens can be arguments."""
        return self.heard(tokens, valid).parse

    def heard(self, tokens: Array, valid: Array) -> Heard:
        """All that the parser makes of one step."""
        states, instruction = self.encoder(self.embedding.weight[tokens], valid)
        is_group = valid & (tokens == GROUP_TOKEN)
        arguments = [
            jnp.where(is_group, states @ decoder(instruction), MISSING)
            for decoder in (self.object_decoder, self.reference_decoder)
        ]
        relations = rows(self.relation_decoder, states)
        roles = jnp.concatenate([jnp.zeros((len(states), 1)), relations], axis=1)
        odds = self.acceptability(states)
        acceptable = jnp.where(valid, jax.nn.log_sigmoid(odds), 0.0).sum()
        return Heard(Parse(self.action_decoder(instruction), *arguments), roles, acceptable)


class Conv(eqx.Module):
    """Cross-correlation without padding, with a stride equal to its kernel."""

    weight: Array
    bias: Array

    def __init__(self, inputs: int, outputs: int, kernel: int, key: Array):
        limit = (inputs * kernel * kernel) ** -0.5
        shape = (outputs, inputs, kernel, kernel)
        self.weight = jax.random.uniform(key, shape, minval=-limit, maxval=limit)
        self.bias = jnp.zeros(outputs)

    def __call__(self, image: Array) -> Array:
        """`[I, S, S]` -> `[O, S/K, S/K]`."""
        outputs, inputs, kernel, _ = self.weight.shape
        side = image.shape[-1] // kernel
        cells = image.reshape(inputs, side, kernel, side, kernel)
        cells = cells.transpose(1, 3, 0, 2, 4).reshape(side * side, -1)
        result = cells @ self.weight.reshape(outputs, -1).T + self.bias
        return result.T.reshape(outputs, side, side)


class ViewEncoder(eqx.Module):
    """`Conv 4x4/4 -> ReLU -> Conv 2x2/2 -> ReLU -> Linear -> ReLU` on one view of a crop."""

    patch: Conv
    merge: Conv
    dense: eqx.nn.Linear

    def __init__(self, channels: int, key: Array):
        keys = jax.random.split(key, 3)
        self.patch = Conv(channels, PATCH_CHANNELS, 4, keys[0])
        self.merge = Conv(PATCH_CHANNELS, MERGE_CHANNELS, 2, keys[1])
        merged = MERGE_CHANNELS * (CROP // 8) ** 2
        self.dense = eqx.nn.Linear(merged, VIEW_EMBEDDING, key=keys[2])

    def __call__(self, view: Array) -> Array:
        """`[channels, 32, 32]` -> `[32]`."""
        hidden = jax.nn.relu(self.merge(jax.nn.relu(self.patch(view))))
        return jax.nn.relu(self.dense(hidden.reshape(-1)))


def encode_views(
    color: ViewEncoder, gray: ViewEncoder, crop: Array, tint: Array | float = 1.0
) -> Array:
    """RGB in 0..1 `[3, 32, 32]` -> embedding `[64]`: colour, then brightness.

    `tint` `[3, 1, 1]`: factors on the channels for the brightness, in training.
    """
    return jnp.concatenate([color(crop - 0.5), gray(brightness(tint * crop))])


class Operator(eqx.Module):
    """Maps a view's embedding into the concept space of one attribute type."""

    hidden: eqx.nn.Linear
    output: eqx.nn.Linear

    def __init__(self, key: Array):
        first, second = jax.random.split(key)
        self.hidden = eqx.nn.Linear(VIEW_EMBEDDING, OPERATOR_HIDDEN, key=first)
        self.output = eqx.nn.Linear(OPERATOR_HIDDEN, CONCEPT, key=second)

    def __call__(self, embedding: Array) -> Array:
        """`[32]` -> `[16]`."""
        return self.output(jax.nn.relu(self.hidden(embedding)))


def brightness(crop: Array) -> Array:
    """RGB in 0..1 `[3, 32, 32]` -> `[1, 32, 32]`, standardised over the crop.

    The maximum of red, green and blue: the studs of a blue block stand out like those of a white
    one.
    """
    gray = crop.max(axis=0)
    return ((gray - gray.mean()) / (gray.std() + 0.02))[None]


def cosine(left: Array, right: Array) -> Array:
    """Cosine of two vectors; 0 if one has length 0."""
    norms = [jnp.sqrt(jnp.maximum(v @ v, NORM_EPSILON**2)) for v in (left, right)]
    return (left @ right) / (norms[0] * norms[1])


class Vision(eqx.Module):
    """Visual reasoning: crop encoder, attribute operators, concepts (section IV-C)."""

    color: ViewEncoder
    brightness: ViewEncoder
    operator: dict[str, Operator]
    concept: eqx.nn.Embedding
    attributes: tuple[AttributeShape, ...] = eqx.field(static=True)

    def __init__(self, dimensions: Dimensions, key: Array):
        keys = jax.random.split(key, 3 + len(dimensions.attributes))
        self.attributes = dimensions.attributes
        self.color = ViewEncoder(3, keys[0])
        self.brightness = ViewEncoder(1, keys[1])
        self.concept = eqx.nn.Embedding(dimensions.concepts, CONCEPT, key=keys[2])
        self.operator = {
            attribute.name: Operator(at)
            for attribute, at in zip(dimensions.attributes, keys[3:], strict=True)
        }

    def encode(self, crop: Array, tint: Array | float = 1.0) -> Array:
        """RGB in 0..1 `[3, 32, 32]` -> embedding `[64]`; see `encode_views`."""
        return encode_views(self.color, self.brightness, crop, tint)

    def similarities(self, embedding: Array) -> Array:
        """Embedding `[64]` -> cosine with every concept `[C]`."""
        views = {"color": embedding[:VIEW_EMBEDDING], "brightness": embedding[VIEW_EMBEDDING:]}
        result, first = [], 0
        for attribute in self.attributes:
            feature = self.operator[attribute.name](views[attribute.view])
            concepts = self.concept.weight[first : first + attribute.values]
            result.append(jax.vmap(cosine, (None, 0))(feature, concepts))
            first += attribute.values
        return jnp.concatenate(result)


def filter_scene(similarities: Array, concepts: Array) -> Array:
    """Nested `Filter` on `Scene()`: cosines `[M, C]`, concepts `[K]` (-1 for none) -> `[M]`."""
    chosen = jnp.where(concepts >= 0, similarities[:, concepts], 1.0)
    return jnp.minimum(chosen.min(axis=1), 1.0)


def unique(scores: Array, present: Array) -> Array:
    """Log probability of being the only matching object: scores `[M]` -> `[M]`.

    An object matches with the log odds `UNIQUE_SCALE · (score - MATCH_SCORE)`. Given that exactly
    one matches, the probabilities of the objects are `softmax(UNIQUE_SCALE · score)`. One minus the
    sum over `[M]` is the probability that none or several match.
    """
    odds = jnp.where(present, UNIQUE_SCALE * (scores - MATCH_SCORE), MISSING)
    none = jnp.where(present, jax.nn.log_sigmoid(-odds), 0.0)
    return none.sum() + odds


def center_size(location: Array) -> Array:
    """Corners and depth `[..., 5]` -> centre x, y, width, height, depth `[..., 5]`."""
    left, top, right, bottom, depth = jnp.moveaxis(location, -1, 0)
    center = ((left + right) / 2, (top + bottom) / 2)
    return jnp.stack([*center, right - left, bottom - top, depth], axis=-1)


def corners(location: Array) -> Array:
    """Centre, size and depth `[..., 5]` -> corners and depth `[..., 5]`."""
    x, y, width, height, depth = jnp.moveaxis(location, -1, 0)
    low, high = (x - width / 2, y - height / 2), (x + width / 2, y + height / 2)
    return jnp.stack([*low, *high, depth], axis=-1)


class Simulator(eqx.Module):
    """Action simulator: predicts the location of the moved object (section IV-D)."""

    input: eqx.nn.Linear
    hidden: eqx.nn.Linear
    output: eqx.nn.Linear
    location_mean: Array
    location_scale: Array
    residual: bool = eqx.field(static=True)
    """Whether the output is added to the reference's location; the core supports only this."""

    def __init__(self, actions: int, key: Array, residual: bool = True):
        self.residual = residual
        keys = jax.random.split(key, 3)
        self.input = eqx.nn.Linear(actions + 2 * LOCATION, SIMULATOR_HIDDEN, key=keys[0])
        self.hidden = eqx.nn.Linear(SIMULATOR_HIDDEN, SIMULATOR_HIDDEN, key=keys[1])
        self.output = eqx.nn.Linear(SIMULATOR_HIDDEN, LOCATION, key=keys[2])
        self.location_mean = jnp.zeros(LOCATION)
        self.location_scale = jnp.ones(LOCATION)

    def __call__(self, action: Array, moved: Array, reference: Array) -> Array:
        """One-hot action `[A]`, two locations `[5]` (corners, depth) -> location `[5]`."""
        mean, scale = jax.lax.stop_gradient((self.location_mean, self.location_scale))
        moved, reference = center_size(moved), center_size(reference)
        seen = [action, (moved - mean) / scale, (reference - mean) / scale]
        hidden = jnp.tanh(self.input(jnp.concatenate(seen)))
        change = self.output(jnp.tanh(self.hidden(hidden)))
        if not self.residual:
            return corners(mean + scale * change)
        base = jnp.concatenate([reference[:2], moved[2:4], reference[4:]])
        return corners(base + SIMULATOR_SCALE * change)


class ActionModule(eqx.Module):
    """Holds the simulator under its name in the model file."""

    simulator: Simulator


class PixelToCamera(eqx.Module):
    """Linear map from a location to the object's centre in the camera's frame; fitted
    separately."""

    weight: Array


class Model(eqx.Module):
    """The whole model; the path of each array is its tensor's name in the model file."""

    language: Language
    vision: Vision
    action: ActionModule
    camera: PixelToCamera

    def __init__(self, dimensions: Dimensions, key: Array, residual: bool = True):
        language, vision, action = jax.random.split(key, 3)
        self.language = Language(dimensions, language)
        self.vision = Vision(dimensions, vision)
        self.action = ActionModule(Simulator(dimensions.actions, action, residual))
        # Until it is fitted (calibrate.py): the centre of the visible surface.
        self.camera = PixelToCamera(jnp.eye(3, CAMERA_TERMS))


def tensors(model: eqx.Module) -> dict[str, Array]:
    """Every array of the model by its name, sorted."""
    leaves = jax.tree_util.tree_flatten_with_path(eqx.filter(model, eqx.is_array))[0]
    named = {jax.tree_util.keystr(path, simple=True, separator="."): leaf for path, leaf in leaves}
    return dict(sorted(named.items()))


def with_tensors(model: Network, values: dict[str, Array]) -> Network:
    """The model with other arrays; names and shapes must match."""
    expected = tensors(model)
    if expected.keys() != values.keys():
        odd = sorted(expected.keys() ^ values.keys())
        raise ValueError(f"missing or unknown tensors: {', '.join(odd)}")
    for name, array in expected.items():
        if array.shape != values[name].shape:
            raise ValueError(f"{name}: expected {array.shape}, got {values[name].shape}")
    arrays, rest = eqx.partition(model, eqx.is_array)
    paths, tree = jax.tree_util.tree_flatten_with_path(arrays)
    names = [jax.tree_util.keystr(path, simple=True, separator=".") for path, _ in paths]
    filled = jax.tree_util.tree_unflatten(tree, [jnp.asarray(values[name]) for name in names])
    return eqx.combine(filled, rest)
