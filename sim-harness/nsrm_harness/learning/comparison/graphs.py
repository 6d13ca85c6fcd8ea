"""The model as ONNX graphs, one for each job of `cargo compare`, of fixed sizes.

They are made to be fast in ONNX Runtime: what is linear is folded into the layer behind it, the two
argument decoders are one layer, as are the operators and the centring of locations, and the GRU is
the operator `GRU` (unrolled or as a `Scan` it is slower; see docs/performance). Where ours computes
more, such as probabilities and refusals, the graphs do not.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from nsrm_harness.learning import model as network
from nsrm_harness.learning.comparison.graph import Graph
from nsrm_harness.learning.model import Model

TOKENS = 12
OBJECTS = 6
HALVES = np.array(
    [[0.5, 0, 0.5, 0, 0], [0, 0.5, 0, 0.5, 0], [-1, 0, 1, 0, 0], [0, -1, 0, 1, 0], [0, 0, 0, 0, 1]]
)
"""From corners and depth to centre, size and depth."""
CORNERS = np.linalg.inv(HALVES)


def array(values: object) -> np.ndarray:
    """A weight in f64, so that folding does not round."""
    return np.asarray(values, np.float64)


def gru(graph: Graph, words: str, cells: Sequence[object]) -> str:
    """States `[T, D, 1, H]` of `D` cells on words `[T, 1, I]`, the second one backward.

    ONNX orders the gates update, reset, new, ours are reset, update, new.
    """
    in_weights, hidden_weights, biases = [], [], []
    for cell in cells:
        weight_ih, weight_hh = array(cell.weight_ih), array(cell.weight_hh)  # type: ignore[attr-defined]
        bias, bias_n = array(cell.bias), array(cell.bias_n)  # type: ignore[attr-defined]
        hidden = len(bias_n)

        def ordered(gates: np.ndarray, hidden: int = hidden) -> np.ndarray:
            reset, update, new = (gates[at * hidden :][:hidden] for at in range(3))
            return np.concatenate([update, reset, new])

        in_weights.append(ordered(weight_ih))
        hidden_weights.append(ordered(weight_hh))
        biases.append(np.concatenate([ordered(bias), np.zeros(2 * hidden), bias_n]))
    return graph.add(
        "GRU",
        words,
        *(graph.constant(np.stack(stacked)) for stacked in (in_weights, hidden_weights, biases)),
        hidden_size=hidden_weights[0].shape[1],
        linear_before_reset=1,
        direction="bidirectional" if len(cells) == 2 else "forward",
    )


def encoder_states(graph: Graph, model: Model, words: str) -> str:
    """States `[T, 96]` of words `[T, 1, 32]`."""
    encoder = model.language.encoder
    states = gru(graph, words, [encoder.forward, encoder.backward])
    return graph.reshape(states, TOKENS, network.INSTRUCTION)


def hazards(graph: Graph, model: Model, words: str) -> str:
    """Hazards `[T, 1]` of words `[T, 1, 24]`."""
    splitter = model.language.splitter
    width, state = network.SPLITTER_WORD, network.SPLITTER_HIDDEN
    states = graph.reshape(gru(graph, words, [splitter.gru]), TOKENS, state)
    zeros = graph.constant(np.zeros((network.LOOKAHEAD, 1, width)))
    padded = graph.add("Concat", words, zeros, axis=0)
    places = np.arange(TOKENS)[:, None] + np.arange(1, network.LOOKAHEAD + 1)
    ahead = graph.add("Gather", padded, graph.constant(places), axis=0)
    ahead = graph.reshape(ahead, TOKENS, network.LOOKAHEAD * width)
    weight = array(splitter.hidden.weight)
    hidden = graph.dense(ahead, weight[:, state:], array(splitter.hidden.bias))
    hidden = graph.add("Tanh", graph.dense(states, weight[:, :state], hidden))
    logits = graph.dense(hidden, array(splitter.hazard.weight), array(splitter.hazard.bias))
    return graph.add("Sigmoid", logits)


def moved(graph: Graph, model: Model, locations: str, action_bias: str) -> str:
    """The moved object's location `[1, 5]`.

    * `locations`: `[1, 10]`, the object's and the reference's
    * `action_bias`: `[1, 64]`, the action's row of `action_biases`
    """
    simulator = model.action.simulator
    weight, _ = _folded_input(model)
    hidden = graph.add("Tanh", graph.dense(locations, weight, action_bias))
    hidden = array(simulator.hidden.weight), array(simulator.hidden.bias), hidden
    hidden = graph.add("Tanh", graph.dense(hidden[2], hidden[0], hidden[1]))
    # The reference's centre and depth, the object's size.
    sizes = np.diag([0.0, 0.0, 1.0, 1.0, 0.0])
    base = np.hstack([sizes @ HALVES, (np.eye(5) - sizes) @ HALVES])
    scaled = network.SIMULATOR_SCALE * CORNERS
    before = graph.dense(locations, CORNERS @ base, scaled @ array(simulator.output.bias))
    return graph.dense(hidden, scaled @ array(simulator.output.weight), before)


def action_biases(model: Model) -> np.ndarray:
    """What each action adds in the simulator's first layer `[A, 64]`."""
    simulator = model.action.simulator
    actions = array(simulator.input.weight)[:, : -2 * network.LOCATION]
    return actions.T + _folded_input(model)[1]


