"""Measures how sentences with relations and extremes in descriptions, and about several objects,
are understood and grounded, through the core.

They are about episodes of one step, and best about scenes in which blocks stand on each other. A
sentence is right if its program is the one that was meant; in its scene, if the plan moves the
right block to the right other one. Descriptions that hold for no block of the scene or for several
must be refused there. Superlatives, "nearest to" and "farthest from", extremes, "leftmost",
ordinals, "second from the left", several blocks, "all red ones", also with exceptions, what is put
on the table, what next to another block or diagonally from it, and what is moved by a distance, are
counted apart.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import nsrm
import numpy as np

from nsrm_harness.data.distances import DistanceSentences
from nsrm_harness.data.exceptions import ExceptionSentences, excepted_programs
from nsrm_harness.data.file import Demonstrations
from nsrm_harness.data.ground_truth import GroundTruth, Truth
from nsrm_harness.data.seeds import generator
from nsrm_harness.data.several import Several, has_stack, several_programs
from nsrm_harness.data.shifts import ShiftSentences
from nsrm_harness.data.tell import (
    counted_programs,
    extreme_programs,
    misleading_counts,
    misleading_extremes,
    misleading_programs,
    related_programs,
)
from nsrm_harness.domain import Domain
from nsrm_harness.domain.everyday import Speaker
from nsrm_harness.domain.program import ITSELF, SUPERLATIVES, Program
from nsrm_harness.evaluation.compounds import PutBeside, put_beside
from nsrm_harness.evaluation.language import Counted, count, say, understand
from nsrm_harness.evaluation.metrics import check_domain, domain_of
from nsrm_harness.evaluation.observed import chunks, objects_of, observe_episode
from nsrm_harness.evaluation.on_table import PutOnTable, put_on_table

Programs = Callable[[Domain, Truth, np.random.Generator, int], list[Program]]
SeveralPrograms = Callable[
    [Domain, Truth, np.random.Generator, int], tuple[list[Several], list[Several]]
]
"""So many random programs of an episode."""
TIMES = 3
"""Number of sentences of each kind about an episode."""


@dataclass(frozen=True)
class EpisodeSentence:
    """A sentence about an episode."""

    episode: int
    program: Program
    #: Ids of the blocks to be moved, in any order, and of the other one; None if it must be
    #: refused.
    blocks: tuple[tuple[int, ...], int] | None

    def is_done_by(self, plan: nsrm.Plan) -> bool:
        """Whether the plan moves the right blocks, one after the other, and each of them beside or
        on the one before."""
        moved = tuple(step.object_id for step in plan.steps)
        if self.blocks is None or sorted(moved) != sorted(self.blocks[0]):
            return False
        references = [step.reference_id for step in plan.steps]
        return references == [self.blocks[1], *moved[:-1]]


Sentence = EpisodeSentence | PutOnTable | PutBeside
"""A sentence about an episode."""


def measure_relations(
    model: nsrm.Model, path: Path, seed: int, quiet: bool = False
) -> list[Counted]:
    """Sentences about the episodes of one step of a file."""
    with Demonstrations(path) as demonstrations, GroundTruth(path) as judge:
        check_domain(model, demonstrations)
        domain = domain_of(model, demonstrations.domain)
        if domain.everyday is None or not domain.everyday.states():
            return []
        rows: list[Counted] = []
        known = set(domain.everyday.states())

        def in_scenes(
            name: str, told: list[EpisodeSentence], misleading: list[EpisodeSentence]
        ) -> list[Counted]:
            sets = {"in scenes": told, "of none or several": misleading}
            return [
                _grounded(
                    model,
                    demonstrations,
                    f"{name} {ending}",
                    chosen,
                    _words(domain, chosen, seed),
                    quiet,
                )
                for ending, chosen in sets.items()
            ]

        sets: dict[str, tuple[Programs, Programs]] = {}
        for name, names in (
            ("relations", known - {*SUPERLATIVES}),
            ("superlatives", known & {*SUPERLATIVES}),
        ):
            if names:
                true, untrue = (
                    partial(each, names=names) for each in (related_programs, misleading_programs)
                )
                sets[name] = true, untrue
        if domain.extremes:
            sets["extremes"] = extreme_programs, misleading_extremes
        for name, (true, untrue) in sets.items():
            told, misleading = _programs(domain, judge, seed, true, untrue)
            said = say(domain, [each.program for each in told], seed)
            rows += [count(f"{name}{ending}", understand(model, said[ending])) for ending in said]
            rows += in_scenes(name, told, misleading)
        if domain.ordinals is not None:
            told, misleading = _programs(domain, judge, seed, counted_programs, misleading_counts)
            rows += in_scenes("ordinals", told, misleading)
        if domain.several is not None:
            moved = _several(domain, judge, seed, "several", several_programs)
            if domain.exceptions is not None:
                moved |= _several(domain, judge, seed, "exceptions", excepted_programs)
            for title, chosen in moved.items():
                words = _words(domain, chosen, seed)
                rows.append(_grounded(model, demonstrations, title, chosen, words, quiet))
        if domain.table is not None:
            for title, put in put_on_table(domain, judge).items():
                words = _words(domain, put, seed)
                rows.append(_grounded(model, demonstrations, title, put, words, quiet))
        for title, beside in put_beside(domain, judge, seed).items():
            words = _words(domain, beside, seed)
            rows.append(_grounded(model, demonstrations, title, beside, words, quiet))
        return rows


def _several(
    domain: Domain, judge: GroundTruth, seed: int, name: str, programs: SeveralPrograms
) -> dict[str, list[EpisodeSentence]]:
    """Sentences that move several blocks of the scenes, by the name of their set."""
    sets: dict[str, list[EpisodeSentence]] = {
        f"{name} in scenes": [],
        f"{name} in scenes with stacks": [],
        f"{name} of another number": [],
    }
    told, hidden, misleading = sets.values()
    for index in range(len(judge)):
        rng, truth = generator(seed, name, index), judge.truth(index)
        true, untrue = programs(domain, truth, rng, TIMES)
        # What carries another block is hidden in part, and so is what it may look like.
        chosen = hidden if has_stack(truth) else told
        chosen += [
            EpisodeSentence(index, each.program, (each.moved, each.reference)) for each in true
        ]
        misleading += [EpisodeSentence(index, each.program, None) for each in untrue]
    return sets


def _programs(
    domain: Domain, judge: GroundTruth, seed: int, true: Programs, untrue: Programs
) -> tuple[list[EpisodeSentence], list[EpisodeSentence]]:
    """Programs that are true, and that hold for no block or for several."""
    told: list[EpisodeSentence] = []
    misleading: list[EpisodeSentence] = []
    for index in range(len(judge)):
        truth, rng = judge.truth(index), generator(seed, "related", index)
        for program in true(domain, truth, rng, TIMES):
            (step,) = truth.steps
            told.append(EpisodeSentence(index, program, ((step.object_id,), step.reference_id)))
        for program in untrue(domain, truth, rng, TIMES):
            misleading.append(EpisodeSentence(index, program, None))
    return told, misleading


def _words(domain: Domain, told: Sequence[Sentence], seed: int) -> list[str]:
    """A sentence for each program."""
    return [
        _said(domain, each.program, generator(seed, "told", number))
        for number, each in enumerate(told)
    ]


def _said(domain: Domain, program: Program, rng: np.random.Generator) -> str:
    (first, *_) = program
    if first.object_except is not None:
        return ExceptionSentences(domain, rng).of_step(first)
    if first.reference_which == ITSELF:
        return ShiftSentences(domain, rng).of_step(first)
    if first.distance_mm is not None:
        return DistanceSentences(domain, rng).of_side(first)
    return " ".join(Speaker(domain, rng).sentence(program))


def _grounded(
    model: nsrm.Model,
    demonstrations: Demonstrations,
    name: str,
    told: Sequence[Sentence],
    sentences: Sequence[str],
    quiet: bool,
) -> Counted:
    """How the sentences are planned in their scenes."""
    right = refused = 0
    by_episode: dict[int, list[int]] = {}
    for number, each in enumerate(told):
        by_episode.setdefault(each.episode, []).append(number)
    for chunk in chunks(demonstrations, name, quiet):
        numbers: list[int] = []
        observed: list[nsrm.Observed] = []
        for index in chunk:
            own = by_episode.get(index, [])
            if own:
                objects = objects_of(demonstrations, index, "mask")
                numbers += own
                observed += [observe_episode(demonstrations, index, objects)] * len(own)
        plans = model.plan_all(observed, [sentences[number] for number in numbers])
        for number, plan in zip(numbers, plans, strict=True):
            if isinstance(plan, nsrm.Refused):
                refused += 1
            else:
                right += told[number].is_done_by(plan)
    return Counted(name, len(told), right, refused, len(told) - right - refused)
