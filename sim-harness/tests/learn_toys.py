"""A toy world for the tests of learning: drawn squares instead of rendered blocks, no physics.

It has everything that learning needs: boxes and depths from a pinhole camera, crops that show
colour and studs, sentences from the domain's own grammar, and outcomes that follow from the
commands.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from nsrm_harness.domain import Domain
from nsrm_harness.domain.grammar import Grammar, Style
from nsrm_harness.domain.program import Program, Step
from nsrm_harness.domain.tokens import Tokenizer
from nsrm_harness.learning.dataset import Sentences, TrainingSet

CAMERA_POSITION = np.array([1.25, 0.0, 0.75])
LOOK_AT = np.array([0.5, 0.0, 0.0])
FOCAL = np.array([0.9, 1.2])
GAP_M = 0.025
OBJECTS = 5


@dataclass(frozen=True)
class Toys:
    """A training set with the truth beside it."""

    data: TrainingSet
    programs: list[Program]
    objects: np.ndarray
    """Index of the moved object and the reference of each step, `[N, steps, 2]`."""


def make_toys(domain: Domain, count: int, steps: int, seed: int, attributes: int = 2) -> Toys:
    """`count` episodes with commands of `steps` steps, objects named by up to `attributes`."""
    rng = np.random.default_rng(seed)
    grammar, tokenizer = Grammar(domain, Style()), Tokenizer(domain)
    crops, before, after, sentences, programs, objects = [], [], [], [], [], []
    while len(programs) < count:
        values = _distinct_objects(rng, domain)
        chosen = [rng.permutation(OBJECTS)[:2] for _ in range(steps)]
        program = _program(rng, domain, values, chosen, attributes)
        if program is None:
            continue
        edges = np.array([_edges(domain, value) for value in values])
        places = _places(rng, edges)
        before.append(
            [_location(p, e, rng.uniform(0.98, 1.1)) for p, e in zip(places, edges, strict=True)]
        )
        for step, (moved, reference) in zip(program, chosen, strict=True):
            places[moved] = _target(domain, step, places, edges, moved, reference)
        located = list(before[-1])
        for moved in {pair[0] for pair in chosen}:
            located[moved] = _location(places[moved], edges[moved], 1.0)
        after.append(located)
        crops.extend(_crop(rng, domain, value) for value in values)
        sentences.append(tokenizer(grammar.sentence(rng, program).text))
        programs.append(program)
        objects.append(chosen)
    data = TrainingSet(
        sentences=Sentences.of(tokenizer, sentences),
        crops=np.array(crops, np.float32),
        crop_of=np.arange(count * OBJECTS, dtype=np.int32).reshape(count, OBJECTS),
        present=np.ones((count, OBJECTS), bool),
        before=np.array(before, np.float32),
        after=np.array(after, np.float32),
    )
    return Toys(data, programs, np.array(objects))


def join(*parts: Toys) -> Toys:
    """One set of several, padded to the widest."""
    return Toys(
        concatenate([part.data for part in parts]),
        list(itertools.chain.from_iterable(part.programs for part in parts)),
        np.zeros(0),
    )


def concatenate(parts: list[TrainingSet]) -> TrainingSet:
    """Training sets one after the other; the objects' number must agree."""

    def padded(arrays: list[np.ndarray], fill: int) -> np.ndarray:
        shape = np.max([array.shape[1:] for array in arrays], axis=0)
        result = []
        for array in arrays:
            widths = [
                (0, 0),
                *((0, to - now) for to, now in zip(shape, array.shape[1:], strict=True)),
            ]
            result.append(np.pad(array, widths, constant_values=fill))
        return np.concatenate(result)

    offsets = np.cumsum([0, *(len(part.crops) for part in parts[:-1])]).astype(np.int32)
    return TrainingSet(
        sentences=Sentences(
            padded([part.sentences.tokens for part in parts], 0),
            np.concatenate([part.sentences.length for part in parts]),
            padded([part.sentences.groups for part in parts], -1),
            np.concatenate([part.sentences.group_count for part in parts]),
        ),
        crops=np.concatenate([part.crops for part in parts]),
        crop_of=np.concatenate([p.crop_of + o for p, o in zip(parts, offsets, strict=True)]),
        present=np.concatenate([part.present for part in parts]),
        before=np.concatenate([part.before for part in parts]),
        after=np.concatenate([part.after for part in parts]),
    )


