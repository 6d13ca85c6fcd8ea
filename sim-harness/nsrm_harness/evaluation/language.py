"""Measures how many sentences a model understands, and how many it obeys that it should refuse,
through the core.

A sentence is right if its program is the one that was meant, whatever the scene. The sets are:

* the sentences of episode files, in the grammar that a model is first trained on;
* the same with one word misspelt, if the model reads misspelt words as known ones;
* their programs in everyday wording, as `data.tell` tells them, apart by whether training leaves
  out the pattern of one of their steps (`domain.patterns`);
* programs of one to five steps that mix all kinds of descriptions (`data.mixed`);
* the same programs with several objects that are moved in one of their steps, "all red blocks", and
  with several references, which nobody can put anything on;
* the episodes' programs with values that stand apart, and with two of one type (`data.apart`);
* what is left out of a description, and such that leaves nothing out (`data.exceptions`);
* what is taken back or ruled out, and such of which nobody can tell what is meant (`data.repairs`);
* two steps in another order than that in which they are carried out, and such that have none
  (`data.sequences`);
* what is counted from one side, and such that counts nothing (`data.ordinals`);
* what is put on the table or stands on it, and such that nobody can do (`data.on_table`);
* compounds of actions, "next to", and such that mean nothing (`data.compounds`);
* a distance from a reference, or from where an object is, and such that mean none
  (`data.distances`, `data.shifts`);
* towers and rows, several steps in a few words, and such that mean none (`data.arranged`);
* the programs of several steps, one of which says by a pronoun what the step before it moved, and
  pronouns that mean nothing;
* sentences with relations in descriptions (`evaluation.relations`);
* near misses, all of whose words the model knows;
* lists of other people's sentences, with the program that they mean or none; those without one
  also with one word misspelt, in `MISSPELT_TIMES` ways.
"""

from __future__ import annotations

import csv
import json
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import nsrm
import numpy as np

from nsrm_harness.data.apart import ApartSentences
from nsrm_harness.data.arranged import ArrangedSentences
from nsrm_harness.data.between import BetweenSentences, between_of
from nsrm_harness.data.compounds import CompoundSentences
from nsrm_harness.data.distances import DistanceSentences
from nsrm_harness.data.exceptions import ExceptionSentences
from nsrm_harness.data.file import Demonstrations
from nsrm_harness.data.ground_truth import GroundTruth
from nsrm_harness.data.listed import ListedSentences
from nsrm_harness.data.mixed import MixedPrograms
from nsrm_harness.data.near_misses import NearMisses
from nsrm_harness.data.on_table import TableSentences
from nsrm_harness.data.ordinals import OrdinalSentences
from nsrm_harness.data.perspectives import PerspectiveSentences
from nsrm_harness.data.pronouns import with_pronoun, without_meaning
from nsrm_harness.data.repairs import RepairSentences
from nsrm_harness.data.rephrased import RephrasedSentences
from nsrm_harness.data.seeds import generator
from nsrm_harness.data.sequences import SequenceSentences
from nsrm_harness.data.several import with_several
from nsrm_harness.data.shifts import ShiftSentences
from nsrm_harness.data.wordy import WordySentences
from nsrm_harness.domain import Domain
from nsrm_harness.domain.attachment import Attachments
from nsrm_harness.domain.everyday import Speaker
from nsrm_harness.domain.patterns import is_reserved
from nsrm_harness.domain.program import Program, Step, canonical
from nsrm_harness.domain.spelling import Misspeller
from nsrm_harness.domain.tokens import Tokenizer
from nsrm_harness.domain.tokens import split as split_words
from nsrm_harness.evaluation.metrics import EvaluationError, check_domain, domain_of


@dataclass(frozen=True)
class Counted:
    """How a set of sentences was understood."""

    set: str
    count: int
    right: int
    refused: int
    wrong: int
    """Understood as another program; of near misses, as any."""

    def __str__(self) -> str:
        share = 100 / max(self.count, 1)
        return (
            f"{self.set}: {self.count} sentences, {self.right * share:.2f} % right, "
            f"{self.refused * share:.2f} % refused, {self.wrong * share:.2f} % wrong ({self.wrong})"
        )


Sentences = list[tuple[str, Program | None]]
"""Sentences, each with the program that is meant, or None if it must be refused."""
MISSPELT_TIMES = 10
"""How often each sentence that must be refused is misspelt."""
PRONOUN_TIMES = 3
"""How often a program of several steps is said with a pronoun."""
MIXED_STEPS, MIXED_COUNT = (1, 2, 3, 5), 1000
"""Numbers of steps of programs that mix all kinds of descriptions, and how many of each."""
CONSTRUCT_COUNT = 2000
"""How many sentences of each construct, and how many with its words that must be refused."""
COLUMNS = ("set", "seed", "count", "right", "refused", "wrong")