def _folded_input(model: Model) -> tuple[np.ndarray, np.ndarray]:
    """The first layer on two locations by their corners: `[64, 10]`, `[64]`."""
    simulator = model.action.simulator
    weight = array(simulator.input.weight)[:, -2 * network.LOCATION :]
    mean, scale = array(simulator.location_mean), array(simulator.location_scale)
    standard = HALVES / scale[:, None]
    halves = np.split(weight, 2, axis=1)
    bias = array(simulator.input.bias) - sum(half @ (mean / scale) for half in halves)
    return np.hstack([half @ standard for half in halves]), bias


def cosines(graph: Graph, model: Model, embeddings: str) -> str:
    """Cosines `[M, C]` of objects' embeddings `[M, 64]` with all concepts."""
    vision = model.vision
    count, view = len(vision.attributes), network.VIEW_EMBEDDING
    inner, space = network.OPERATOR_HIDDEN, network.CONCEPT
    hidden = np.zeros((count * inner, network.OBJECT_EMBEDDING))
    output = np.zeros((count * space, count * inner))
    concepts = np.zeros((vision.concept.weight.shape[0], count * space))
    hidden_bias, output_bias, owner, first = [], [], [], 0
    for at, attribute in enumerate(vision.attributes):
        operator = vision.operator[attribute.name]
        skipped = 0 if attribute.view == "color" else view
        hidden[at * inner :][:inner, skipped : skipped + view] = array(operator.hidden.weight)
        output[at * space :][:space, at * inner :][:, :inner] = array(operator.output.weight)
        values = array(vision.concept.weight)[first : first + attribute.values]
        values = values / np.linalg.norm(values, axis=1, keepdims=True)
        concepts[first : first + attribute.values, at * space :][:, :space] = values
        hidden_bias.append(array(operator.hidden.bias))
        output_bias.append(array(operator.output.bias))
        owner += [at] * attribute.values
        first += attribute.values
    features = graph.dense(embeddings, hidden, np.concatenate(hidden_bias))
    features = graph.dense(graph.add("Relu", features), output, np.concatenate(output_bias))
    products = graph.add("MatMul", features, graph.constant(concepts.T))
    squares = graph.add("Mul", features, features)
    owners = np.kron(np.eye(count)[owner], np.ones(space))
    lengths = graph.add("Sqrt", graph.add("MatMul", squares, graph.constant(owners.T)))
    return graph.add("Div", products, lengths)


