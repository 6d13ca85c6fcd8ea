"""Tells demonstrations in everyday wording: many sentences for each episode of a file, and near
misses."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection
from pathlib import Path

import numpy as np

from nsrm_harness.data.extremes import ExtremeDescriptions
from nsrm_harness.data.ground_truth import GroundTruth, Truth
from nsrm_harness.data.near_misses import NearMisses
from nsrm_harness.data.ordinals import CountedDescriptions
from nsrm_harness.data.plain_wording import plain_words
from nsrm_harness.data.relations import Described, RelatedDescriptions, step_of
from nsrm_harness.data.seeds import generator
from nsrm_harness.data.told import Told
from nsrm_harness.domain import Domain
from nsrm_harness.domain.attachment import Attachments
from nsrm_harness.domain.everyday import Speaker, everyday_of
from nsrm_harness.domain.grammar import Grammar
from nsrm_harness.domain.program import SUPERLATIVES, Program, Step
from nsrm_harness.domain.reader import MAX_STEPS
from nsrm_harness.domain.tokens import Tokenizer

#: Number of sentences of which one is plain.
PLAIN = 3
#: Number of sentences about a single step, plain or not, of which one describes an object by its
#: relations, if the domain has any.
RELATED = 2
#: Share of descriptions with two relations among those with any.
CHAINED = 0.15
#: Share of descriptions by superlatives among those with relations.
COMPARED = 0.4
#: Share of everyday sentences about a single step that are told as a later step.
LATER = 0.5
#: A combination is impossible if chance would give at least so many programs, and there are none.
EXPECTED = 20.0


def tell(domain: Domain, episodes: Path, count: int, near_misses: int, seed: int) -> Told:
    """`count` sentences for each episode of a file, and so many near misses.

    One of `PLAIN` sentences, at least one, is in the grammar that a model is first trained on.
    Where a relation may belong to either of two descriptions, nobody can tell what is meant: such a
    sentence is one more near miss. So are commands that no demonstrator carries out: "put the red
    block left of the one on the blue block", where nothing would support it.

    Half of the everyday sentences about a single step are told as if steps came before it ("and
    then put …"): relations are shown by single steps alone, and said in every step.

    `domain`: that of the episodes, with everyday wording.
    """
    told, grammar, shown = Told([], [], [], [], []), Grammar(domain), Counter[tuple[str, str]]()
    plain = -(-count // PLAIN)
    attachments, tokenizer = Attachments(domain), Tokenizer(domain)
    with GroundTruth(episodes) as judge:
        for number in range(len(judge)):
            rng = generator(seed, "told", number)
            truth = judge.truth(number)
            speaker = Speaker(domain, rng)
            programs = [truth.program] * count
            # Every `RELATED`th of the plain ones and of the others.
            related = related_programs(domain, truth, rng, count // RELATED)
            programs[: len(related) * RELATED : RELATED] = related
            shown.update(
                (step.action, step.reference_relations[0].name)
                for (step,) in related
                if step.reference_relations
            )
            for index, program in enumerate(programs):
                is_later = index >= plain and len(program) == 1 and rng.random() < LATER
                if index < plain:
                    words = plain_words(domain, grammar, rng, program)
                    sentence = grammar.spell(rng, words)
                elif is_later:
                    number_of_step = int(rng.integers(1, MAX_STEPS))
                    (step,) = program
                    sentence = " ".join(speaker.step(step, number_of_step, "{next}"))
                else:
                    sentence = " ".join(speaker.sentence(program))
                if len(program) == 1 and attachments.is_ambiguous(tokenizer(sentence).words):
                    told.near_misses.append(sentence)
                else:
                    told.sentences.append(sentence)
                    told.episodes.append(number)
                    told.later.append(is_later)
    misses = NearMisses(domain, generator(seed, "near_misses", 0), never_shown(shown))
    for _ in range(near_misses):
        miss = misses.draw()
        (told.untimely if miss.is_untimely else told.near_misses).append(miss.sentence)
    return told


def never_shown(shown: Counter[tuple[str, str]]) -> list[tuple[str, str]]:
    """The combinations of an action and a relation of its reference that nobody demonstrates,
    though each of the two is frequent."""
    actions, relations = Counter[str](), Counter[str]()
    for (action, relation), count in shown.items():
        actions[action] += count
        relations[relation] += count
    least = EXPECTED * shown.total()
    return sorted(
        (action, relation)
        for action in actions
        for relation in relations
        if (action, relation) not in shown and actions[action] * relations[relation] >= least
    )


def related_programs(
    domain: Domain,
    truth: Truth,
    rng: np.random.Generator,
    count: int,
    names: Collection[str] | None = None,
) -> list[Program]:
    """Random programs of an episode with one step, which describe an object by its relations: that
    to be moved, the reference, or both. None if there are no such programs.

    `names`: the relations; all of the domain by default
    """
    if len(truth.steps) != 1 or not everyday_of(domain).states():
        return []
    (step,) = truth.steps
    relations = RelatedDescriptions(domain, truth, names)
    blocks = (step.object_id - 1, step.reference_id - 1)
    every = [{links: relations.of(block, links) for links in (1, 2)} for block in blocks]
    if not any(any(found.values()) for found in every):
        return []
    programs: list[Program] = []
    while len(programs) < count:
        which = rng.permutation(2)[: 1 if rng.random() < 0.8 else 2]
        links = 2 if rng.random() < CHAINED else 1
        said = _said(step.step)
        for argument in which:
            found = every[argument][links]
            if found:
                said[argument] = _any(rng, found)
        moved, reference = said
        if moved.relations or reference.relations:
            programs.append((step_of(step.step.action, moved, reference),))
    return programs


def misleading_programs(
    domain: Domain,
    truth: Truth,
    rng: np.random.Generator,
    count: int,
    names: Collection[str] | None = None,
) -> list[Program]:
    """Random programs of an episode with one step, in which a description with a relation holds for
    no block or for several. None if there are no such programs.

    `names`: the relations; all of the domain by default
    """
    if len(truth.steps) != 1 or not everyday_of(domain).states():
        return []
    (step,) = truth.steps
    every = RelatedDescriptions(domain, truth, names).misleading()
    return _with_one(step.step, rng, count if every else 0, lambda: _any(rng, every))


def extreme_programs(
    domain: Domain, truth: Truth, rng: np.random.Generator, count: int
) -> list[Program]:
    """Random programs of an episode with one step, in which the object to be moved, the reference
    or both are extremes. None if there are no such programs."""
    if len(truth.steps) != 1:
        return []
    return _with_some(truth, rng, count, ExtremeDescriptions(domain, truth).of)


def counted_programs(
    domain: Domain, truth: Truth, rng: np.random.Generator, count: int
) -> list[Program]:
    """Random programs of an episode with one step, in which the object to be moved, the reference
    or both are counted from an extreme. None if there are no such programs."""
    if len(truth.steps) != 1:
        return []
    return _with_some(truth, rng, count, CountedDescriptions(domain, truth).of)


def _with_some(
    truth: Truth,
    rng: np.random.Generator,
    count: int,
    described: Callable[[int], list[Described]],
) -> list[Program]:
    """The only step of an episode, with other descriptions of one or both of its objects, so many
    times; none if there are no others.

    `described`: those of a block
    """
    (step,) = truth.steps
    every = [described(block - 1) for block in (step.object_id, step.reference_id)]
    programs: list[Program] = []
    while any(every) and len(programs) < count:
        said = _said(step.step)
        for argument in rng.permutation(2)[: 1 if rng.random() < 0.8 else 2]:
            if every[argument]:
                said[argument] = every[argument][int(rng.integers(len(every[argument])))]
        if any(each.which is not None for each in said):
            programs.append((step_of(step.step.action, *said),))
    return programs


def misleading_extremes(
    domain: Domain, truth: Truth, rng: np.random.Generator, count: int
) -> list[Program]:
    """Random programs of an episode with one step, in which an extreme of several blocks is not
    clear, or no block fits. None if there are no such programs."""
    if len(truth.steps) != 1:
        return []
    (step,) = truth.steps
    extremes = ExtremeDescriptions(domain, truth)
    every = [kind for kind in (extremes.unclear(), extremes.absent()) if kind]

    def drawn() -> Described:
        chosen = every[int(rng.integers(len(every)))]
        return chosen[int(rng.integers(len(chosen)))]

    return _with_one(step.step, rng, count if every else 0, drawn)


def misleading_counts(
    domain: Domain, truth: Truth, rng: np.random.Generator, count: int
) -> list[Program]:
    """Random programs of an episode with one step, in which it is not clear which block has the
    number, or none has it. None if there are no such programs."""
    if len(truth.steps) != 1:
        return []
    (step,) = truth.steps
    every = CountedDescriptions(domain, truth).misleading()
    return _with_one(
        step.step, rng, count if every else 0, lambda: every[int(rng.integers(len(every)))]
    )


def _with_one(
    step: Step, rng: np.random.Generator, count: int, drawn: Callable[[], Described]
) -> list[Program]:
    """The step with another description of one of its objects, so many times."""
    programs: list[Program] = []
    for _ in range(count):
        said = _said(step)
        said[int(rng.integers(2))] = drawn()
        programs.append((step_of(step.action, *said),))
    return programs


def _said(step: Step) -> list[Described]:
    """The plain descriptions of a step."""
    return [Described(step.object, ()), Described(step.reference, ())]


def _any(rng: np.random.Generator, found: list[Described]) -> Described:
    """One of them: first whether it compares, and whether it has values, so that the few without
    are said, too."""
    compared = [each for each in found if each.relations[0].name in SUPERLATIVES]
    if 0 < len(compared) < len(found):
        directed = [each for each in found if each.relations[0].name not in SUPERLATIVES]
        found = compared if rng.random() < COMPARED else directed
    bare = [each for each in found if not each.concepts]
    named = [each for each in found if each.concepts]
    chosen = bare if bare and (not named or rng.random() < 0.5) else named
    return chosen[int(rng.integers(len(chosen)))]