@dataclass(frozen=True)
class ParsedSentence:
    """A sentence and what was made of it."""

    sentence: str
    #: The program, or None for a near miss.
    meant: Program | None
    #: None if it was refused.
    understood: Program | None
    #: The refusal in words.
    refusal: str = ""

    @property
    def is_right(self) -> bool:
        """Whether it was understood as it was meant."""
        if self.meant is None or self.understood is None:
            return False
        return canonical(self.meant) == canonical(self.understood)

    @property
    def is_wrong(self) -> bool:
        """Whether something else would be done than was said."""
        return self.understood is not None and not self.is_right


def measure_episodes(model: nsrm.Model, path: Path, seed: int) -> list[Counted]:
    """The sentences of an episode file, and its programs in everyday wording if the model was
    taught that."""
    with Demonstrations(path) as demonstrations, GroundTruth(path) as judge:
        check_domain(model, demonstrations)
        domain, split = domain_of(model, demonstrations.domain), demonstrations.split
        programs = [judge.truth(index).program for index in range(len(judge))]
        meant: Sentences = list(zip(demonstrations.sentences, programs, strict=True))
    rows = [count(split, understand(model, meant))]
    if domain.spelling is not None:
        misspelt = Misspeller(domain, generator(seed, "misspelt", 0))
        typed = [(" ".join(misspelt(split_words(said))), program) for said, program in meant]
        rows.append(count(f"{split}; misspelt", understand(model, typed)))
    if domain.everyday is None:
        return rows
    rows += [
        count(f"{split}; everyday wording{ending}", understand(model, sentences))
        for ending, sentences in say(domain, programs, seed).items()
    ]
    sets: dict[str, Sentences] = {}
    if domain.everyday.states():
        sets |= say_mixed(domain, seed)
    if domain.several is not None:
        sets |= say_several(domain, programs, seed)
    if domain.apart is not None:
        sets |= say_apart(domain, programs, seed)
    for construct in CONSTRUCTS:
        if construct.is_known(domain):
            sets |= say_construct(construct, domain, seed)
    if domain.pronouns:
        sets |= say_pronouns(domain, programs, seed)
    return rows + [count(name, understand(model, said)) for name, said in sets.items()]


def say_mixed(domain: Domain, seed: int) -> dict[str, Sentences]:
    """`MIXED_COUNT` sentences of each of `MIXED_STEPS` steps, less those with two readings, by the
    name of their set."""
    sets: dict[str, Sentences] = {}
    for steps in MIXED_STEPS:
        programs = MixedPrograms(domain, generator(seed, "mixed", steps))
        pairs = [programs.draw(steps) for _ in range(MIXED_COUNT)]
        spoken = say(domain, [said for said, _ in pairs], seed, [meant for _, meant in pairs])
        name = f"mixed; {steps} step{'s' if steps > 1 else ''}"
        sets[name] = [*spoken.get("", ()), *spoken.get(" held out", ())]
    return sets


def say_several(domain: Domain, programs: Sequence[Program], seed: int) -> dict[str, Sentences]:
    """A sentence for each program with several objects that are moved in one of its steps, and one
    with several references, by the name of their set."""
    rng = generator(seed, "several", 0)
    told, untrue = zip(*(with_several(program, rng) for program in programs), strict=True)
    sets = {f"several{ending}": sentences for ending, sentences in say(domain, told, seed).items()}
    refused: Sentences = [
        (" ".join(Speaker(domain, generator(seed, "told", number)).sentence(each)), None)
        for number, each in enumerate(untrue)
    ]
    return {**sets, "several references": refused}


def say_apart(domain: Domain, programs: Sequence[Program], seed: int) -> dict[str, Sentences]:
    """A sentence for each program with values that can stand apart, and one with two of one type in
    their place, by the name of their set."""
    sentences = ApartSentences(domain, generator(seed, "apart", 0))
    told = [(sentences.draw(program), program) for program in programs]
    refused = [sentences.near_miss(program) for program in programs]
    return {
        "values apart": [(said, program) for said, program in told if said is not None],
        "values apart of one type": [(said, None) for said in refused if said is not None],
    }


class ConstructSentences(Protocol):
    """Draws sentences of a construct of one domain."""

    def draw(self) -> tuple[str, Program]:
        """A sentence and the program that it means."""
        ...

    def near_miss(self) -> str:
        """A sentence with the construct's words that must be refused."""
        ...