def embeddings(graph: Graph, model: Model, crops: str, count: int, reduced: bool) -> str:
    """Embeddings `[count, 64]` of crops `[count, 3, 32, 32]`, RGB in 0..1.

    * `reduced`: take the greatest channel by `ReduceMax`, not by `Split` and `Max`
    """
    vision, side = model.vision, network.CROP
    patch = array(vision.color.patch.weight)
    shifted = array(vision.color.patch.bias) - 0.5 * patch.sum(axis=(1, 2, 3))
    color = view(graph, vision.color, crops, count, shifted)
    if reduced:
        gray = graph.add("ReduceMax", crops, axes=[1], keepdims=1)
    else:
        gray = graph.add("Max", *graph.node("Split", crops, outputs=3, axis=1))
    mean = graph.add("ReduceMean", gray, axes=[2, 3], keepdims=1)
    gray = graph.add("Sub", gray, mean)
    length = graph.add("ReduceL2", gray, axes=[2, 3], keepdims=1)
    # Of the standard deviation; that of n values is their length over the root of n.
    scale = graph.add("Add", length, graph.constant(np.array(0.02 * side)))
    gray = graph.add("Div", gray, graph.add("Mul", scale, graph.constant(np.array(1 / side))))
    bias = array(vision.brightness.patch.bias)
    return graph.add("Concat", color, view(graph, vision.brightness, gray, count, bias), axis=1)


def view(
    graph: Graph, encoder: network.ViewEncoder, pixels: str, count: int, bias: np.ndarray
) -> str:
    """Embeddings `[count, 32]` of one view; `bias`: the first layer's."""

    def conv(value: str, weight: np.ndarray, bias: np.ndarray) -> str:
        kernel = weight.shape[-1]
        weights = graph.constant(weight), graph.constant(bias)
        sizes = {"kernel_shape": [kernel, kernel], "strides": [kernel, kernel]}
        return graph.add("Relu", graph.add("Conv", value, *weights, **sizes))

    hidden = conv(pixels, array(encoder.patch.weight), bias)
    hidden = conv(hidden, array(encoder.merge.weight), array(encoder.merge.bias))
    flat = graph.reshape(hidden, count, -1)
    return graph.add(
        "Relu", graph.dense(flat, array(encoder.dense.weight), array(encoder.dense.bias))
    )


def plan(model: Model) -> bytes:
    """A sentence of one step about six objects, to its program, objects and location."""
    graph, language = Graph("plan"), model.language
    tokens = graph.input("tokens", np.int64, [TOKENS])
    concepts = model.vision.concept.weight.shape[0]
    filters = graph.input("filters", np.bool_, [TOKENS, concepts])
    objects = graph.input("embeddings", np.float32, [OBJECTS, network.OBJECT_EMBEDDING])
    locations = graph.input("locations", np.float32, [OBJECTS, network.LOCATION])

    def embedded(table: object) -> str:
        return graph.add("Gather", graph.constant(array(table)[:, None]), tokens, axis=0)

    # Where the step ends: after the last token, if nowhere before.
    chances = hazards(graph, model, embedded(language.splitter.embedding.weight))
    last = np.eye(TOKENS)[:, -1:]
    chances = graph.add("Add", chances, graph.constant(last))
    ends = graph.add("Greater", chances, graph.constant(np.array(0.5)))
    split = graph.add("ArgMax", graph.add("Cast", ends, to=1), axis=0, keepdims=0)
    # The program.
    states = encoder_states(graph, model, embedded(language.embedding.weight))
    half = network.ENCODER_HIDDEN
    ahead = graph.add(
        "Slice",
        states,
        *(graph.constant(np.array(at)) for at in ([TOKENS - 1, 0], [TOKENS, half], [0, 1])),
    )
    back = graph.add(
        "Slice",
        states,
        *(graph.constant(np.array(at)) for at in ([0, half], [1, 2 * half], [0, 1])),
    )
    instruction = graph.add("Concat", ahead, back, axis=1)
    decoder = language.action_decoder
    assert decoder.bias is not None
    logits = graph.dense(instruction, array(decoder.weight), array(decoder.bias))
    action = graph.add("ArgMax", logits, axis=1, keepdims=0)
    decoders = language.object_decoder, language.reference_decoder
    weight = np.concatenate([array(decoder.weight) for decoder in decoders])
    bias = np.concatenate([array(decoder.bias) for decoder in decoders])
    sought = graph.reshape(graph.dense(instruction, weight, bias), 2, network.INSTRUCTION)
    logits = graph.add("Gemm", sought, states, transB=1)
    is_group = graph.add("Equal", tokens, graph.constant(np.array(network.GROUP_TOKEN)))
    logits = graph.add("Where", is_group, logits, graph.constant(np.array(network.MISSING)))
    groups = graph.add("ArgMax", logits, axis=1, keepdims=0)
    # Filter and Unique, for both arguments at once.
    chosen = graph.reshape(graph.add("Gather", filters, groups, axis=0), 2, 1, concepts)
    scores = cosines(graph, model, objects)
    scores = graph.add("Where", chosen, scores, graph.constant(np.array(1.0)))
    scores = graph.add("ReduceMin", scores, axes=[2], keepdims=0)
    found = graph.add("ArgMax", scores, axis=1, keepdims=0)
    # The action.
    places = graph.reshape(graph.add("Gather", locations, found, axis=0), 1, 2 * network.LOCATION)
    action_bias = graph.add("Gather", graph.constant(action_biases(model)), action, axis=0)
    location = moved(graph, model, places, action_bias)
    return graph.bytes(
        {
            "action": (action, np.int64, [1]),
            "split": (split, np.int64, [1]),
            "groups": (groups, np.int64, [2]),
            "objects": (found, np.int64, [2]),
            "location": (location, np.float32, [1, network.LOCATION]),
        }
    )