def _distinct_objects(rng: np.random.Generator, domain: Domain) -> list[tuple[str, ...]]:
    """Names of each object's values, no two objects alike."""
    names = [[value.name for value in attribute.values] for attribute in domain.attributes]
    every = list(itertools.product(*names))
    return [every[index] for index in rng.permutation(len(every))[:OBJECTS]]


def _program(
    rng: np.random.Generator,
    domain: Domain,
    values: list[tuple[str, ...]],
    chosen: list[np.ndarray],
    attributes: int,
) -> Program | None:
    """A command for the chosen objects, or None where their descriptions would be ambiguous."""
    if len({pair[0] for pair in chosen}) < len(chosen):
        return None
    steps = []
    for moved, reference in chosen:
        names = []
        for index in (moved, reference):
            number = int(rng.integers(1, attributes + 1))
            kinds = rng.permutation(len(domain.attributes))[:number]
            name = tuple(values[index][kind] for kind in kinds)
            if sum(set(name) <= set(value) for value in values) > 1:
                return None
            names.append(name)
        action = domain.actions[int(rng.integers(len(domain.actions)))].name
        steps.append(Step(action, names[0], names[1]))
    return tuple(steps)


def _edges(domain: Domain, values: tuple[str, ...]) -> np.ndarray:
    return np.array(next(e for name in values if (e := domain.concept(name).edges_m)))


def _places(rng: np.random.Generator, edges: np.ndarray) -> np.ndarray:
    places: list[np.ndarray] = []
    while len(places) < OBJECTS:
        at = np.array([*rng.uniform((0.36, -0.24), (0.64, 0.24)), edges[len(places)][2] / 2])
        if all(np.linalg.norm(at[:2] - other[:2]) > 0.08 for other in places):
            places.append(at)
    return np.array(places)


def _target(
    domain: Domain,
    step: Step,
    places: np.ndarray,
    edges: np.ndarray,
    moved: int,
    reference: int,
) -> np.ndarray:
    action, at = domain.action(step.action), places[reference].copy()
    half = (edges[moved] + edges[reference]) / 2
    if action.direction is None:
        at[2] += half[2]
    else:
        at[:2] += np.array(action.direction) * (half[:2] + GAP_M)
        at[2] = edges[moved][2] / 2
    return at


def _location(place: np.ndarray, edges: np.ndarray, turned: float) -> np.ndarray:
    """Box and depth of a block; `turned` widens its base as a small yaw does."""
    forward = LOOK_AT - CAMERA_POSITION
    forward = forward / np.linalg.norm(forward)
    right = np.array([0.0, 1.0, 0.0])
    axes = np.array([right, np.cross(forward, right), forward])
    signs = np.array(list(itertools.product((-0.5, 0.5), repeat=3)))
    points = place + signs * edges * np.array([turned, turned, 1.0]) - CAMERA_POSITION
    x, y, depth = axes @ points.T
    u, v = FOCAL[0] * x / depth + 0.5, FOCAL[1] * y / depth + 0.5
    return np.array([u.min(), v.min(), u.max(), v.max(), depth.mean() - edges[0] / 3])


def _crop(rng: np.random.Generator, domain: Domain, values: tuple[str, ...]) -> np.ndarray:
    """A front and a top face in the block's colour, studs as bright spots, and some noise."""
    concepts = [domain.concept(name) for name in values]
    rgb = np.array(next(value.rgb for value in concepts if value.rgb))
    shade = np.full((32, 32), 0.62)
    shade[: int(rng.integers(12, 18))] = 0.95
    studs = next((value.studs for value in concepts if value.studs), None)
    for row, column in itertools.product(range(studs[0]), range(studs[1])) if studs else ():
        top, left = 2 + row * 6, 5 + column * 14
        shade[top : top + 4, left : left + 8] = 1.15
    shade *= rng.uniform(0.85, 1.1)
    # A size seen by its perspective: a tall block shows more of its front.
    edge = 32 - round(200 * _edges(domain, values)[2])
    shade[edge - 2 : edge] *= 0.8
    noisy = rgb[:, None, None] * shade + rng.normal(0, 0.02, (3, 32, 32))
    return np.clip(noisy, 0.0, 1.0)