@dataclass(frozen=True)
class Construct:
    """What sentences of its own are drawn for, one after the other from a random stream."""

    stream: str
    sentences: Callable[[Domain, np.random.Generator], ConstructSentences]
    #: Names of the sets of those that mean something, and of those that must be refused.
    name: str
    refused: str
    #: Whether a domain has it.
    is_known: Callable[[Domain], bool]


CONSTRUCTS = (
    Construct(
        "rephrased", RephrasedSentences, "other phrases", "no orders",
        lambda domain: bool(domain.rephrasing),
    ),
    Construct(
        "wordy", WordySentences, "wordy", "no wordy orders",
        lambda domain: domain.simplification is not None,
    ),
    Construct(
        "perspectives", PerspectiveSentences, "points of view", "no points of view",
        lambda domain: domain.perspectives is not None,
    ),
    Construct(
        "listed", ListedSentences, "lists", "no lists",
        lambda domain: domain.lists is not None,
    ),
    Construct(
        "exceptions", ExceptionSentences, "exceptions", "no exceptions",
        lambda domain: domain.exceptions is not None,
    ),
    Construct(
        "repairs", RepairSentences, "repairs", "no repairs",
        lambda domain: domain.repairs is not None,
    ),
    Construct(
        "sequences", SequenceSentences, "order of time", "no order of time",
        lambda domain: domain.sequence is not None,
    ),
    Construct(
        "ordinals", OrdinalSentences, "ordinals", "no ordinals",
        lambda domain: domain.ordinals is not None,
    ),
    Construct(
        "arranged", ArrangedSentences, "towers and rows", "no towers and rows",
        lambda domain: domain.arrangements is not None,
    ),
    Construct(
        "on_table", TableSentences, "on the table", "not on the table",
        lambda domain: domain.table is not None,
    ),
    Construct(
        "compounds", CompoundSentences, "next to and diagonally", "not next to",
        lambda domain: domain.compounds is not None,
    ),
    Construct(
        "between", BetweenSentences, "between", "not between",
        lambda domain: between_of(domain) is not None,
    ),
    Construct(
        "distances", DistanceSentences, "distances", "no distances",
        lambda domain: domain.distances is not None,
    ),
    Construct(
        "shifts", ShiftSentences, "shifts", "no shifts",
        lambda domain: domain.distances is not None,
    ),
)  # fmt: skip


def say_construct(construct: Construct, domain: Domain, seed: int) -> dict[str, Sentences]:
    """`CONSTRUCT_COUNT` sentences of a construct, and as many that must be refused, by the name of
    their set."""
    sentences = construct.sentences(domain, generator(seed, construct.stream, 0))
    return {
        construct.name: [sentences.draw() for _ in range(CONSTRUCT_COUNT)],
        construct.refused: [(sentences.near_miss(), None) for _ in range(CONSTRUCT_COUNT)],
    }


def say_pronouns(domain: Domain, programs: Sequence[Program], seed: int) -> dict[str, Sentences]:
    """`PRONOUN_TIMES` sentences for each program of several steps in which a pronoun stands for
    what the step before moved, and as many in which it means nothing, by the name of their set."""
    rng = generator(seed, "pronouns", 0)
    several = [each for each in programs if len(each) > 1] * PRONOUN_TIMES
    told = [pair for each in several if (pair := with_pronoun(each, rng)) is not None]
    spoken = say(domain, [said for said, _ in told], seed, [meant for _, meant in told])
    nothing = [without_meaning(each, rng) for each in several]
    refused: Sentences = [
        (" ".join(Speaker(domain, generator(seed, "told", number)).sentence(each)), None)
        for number, each in enumerate(nothing)
    ]
    sets = {f"pronouns{ending}": sentences for ending, sentences in spoken.items()}
    return {**sets, "pronouns of nothing": refused}


def say(
    domain: Domain,
    programs: Sequence[Program],
    seed: int,
    meant: Sequence[Program] | None = None,
) -> dict[str, Sentences]:
    """A sentence for each program, by the ending of the name of its set: those in wording of
    training, those with a pattern that training leaves out, and those of which nobody can tell what
    a relation belongs to, which must be refused.

    `meant`: what the programs mean, if they are only how it is said
    """
    said: dict[str, Sentences] = {}
    attachments, tokenizer = Attachments(domain), Tokenizer(domain)
    for number, (program, right) in enumerate(zip(programs, meant or programs, strict=True)):
        steps = Speaker(domain, generator(seed, "told", number)).steps(program)
        sentence = " ".join(word for step in steps for word in step)
        if any(attachments.is_ambiguous(tokenizer(" ".join(step)).words) for step in steps):
            said.setdefault(" with two readings", []).append((sentence, None))
            continue
        reserved = any(is_reserved(tokenizer.pattern(step)) for step in steps)
        said.setdefault(" held out" if reserved else "", []).append((sentence, right))
    return dict(sorted(said.items()))


