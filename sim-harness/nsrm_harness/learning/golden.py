"""Writes golden vectors: the trainer's own results, with which every other form of the model must
agree.

`tests/golden/README.md` describes them. The layers have random, non-square weights; everything else
is computed with a model file. Scenes come from the validation data.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from nsrm import MAX_TOKENS

from nsrm_harness.common.json_text import json_text
from nsrm_harness.data.file import Demonstrations
from nsrm_harness.domain.tokens import Tokenizer, split
from nsrm_harness.learning import reference
from nsrm_harness.learning.export import ModelFile, identity_of, safetensors_bytes
from nsrm_harness.learning.model import Conv, run_gru
from nsrm_harness.learning.structures import directions, related, remoteness

SEED = 20240
TOLERANCES = {
    "layer": {"absolute": 1e-5, "relative": 1e-5},
    "state": {"absolute": 1e-4, "relative": 1e-4},
    "logit": {"absolute": 1e-3, "relative": 1e-3},
    "probability": {"absolute": 2e-4, "relative": 1e-3},
    "crop": {"absolute": 1e-5, "relative": 1e-5},
    "embedding": {"absolute": 1e-3, "relative": 1e-3},
    "cosine": {"absolute": 1e-4, "relative": 0.0},
    "relation": {"absolute": 5e-4, "relative": 0.0},
    "location": {"absolute": 1e-4, "relative": 0.0},
    "position_m": {"absolute": 2e-4, "relative": 0.0},
}
SCENES = 3
PADDING = 9
RELATED = (
    "put the block left of the red one on the small blue one",
    "take the green block that is on the white one and put it right of the cube on the lego block",
    "put the green block nearest to the white one on the block farthest from the small red one",
)
"""Sentences with relations in descriptions."""

Arrays = dict[str, np.ndarray]


def write_golden(file: ModelFile, data: Path, folder: Path) -> None:
    """Writes `golden.safetensors` and `cases.json`."""
    rng = np.random.default_rng(SEED)
    arrays: Arrays = {}
    arrays |= layers(rng)
    with Demonstrations(data) as demonstrations:
        arrays |= vision(file, demonstrations, rng)
        arrays |= simulator(file, demonstrations, rng)
        sentences, found = language(file, demonstrations)
        arrays |= found
        scenes, plans, found = chains(file, demonstrations)
        arrays |= found
    cases = {
        "seed": SEED,
        "versions": {"jax": jax.__version__, "numpy": np.__version__},
        "model_identity": identity_of(file),
        "tolerances": TOLERANCES,
        "sentences": sentences,
        "scenes": scenes,
        "plans": plans,
        "shapes": {name: list(array.shape) for name, array in sorted(arrays.items())},
    }
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "golden.safetensors").write_bytes(safetensors_bytes(arrays, {"seed": str(SEED)}))
    text = json_text(cases, indent=1, ensure_ascii=False)
    (folder / "cases.json").write_text(text + "\n", encoding="utf-8")


def layers(rng: np.random.Generator) -> Arrays:
    """A linear layer, two convolutions and a recurrent cell with random, non-square weights."""
    keys = iter(jax.random.split(jax.random.key(SEED), 4))
    linear = eqx.nn.Linear(7, 5, key=next(keys))
    patch = biased(Conv(2, 8, 4, next(keys)))
    merge = biased(Conv(8, 3, 2, next(keys)))
    cell = eqx.nn.GRUCell(6, 4, key=next(keys))
    vector = rng.normal(size=(3, 7)).astype(np.float32)
    image = rng.normal(size=(2, 16, 16)).astype(np.float32)
    patches = patch(jnp.asarray(image))
    calm = rng.normal(size=(9, 6)).astype(np.float32)
    arrays = {
        "layer.linear.weight": linear.weight,
        "layer.linear.bias": linear.bias,
        "layer.linear.input": vector,
        "layer.linear.output": jax.vmap(linear)(jnp.asarray(vector)),
        "layer.patch.weight": patch.weight,
        "layer.patch.bias": patch.bias,
        "layer.patch.input": image,
        "layer.patch.output": patches,
        "layer.merge.weight": merge.weight,
        "layer.merge.bias": merge.bias,
        "layer.merge.output": merge(patches),
    }
    for name in ("weight_ih", "weight_hh", "bias", "bias_n"):
        arrays[f"layer.gru.{name}"] = getattr(cell, name)
    # Inputs of thousands drive every gate to 0 or 1.
    for name, inputs in (("calm", calm), ("saturated", calm * 1000.0)):
        valid = jnp.ones(len(inputs), bool)
        arrays[f"layer.gru.{name}.input"] = inputs
        arrays[f"layer.gru.{name}.states"] = run_gru(cell, jnp.asarray(inputs), valid)
    return {name: np.asarray(array, np.float32) for name, array in arrays.items()}


def biased(conv: Conv) -> Conv:
    """A convolution with a bias of its own for each output."""
    return eqx.tree_at(lambda c: c.bias, conv, jnp.linspace(-0.2, 0.3, len(conv.bias)))


def vision(file: ModelFile, demonstrations: Demonstrations, rng: np.random.Generator) -> Arrays:
    """Crops of a noisy image, by their definition; embeddings and cosines of those and others."""
    image = rng.integers(0, 256, (45, 60, 3), dtype=np.uint8)
    boxes = np.array(
        [
            [0.2, 0.3, 0.5, 0.7],
            [0.0, 0.0, 1.0, 1.0],
            [0.9, 0.85, 1.0, 1.0],
            [0.31, 0.52, 0.313, 0.524],
            [0.0, 0.4, 0.05, 0.41],
        ],
        np.float32,
    )
    crops = [reference.crop(image, box.astype(np.float64)) for box in boxes]
    count = len(crops)
    for index in range(SCENES):
        picture = demonstrations.initial_image(index)
        for box in demonstrations.initial_boxes[index, : demonstrations.object_count[index]]:
            crops.append(reference.crop(picture, box.astype(np.float64)))
    crops += [np.zeros((3, 32, 32)), np.ones((3, 32, 32)), np.full((3, 32, 32), 0.37)]
    seen = np.stack(crops).astype(np.float32)
    embeddings = jax.vmap(file.model.vision.encode)(jnp.asarray(seen))
    cosines = jax.vmap(file.model.vision.similarities)(embeddings)
    return {
        "crop.image": image,
        "crop.boxes": boxes,
        "crop.output": seen[:count],
        "vision.crops": seen,
        "vision.embeddings": np.asarray(embeddings),
        "vision.similarities": np.asarray(cosines),
    }


def simulator(file: ModelFile, demonstrations: Demonstrations, rng: np.random.Generator) -> Arrays:
    """All actions on pairs of observed locations, and on a pair far from all data."""
    locations = np.concatenate([_locations(demonstrations, index) for index in range(SCENES)])
    moved = locations[rng.permutation(len(locations))[:6]]
    beside = locations[rng.permutation(len(locations))[:6]]
    beside[-1] = [0.01, 0.02, 0.99, 0.98, 3.0]
    count = len(file.domain.actions)
    action = np.tile(np.arange(count, dtype=np.int32), len(moved))
    moved, beside = np.repeat(moved, count, axis=0), np.repeat(beside, count, axis=0)
    run = jax.vmap(file.model.action.simulator)
    result = np.asarray(run(jax.nn.one_hot(action, count), jnp.asarray(moved), jnp.asarray(beside)))
    camera = demonstrations.camera(0)
    return {
        "simulator.action": action,
        "simulator.moved": moved,
        "simulator.reference": beside,
        "simulator.output": result,
        "camera.position": np.array(
            [reference.locate(file.model.camera, location, camera) for location in result],
            np.float32,
        ),
    }


def language(
    file: ModelFile, demonstrations: Demonstrations
) -> tuple[list[dict[str, Any]], Arrays]:
    """Sentences of the data, three with relations, one with 128 tokens, and one with padding after
    it."""
    tokenizer = Tokenizer(file.domain)
    kinds = {True: 0, False: 0}
    chosen: list[str] = []
    for sentence in demonstrations.sentences:
        single = len(tokenizer(sentence).groups) == 2
        if kinds[single] < 4:
            kinds[single] += 1
            chosen.append(sentence)
    longest = longest_sentence(tokenizer, demonstrations.sentences)
    cases, arrays = [], {}
    for number, sentence in enumerate([*chosen, *RELATED, longest]):
        steps = reference.parse(file.model, tokenizer, sentence)
        described = []
        for index, step in enumerate(steps):
            name = f"sentence.{number}.step.{index}"
            for part in ("hazards", "states", "instruction"):
                arrays[f"{name}.{part}"] = getattr(step, part)
            for part in ("action_logits", "object_logits", "reference_logits", "role_logits"):
                arrays[f"{name}.{part}"] = getattr(step, part)
            concepts = [[file.domain.concepts[c].name for c in group] for group in step.groups]
            described.append(
                {
                    "first": step.first,
                    "end": step.end,
                    "split": step.split,
                    "words": step.words,
                    "groups": concepts,
                }
            )
        tokens = tokenizer(sentence)
        cases.append(
            {
                "sentence": sentence,
                "tokens": list(tokens.words),
                "rows": tokenizer.rows(tokens),
                "steps": described,
            }
        )
    arrays |= _padded(file, tokenizer, chosen[0])
    return cases, arrays


def longest_sentence(tokenizer: Tokenizer, sentences: list[str]) -> str:
    """Commands of the data joined together, filled up to exactly 128 tokens."""
    filler = next(word for word in tokenizer.row if word.isalpha())
    words: list[str] = []
    for sentence in sentences:
        more = split(sentence)
        if len(tokenizer(" ".join([*words, *more])).words) > MAX_TOKENS:
            break
        words += more
    missing = MAX_TOKENS - len(tokenizer(" ".join(words)).words)
    return " ".join([*words, *[filler] * missing])


def _padded(file: ModelFile, tokenizer: Tokenizer, sentence: str) -> Arrays:
    """The first sentence followed by random tokens marked as padding: nothing may change."""
    rows = np.array(tokenizer.rows(tokenizer(sentence)), np.int32)
    behind = np.resize(np.arange(1, len(tokenizer.row), dtype=np.int32), PADDING)
    padded = np.concatenate([rows, behind])
    valid = np.arange(len(padded)) < len(rows)
    exact = file.model.language.parse(jnp.asarray(rows), jnp.ones(len(rows), bool))
    found = file.model.language.parse(jnp.asarray(padded), jnp.asarray(valid))
    for left, right in zip(exact, found, strict=True):
        np.testing.assert_allclose(left, right[: len(left)], rtol=1e-5, atol=1e-5)
    return {"padding.action_logits": np.asarray(found.action)}


def chains(
    file: ModelFile, demonstrations: Demonstrations
) -> tuple[list[dict[str, Any]], list[dict[str, Any]], Arrays]:
    """Scenes with sentences: plans, a tie, and an empty scene."""
    tokenizer = Tokenizer(file.domain)
    scenes, plans, arrays = [], [], {}
    for index in range(SCENES):
        count = int(demonstrations.object_count[index])
        crops = np.stack(
            [
                reference.crop(demonstrations.initial_image(index), box.astype(np.float64))
                for box in demonstrations.initial_boxes[index, :count]
            ]
        ).astype(np.float32)
        embeddings = np.asarray(jax.vmap(file.model.vision.encode)(jnp.asarray(crops)))
        scenes.append(_scene(demonstrations, index, list(range(1, count + 1))))
        locations = _locations(demonstrations, index)
        arrays[f"scene.{index}.locations"] = locations
        cosines = related(file.model, jnp.asarray(locations), demonstrations.camera(index))
        arrays[f"scene.{index}.relations"] = np.asarray(cosines)
        remote = remoteness(file.model, jnp.asarray(locations), demonstrations.camera(index))
        arrays[f"scene.{index}.distances"] = np.asarray(remote[0])
        direction = directions(file.model, jnp.asarray(locations), demonstrations.camera(index))
        arrays[f"scene.{index}.directions"] = np.asarray(direction)
        arrays[f"scene.{index}.crops"] = crops
        arrays[f"scene.{index}.embeddings"] = embeddings
        sentence = demonstrations.sentences[index]
        plan, found = _plan(file, tokenizer, demonstrations, index, embeddings)
        plans.append({"scene": index, "sentence": sentence, "steps": plan})
        arrays |= {f"plan.{index}.{name}": array for name, array in found.items()}
    # The first scene with a copy of the first moved object: two equally good candidates.
    moved = plans[0]["steps"][0]["object_id"]
    twin = int(demonstrations.object_count[0]) + 1
    scenes.append(_scene(demonstrations, 0, [*range(1, twin), twin]))
    for part in ("locations", "crops", "embeddings"):
        array = arrays[f"scene.0.{part}"]
        arrays[f"scene.{SCENES}.{part}"] = np.concatenate([array, array[moved - 1 : moved]])
    refused = {"kind": "ambiguous", "candidates": [moved, twin]}
    plans.append({"scene": SCENES, "sentence": demonstrations.sentences[0], "refused": refused})
    scenes.append(_scene(demonstrations, 0, []))
    for part in ("locations", "crops", "embeddings"):
        arrays[f"scene.{SCENES + 1}.{part}"] = arrays[f"scene.0.{part}"][:0]
    plans.append(
        {
            "scene": SCENES + 1,
            "sentence": demonstrations.sentences[0],
            "refused": {"kind": "no_such_object"},
        }
    )
    return scenes, plans, arrays


def _plan(
    file: ModelFile,
    tokenizer: Tokenizer,
    demonstrations: Demonstrations,
    index: int,
    embeddings: np.ndarray,
) -> tuple[list[dict[str, Any]], Arrays]:
    cosines = np.asarray(jax.vmap(file.model.vision.similarities)(jnp.asarray(embeddings)))
    steps = reference.parse(file.model, tokenizer, demonstrations.sentences[index])
    camera = demonstrations.camera(index)
    planned = reference.plan(file.model, steps, _locations(demonstrations, index), cosines, camera)
    described = []
    for parsed, step in zip(steps, planned, strict=True):
        groups = [
            parsed.groups[int(np.argmax(logits))]
            for logits in (parsed.object_logits, parsed.reference_logits)
        ]
        names = [[file.domain.concepts[concept].name for concept in group] for group in groups]
        described.append(
            {
                "action": file.domain.actions[step.action].name,
                "object": names[0],
                "reference": names[1],
                "object_id": step.object + 1,
                "reference_id": step.reference + 1,
            }
        )
    return described, {
        "object_scores": np.stack([step.object_scores for step in planned]),
        "reference_scores": np.stack([step.reference_scores for step in planned]),
        "locations": np.stack([step.location for step in planned]),
        "positions": np.stack([step.position for step in planned]).astype(np.float32),
    }


def _locations(demonstrations: Demonstrations, index: int) -> np.ndarray:
    count = demonstrations.object_count[index]
    boxes = demonstrations.initial_boxes[index, :count]
    return np.concatenate([boxes, demonstrations.initial_depths[index, :count, None]], axis=1)


def _scene(demonstrations: Demonstrations, index: int, ids: list[int]) -> dict[str, Any]:
    camera = demonstrations.camera(index)
    return {
        "ids": ids,
        "camera": {
            "width": camera.width,
            "height": camera.height,
            "fx": camera.fx,
            "fy": camera.fy,
            "cx": camera.cx,
            "cy": camera.cy,
            "position": list(camera.position),
            "orientation": list(camera.orientation),
        },
    }
