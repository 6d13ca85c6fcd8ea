"""Says by a pronoun what the step before moved: "put the red block on the blue one and the green
one on it"."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from nsrm_harness.domain.everyday import PRONOUN
from nsrm_harness.domain.program import Program, Step

#: What is said by a pronoun, in place of the concepts of a description.
_SAID = (PRONOUN,)


def with_pronoun(program: Program, rng: np.random.Generator) -> tuple[Program, Program] | None:
    """A program of several steps in which a random later step is about what the step before it
    moves: as it is said, and what that means. None if it would be about nothing else."""
    at = int(rng.integers(1, len(program)))
    found = with_pronoun_at(program[at], program[at - 1], rng)
    if found is None:
        return None
    said, plain = found
    return _with(program, at, said), _with(program, at, plain)


def with_pronoun_at(step: Step, before: Step, rng: np.random.Generator) -> tuple[Step, Step] | None:
    """A step in which a pronoun stands for what the step before it moves, as it is said and what
    that means. None if both of its objects would be the same, or that object is described by its
    place, which is another one then."""
    if before.object_relations or before.object_which is not None:
        return None
    if rng.random() < 0.5:
        bare = replace(step, object_relations=(), object_which=None)
        said, plain = replace(bare, object=_SAID), replace(bare, object=before.object)
    else:
        bare = replace(step, reference_relations=(), reference_which=None)
        said, plain = replace(bare, reference=_SAID), replace(bare, reference=before.object)
    return None if _is_of_one_object(plain) else (said, plain)


def _is_of_one_object(step: Step) -> bool:
    own = (set(step.object), step.object_relations, step.object_which)
    return own == (set(step.reference), step.reference_relations, step.reference_which)


def without_meaning(program: Program, rng: np.random.Generator) -> Program:
    """A program as it is said, in which a pronoun means nothing: there is no step before it, both
    objects of a step are one, or what it stands for is described by the same words."""
    kind = int(rng.integers(3 if len(program) > 1 else 1))
    if kind == 0:
        argument = "object" if rng.random() < 0.5 else "reference"
        return _with(program, 0, replace(next(iter(program)), **{argument: _SAID}))
    at = int(rng.integers(1, len(program)))
    step, meant = program[at], program[at - 1].object
    if kind == 1:
        return _with(program, at, replace(step, object=_SAID, reference=_SAID))
    one, other = (_SAID, meant) if rng.random() < 0.5 else (meant, _SAID)
    return _with(program, at, replace(step, object=one, reference=other))


def _with(program: Program, at: int, step: Step) -> Program:
    return (*program[:at], step, *program[at + 1 :])
