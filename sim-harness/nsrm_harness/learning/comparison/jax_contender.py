"""The trainer's own model, compiled by JAX."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import equinox as eqx
import jax
import jax.numpy as jnp
from jax import Array

from nsrm_harness.learning.comparison.protocol import Work, inputs_of, serve
from nsrm_harness.learning.export import read_model
from nsrm_harness.learning.model import Model

Function = Callable[..., dict[str, Array]]
"""From a job's inputs, in the order of its graph's, to its outputs by name."""


def plan(model: Model) -> Function:
    """A sentence of one step about some objects, to its program, objects and location."""

    def run(tokens: Array, filters: Array, embeddings: Array, locations: Array) -> dict[str, Array]:
        valid = jnp.ones(len(tokens), bool)
        language, simulator = model.language, model.action.simulator
        ends = jax.nn.sigmoid(language.splitter(tokens, valid)) > 0.5
        parse = language.parse(tokens, valid)
        action = jnp.argmax(parse.action)
        groups = jnp.stack([jnp.argmax(parse.object), jnp.argmax(parse.reference)])
        cosines = jax.vmap(model.vision.similarities)(embeddings)
        scores = jnp.where(filters[groups][:, None], cosines, 1.0).min(axis=2)
        objects = jnp.argmax(scores, axis=1)
        one_hot = jax.nn.one_hot(action, len(parse.action))
        return {
            "action": action,
            "split": jnp.argmax(ends.at[-1].set(True)),
            "groups": groups,
            "objects": objects,
            "location": simulator(one_hot, locations[objects[0]], locations[objects[1]]),
        }

    return run


def encoder(model: Model) -> Function:
    """Words to the encoder's states."""

    def run(words: Array) -> dict[str, Array]:
        valid = jnp.ones(len(words), bool)
        return {"states": model.language.encoder(words[:, 0], valid)[0]}

    return run


def splitter(model: Model) -> Function:
    """Words to the hazard at each; the trainer's splitter looks them up by their number."""

    def run(words: Array) -> dict[str, Array]:
        known = eqx.tree_at(lambda module: module.embedding.weight, model.language.splitter, words)
        tokens = jnp.arange(len(words))
        return {"hazards": jax.nn.sigmoid(known(tokens, jnp.ones(len(words), bool)))}

    return lambda words: run(words[:, 0])


def simulator(model: Model) -> Function:
    """An action's number and two locations to the moved object's location."""

    def run(action: Array, pair: Array) -> dict[str, Array]:
        one_hot = jax.nn.one_hot(action[0], len(model.language.action_decoder.weight))
        return {"location": model.action.simulator(one_hot, *pair.reshape(2, -1))}

    return run


def crops(model: Model) -> Function:
    """Crops to their embeddings."""
    return lambda pixels: {"embeddings": jax.vmap(model.vision.encode)(pixels)}


FUNCTIONS: dict[str, Callable[[Model], Function]] = {
    "plan": plan,
    "encoder": encoder,
    "splitter": splitter,
    "simulator": simulator,
    "crop": crops,
    "crops": crops,
}
"""The function of each job."""


def main() -> None:
    """Answers the driver."""
    jax.config.update("jax_enable_x64", True)  # Token numbers are int64; the weights stay f32.
    loaded: dict[Path, Model] = {}

    def prepare(folder: Path, job: str) -> Work:
        path = folder / "model.safetensors"
        if path not in loaded:
            loaded[path] = read_model(path).model
        inputs = [jnp.asarray(values) for values in inputs_of(folder, job).values()]
        compiled = jax.jit(FUNCTIONS[job](loaded[path])).lower(*inputs).compile()
        return Work(
            run=lambda: jax.block_until_ready(compiled(*inputs)),
            outputs=lambda: dict(jax.device_get(compiled(*inputs))),
        )

    serve(f"JAX {jax.__version__}", prepare)


if __name__ == "__main__":
    main()