def encoder(model: Model) -> bytes:
    """Words to the encoder's states."""
    graph = Graph("encoder")
    words = graph.input("words", np.float32, [TOKENS, 1, network.WORD])
    states = encoder_states(graph, model, words)
    return graph.bytes({"states": (states, np.float32, [TOKENS, network.INSTRUCTION])})


def splitter(model: Model) -> bytes:
    """Words to the hazard at each."""
    graph = Graph("splitter")
    words = graph.input("splitter_words", np.float32, [TOKENS, 1, network.SPLITTER_WORD])
    chances = hazards(graph, model, words)
    return graph.bytes({"hazards": (chances, np.float32, [TOKENS, 1])})


def simulator(model: Model) -> bytes:
    """An action's number and two locations to the moved object's location."""
    graph = Graph("simulator")
    action = graph.input("action", np.int64, [1])
    pair = graph.input("pair", np.float32, [1, 2 * network.LOCATION])
    action_bias = graph.add("Gather", graph.constant(action_biases(model)), action, axis=0)
    location = moved(graph, model, pair, action_bias)
    return graph.bytes({"location": (location, np.float32, [1, network.LOCATION])})


def crops_graph(count: int, reduced: bool) -> Callable[[Model], bytes]:
    """The graph of some crops at once; `reduced`: see `embeddings`."""

    def made(model: Model) -> bytes:
        graph = Graph("crops")
        shape = [count, 3, network.CROP, network.CROP]
        pixels = graph.input("crops", np.float32, shape)
        result = embeddings(graph, model, pixels, count, reduced)
        return graph.bytes({"embeddings": (result, np.float32, [count, network.OBJECT_EMBEDDING])})

    return made


GRAPHS: dict[str, Callable[[Model], bytes]] = {
    "plan": plan,
    "encoder": encoder,
    "splitter": splitter,
    "simulator": simulator,
    "crop": crops_graph(1, reduced=False),
    "crops": crops_graph(OBJECTS, reduced=True),
}
"""The graph of each job."""
VARIANTS: dict[str, tuple[str, Callable[[Model], bytes]]] = {
    "crops-split": ("crops", crops_graph(OBJECTS, reduced=False)),
}
"""Graphs with the name of their job that are faster in tract, whose `ReduceMax` takes ten times as
long as all the rest."""