def measure_near_misses(model: nsrm.Model, domain: Domain, number: int, seed: int) -> Counted:
    """So many near misses of everyday wording."""
    misses = NearMisses(domain, generator(seed, "near_misses", 1))
    sentences = [(misses.sentence(), None) for _ in range(number)]
    return count("near misses", understand(model, sentences))


def read_list(path: Path) -> Sentences:
    """Other people's sentences: tab-separated columns `sentence`, with `\\n` for a new line, and
    `expected`, which is a program as JSON or `REFUSE`. Raises `EvaluationError`."""
    try:
        with path.open(encoding="utf-8", newline="") as file:
            reader = csv.DictReader(file, delimiter="\t", quoting=csv.QUOTE_NONE)
            return [
                (row["sentence"].replace("\\n", "\n"), _program(row["expected"])) for row in reader
            ]
    except (OSError, UnicodeDecodeError, KeyError, ValueError, TypeError) as error:
        raise EvaluationError(
            f"{path}: expected tab-separated columns 'sentence' and 'expected': {error!r}"
        ) from error


def measure_list(model: nsrm.Model, path: Path, domain: Domain, seed: int) -> list[Counted]:
    """The sentences of a list: those that mean a program, and those that must be refused; these
    also with one word misspelt, if the model reads misspelt words as known ones."""
    every = read_list(path)
    sets = (
        (path.stem, [each for each in every if each[1] is not None]),
        (f"{path.stem}; to refuse", [each for each in every if each[1] is None]),
    )
    rows = [count(name, understand(model, chosen)) for name, chosen in sets if chosen]
    name, refused = sets[1]
    if domain.spelling is not None and refused:
        misspelt = Misspeller(domain, generator(seed, "misspelt", 1))
        typed = [
            (" ".join(misspelt(words)), None)
            for words in (split_words(said) for said, _ in refused)
            if misspelt.has_choice(words)
            for _ in range(MISSPELT_TIMES)
        ]
        rows.append(count(f"{name}; misspelt", understand(model, typed)))
    return rows


def _program(text: str) -> Program | None:
    if text == "REFUSE":
        return None
    return tuple(Step.from_json(step) for step in json.loads(text)["steps"])


def understand(
    model: nsrm.Model, sentences: Iterable[tuple[str, Program | None]]
) -> list[ParsedSentence]:
    """What the model makes of each sentence."""
    outcomes = []
    for sentence, meant in sentences:
        try:
            steps = model.parse(sentence).steps
        except nsrm.Refused as refusal:
            outcomes.append(ParsedSentence(sentence, meant, None, str(refusal)))
            continue
        program = tuple(
            Step.from_json(
                {
                    "action": step.action,
                    "object": step.object,
                    "reference": step.reference,
                    "distance_mm": step.distance_mm,
                }
            )
            for step in steps
        )
        outcomes.append(ParsedSentence(sentence, meant, program))
    return outcomes


def count(name: str, outcomes: Sequence[ParsedSentence]) -> Counted:
    """The numbers of a set."""
    refused = sum(each.understood is None for each in outcomes)
    right = sum(each.is_right for each in outcomes)
    wrong = sum(each.is_wrong for each in outcomes)
    return Counted(name, len(outcomes), right, refused, wrong)


def write_rows(path: Path, rows: Sequence[tuple[int, Counted]]) -> None:
    """Writes one row per set and seed, as CSV."""
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        writer.writerows(
            (row.set, seed, row.count, row.right, row.refused, row.wrong) for seed, row in rows
        )


def read_rows(path: Path) -> list[tuple[int, Counted]]:
    """Reads what `write_rows` has written; raises `EvaluationError`."""
    try:
        with path.open(encoding="utf-8", newline="") as file:
            return [
                (
                    int(row["seed"]),
                    Counted(row["set"], *(int(row[name]) for name in COLUMNS[2:])),
                )
                for row in csv.DictReader(file)
            ]
    except (OSError, UnicodeDecodeError, KeyError, ValueError, TypeError) as error:
        raise EvaluationError(
            f"{path}: expected the columns {','.join(COLUMNS)}, as 'harness language' writes them: "
            f"{error!r}"
        ) from error
