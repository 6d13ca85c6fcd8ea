"""Sentences that must be refused in a scene, by kind of what is wrong with them.

Each is made from a good sentence about the scene, in which one thing is spoilt. A sentence
belongs to one set alone, whatever the scene, by its hash; the sets have their own random
streams and their own episode files. Kinds that the trainer makes steps of, too, have only
patterns that are kept from it (`language.patterns`).
"""

from __future__ import annotations

import hashlib
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np

from nsrm_harness.common.errors import HarnessError
from nsrm_harness.data.seeds import generator
from nsrm_harness.domain import Domain
from nsrm_harness.domain.grammar import Command, Grammar
from nsrm_harness.domain.patterns import is_reserved
from nsrm_harness.domain.program import Program, Step
from nsrm_harness.domain.tokens import Tokenizer, split
from nsrm_harness.evaluation.refusals import topics
from nsrm_harness.evaluation.refusals.reading import Reading

#: Sets of sentences; each takes its scenes from the episode file of the same name.
SETS = ("validation", "test")
#: Sentences of a kind, unless told otherwise.
COUNT = 160
#: Draws for each sentence that is wanted, before the scenes are given up.
MAX_DRAWS = 100
#: Steps of a sentence that has too many; the core's capacity is 8.
TOO_MANY_STEPS = (9, 12)
#: How often a missing action is said in words that the domain knows, where it can be.
FAMILIAR = 0.4
#: What joins two relations or two values, where it joins them at all.
JOINTS = ("and", ",", "")
#: The fields of a command that describe objects.
ARGUMENTS = ("moved", "reference")
#: Fewer letters are no word that can be misspelt and still be told.
LEAST_LETTERS = 3


class RefusalSetError(HarnessError):
    """A file whose scenes do not allow a kind of sentence."""


@dataclass(frozen=True)
class Situation:
    """A scene and a good sentence's program, with the truth about its blocks."""

    #: Number of the episode in its file.
    scene: int
    #: Value of each attribute type, for each block.
    attributes: tuple[dict[str, str], ...]
    program: Program

    def fitting(self, description: Sequence[str]) -> list[int]:
        """The blocks that a description fits, counted from 0."""
        values = set(description)
        return [number for number, own in enumerate(self.attributes) if values <= set(own.values())]


@dataclass(frozen=True)
class Item:
    """A sentence that must be refused."""

    scene: int
    sentence: str
    kind: str
    #: The word that was misspelt.
    meant: str | None = None


def make_items(
    domain: Domain, situations: Sequence[Situation], which: str, count: int = COUNT, seed: int = 0
) -> list[Item]:
    """`count` different sentences of each kind that the domain has.

    The same for the same arguments.

    Raises `RefusalSetError` where the scenes do not allow as many.
    """
    return [
        item
        for number, kind in enumerate(KINDS)
        if domain.grammar.order_words or kind not in OF_ORDER_WORDS
        for item in _items_of(kind, number, domain, situations, which, count, seed)
    ]


def _items_of(
    kind: str,
    number: int,
    domain: Domain,
    situations: Sequence[Situation],
    which: str,
    count: int,
    seed: int,
) -> list[Item]:
    rng = generator(seed, f"refusals_{which}", number)
    spoiler = Spoiler(domain, rng)
    items: dict[str, Item] = {}
    for _ in range(MAX_DRAWS * count):
        if len(items) == count:
            break
        situation = situations[int(rng.integers(len(situations)))]
        spoilt = KINDS[kind](spoiler, situation)
        if spoilt is None or set_of(spoilt.sentence) != which:
            continue
        item = Item(situation.scene, spoilt.sentence, kind, spoilt.meant)
        items.setdefault(_key(spoilt.sentence), item)
    if len(items) < count:
        raise RefusalSetError(
            f"{kind}: {len(items)} sentences found in {len(situations)} scenes, {count} are "
            "wanted: use a file with more episodes, or ask for fewer with --count"
        )
    return list(items.values())


def set_of(sentence: str) -> str:
    """The one set that a sentence may be in; its spelling and punctuation do not matter."""
    return SETS[hashlib.sha256(_key(sentence).encode()).digest()[0] % len(SETS)]


def _key(sentence: str) -> str:
    return " ".join(split(sentence))


@dataclass(frozen=True)
class Spoilt:
    """A sentence, and the word that was misspelt if that is what is wrong with it."""

    sentence: str
    meant: str | None = None


class Spoiler:
    """Makes good sentences bad. Each method is a kind; None: not in this scene."""

    def __init__(self, domain: Domain, rng: np.random.Generator) -> None:
        self._domain = domain
        self._rng = rng
        self._grammar = Grammar(domain)
        self._reads = Reading(domain)
        self._tokenizer = Tokenizer(domain)
        grammar = domain.grammar
        self._known = {*domain.lexicon(), *domain.vocabulary()}
        phrases = [phrase for action in domain.actions for phrase in action.phrases]
        self._content = {
            *domain.lexicon(),
            *grammar.nouns,
            *grammar.verbs,
            *(word for phrase in phrases for word in phrase.split()),
        }
        self._strange = {
            word: self._unknown(strange)
            for words, strange in (
                (domain.lexicon(), topics.VALUES),
                (grammar.nouns, topics.NOUNS),
                (grammar.verbs, topics.VERBS),
            )
            for word in words
        }
        self._joints = [joint for joint in JOINTS if joint in self._known or not joint]
        # Of how many actions a word tells.
        self._relation_words = Counter(
            word
            for action in domain.actions
            for word in {word for phrase in action.phrases for word in phrase.split()}
        )
        relations = [phrase for phrase in topics.RELATIONS if phrase not in phrases]
        self._familiar = [p for p in relations if self._known.issuperset(p.split())]
        self._unfamiliar = [p for p in relations if p not in self._familiar]
        if topics.BETWEEN not in phrases:
            self._unfamiliar.append(topics.BETWEEN)

    @cached_property
    def _subjects(self) -> list[str]:
        return [each for each in topics.other_subjects() if not self._reads(each)]

    def unknown_word(self, situation: Situation) -> Spoilt | None:
        """A word of another world in place of one that is known."""
        words = self._words(situation)
        place = self._place(words, lambda word: word in self._strange)
        words[place] = self._choose(self._strange[words[place]])
        return self._said(words)

    def misspelt(self, situation: Situation) -> Spoilt | None:
        """One letter left out, added, changed or swapped with its neighbour."""
        words = self._words(situation)
        place = self._place(
            words, lambda word: word in self._content and len(word) >= LEAST_LETTERS
        )
        meant, words[place] = words[place], self._misspell(words[place])
        if words[place] in self._known:
            return None
        return Spoilt(self._grammar.spell(self._rng, words), meant)

    def incomplete(self, situation: Situation) -> Spoilt | None:
        """Cut off before the last step's second object, or one object left out."""
        commands = self._commands(situation)
        if self._rng.random() < 0.5:
            return self._unread(self._cut_off(commands))
        dropped = self._choose(("moved", "reference"))
        return self._unread(self._joined(self._change(commands, {dropped: ""})))

    def no_action(self, situation: Situation) -> Spoilt | None:
        """The words that say what is to be done are left out."""
        commands = self._change(self._commands(situation), {"relation": ""})
        return self._unread(self._joined(commands))

    def no_reference(self, situation: Situation) -> Spoilt | None:
        """What to move, but not where to."""
        commands = self._commands(situation)
        place = self._any(len(commands))
        kept = ("{opening}", "{verb}", "{moved}")
        words = [word for word in commands[place].template.split() if word in kept]
        commands[place] = replace(commands[place], template=" ".join(words))
        return self._unread(self._joined(commands))

    def missing_action(self, situation: Situation) -> Spoilt | None:
        """A relation that none of the actions brings about."""
        familiar = self._familiar and self._rng.random() < FAMILIAR
        relation = self._choose(self._familiar if familiar else self._unfamiliar)
        commands = self._commands(situation)
        place = self._any(len(commands))
        fields = {**commands[place].fields, "relation": relation}
        if relation == topics.BETWEEN:
            other = self._description(situation, lambda fitting: len(fitting) == 1)
            if other is None:
                return None
            fields["reference"] += f" and {self._grammar.description(self._rng, other)}"
        commands[place] = replace(commands[place], fields=fields)
        return self._unread(self._joined(commands))

    def negation(self, situation: Situation) -> Spoilt | None:
        """What is not to be done."""
        commands = self._commands(situation)
        if self._rng.random() < 0.75:
            unopened = {**commands[0].fields, "opening": self._choose(topics.PROHIBITIONS)}
            template = _opened(commands[0].template)
            commands[0] = replace(commands[0], template=template, fields=unopened)
        else:
            place = self._any(len(commands))
            relation = commands[place].fields["relation"]
            negated = f"{self._choose(topics.EXCLUSIONS)} {relation}"
            commands[place] = replace(
                commands[place], fields={**commands[place].fields, "relation": negated}
            )
        return self._unread(self._joined(commands))

    def other_subject(self, situation: Situation) -> Spoilt | None:
        """No command for a robot with blocks, or none that has anything to do with it."""
        fixed = self._rng.random() < 0.6
        few = self._subjects[: len(topics.SENTENCES)] if fixed else self._subjects
        return Spoilt(self._choose(few))

    def absent_object(self, situation: Situation) -> Spoilt | None:
        """A description that fits no block of the scene."""
        description = self._description(situation, lambda fitting: not fitting)
        return None if description is None else self._with(situation, description)

    def ambiguous(self, situation: Situation) -> Spoilt | None:
        """A description that fits several blocks, the other object of its step aside."""
        place = self._any(len(situation.program))
        step = situation.program[place]
        moved = self._rng.random() < 0.5
        other = situation.fitting(step.reference if moved else step.object)
        description = self._description(
            situation, lambda fitting: len(set(fitting) - set(other)) > 1
        )
        if description is None:
            return None
        spoilt = (
            replace(step, object=description) if moved else replace(step, reference=description)
        )
        return self._program(_replaced(situation.program, place, spoilt))

    def too_many_steps(self, situation: Situation) -> Spoilt | None:
        """More steps than a program holds, each of them a good one."""
        least, most = TOO_MANY_STEPS
        steps: list[Step] = []
        for _ in range(int(self._rng.integers(least, most + 1))):
            moved = self._description(situation, lambda fitting: len(fitting) == 1)
            if moved is None:
                return None
            taken = situation.fitting(moved)
            reference = self._description(
                situation, lambda fitting, taken=taken: len(fitting) == 1 and fitting != taken
            )
            if reference is None:
                return None
            action = self._domain.actions[self._any(len(self._domain.actions))]
            steps.append(Step(action.name, moved, reference))
        return self._program(tuple(steps))

    def same_object(self, situation: Situation) -> Spoilt | None:
        """A block with regard to itself: by one description, or by two of it."""
        place = self._any(len(situation.program))
        step = situation.program[place]
        meant = situation.fitting(step.object)
        other = self._description(situation, lambda fitting: fitting == meant)
        if other is None or len(meant) != 1:
            return None
        spoilt = replace(step, reference=other)
        return self._program(_replaced(situation.program, place, spoilt))

    def relation_in_description(self, situation: Situation) -> Spoilt | None:
        """An object told by where it is, with no other word for it: "the block left of the red
        block". A good sentence with a relation too many."""
        return self._described_by_relation(situation, described=False)

    def relation_behind_description(self, situation: Situation) -> Spoilt | None:
        """An object told by what it looks like and by where it is: "the green block left of the
        red block"."""
        return self._described_by_relation(situation, described=True)

    def two_relations(self, situation: Situation) -> Spoilt | None:
        """In two places at once: "above and to the left of", "to the top left of"."""
        commands = self._commands(situation)
        place = self._any(len(commands))
        own, action = commands[place].fields["relation"], situation.program[place].action
        other = self._relation(without=action)
        words = own.split()
        if set(words) <= set(other.split()):
            # "On on the right of" is a stammer.
            return None
        if self._rng.random() < 0.5:
            # The whole of another relation before or behind it.
            joined = [own, self._choose(self._joints), other]
            relation = joined if self._rng.random() < 0.5 else joined[::-1]
        else:
            # A word that only the other action has, at a place of its own in this relation.
            foreign = [word for word in other.split() if self._relation_words[word] == 1]
            if not foreign:
                return None
            at = self._any(len(words) + 1)
            relation = [*words[:at], self._choose(foreign), *words[at:]]
        fields = {**commands[place].fields, "relation": " ".join(" ".join(relation).split())}
        commands[place] = replace(commands[place], fields=fields)
        # "On" and "left of" are "on the left of" without an article.
        return self._misused(commands, place) and self._unread(self._joined(commands))

    def ordinal(self, situation: Situation) -> Spoilt | None:
        """Which of several: "the first red block"."""
        commands = self._commands(situation)
        place = self._any(len(commands))
        argument = self._choose(ARGUMENTS)
        words = commands[place].fields[argument].split()
        at = next(i for i, word in enumerate(words) if word in self._domain.lexicon())
        words.insert(at, self._order_word())
        fields = {**commands[place].fields, argument: " ".join(words)}
        commands[place] = replace(commands[place], fields=fields)
        return self._misused(commands, place)

    def order_of_time(self, situation: Situation) -> Spoilt | None:
        """A later command to be carried out before one that is said earlier."""
        commands = self._commands(situation)
        if len(commands) == 1:
            return None
        place = 1 + self._any(len(commands) - 1)
        later = commands[place]
        opened = {**later.fields, "opening": self._order_word()}
        commands[place] = replace(later, template=_opened(later.template), fields=opened)
        return self._misused(commands, place)

    def two_values(self, situation: Situation) -> Spoilt | None:
        """Two values of one attribute in a description: "the red blue block"."""
        commands = self._commands(situation)
        place = self._any(len(commands))
        argument = self._choose(ARGUMENTS)
        words = commands[place].fields[argument].split()
        lexicon = self._domain.lexicon()
        at = self._place(words, lambda word: word in lexicon)
        value = self._domain.concepts[lexicon[words[at]]]
        others = [
            word
            for each in self._domain.attribute(value.attribute).values
            if each.name != value.name
            for word in each.words
        ]
        both = [words[at], self._choose(self._joints), self._choose(others)]
        words[at : at + 1] = both if self._rng.random() < 0.5 else both[::-1]
        fields = {**commands[place].fields, argument: " ".join(" ".join(words).split())}
        commands[place] = replace(commands[place], fields=fields)
        return self._said(self._joined(commands))

    def word_salad(self, situation: Situation) -> Spoilt | None:
        """The words of a good sentence in an order that says nothing."""
        words = self._words(situation)
        return self._unread([words[index] for index in self._rng.permutation(len(words))])

    def _described_by_relation(self, situation: Situation, described: bool) -> Spoilt | None:
        commands = self._commands(situation)
        place = self._any(len(commands))
        argument = self._choose(ARGUMENTS)
        anchor = commands[place].fields[argument]
        article = self._choose(("the", "a")) if self._known.issuperset(("the", "a")) else ""
        head = [article, self._choose(self._domain.grammar.nouns)]
        if described:
            other = self._description(situation, lambda fitting: len(fitting) == 1)
            if other is None:
                return None
            head = [self._grammar.description(self._rng, other)]
        words = [*head, self._relation(), anchor]
        fields = {**commands[place].fields, argument: " ".join(" ".join(words).split())}
        commands[place] = replace(commands[place], fields=fields)
        return self._misused(commands, place)

    def _relation(self, without: str | None = None) -> str:
        """How one of the actions is said."""
        actions = [action for action in self._domain.actions if action.name != without]
        return self._choose(actions[self._any(len(actions))].phrases)

    def _order_word(self) -> str:
        return self._choose(self._domain.grammar.order_words)

    def _misused(self, commands: Sequence[Command], place: int) -> Spoilt | None:
        """None where training may have heard the step."""
        rows = self._tokenizer.rows(self._tokenizer(" ".join(commands[place].words())))
        return self._said(self._joined(commands)) if is_reserved(rows) else None

    def _commands(self, situation: Situation) -> list[Command]:
        return self._grammar.commands(self._rng, situation.program)

    def _words(self, situation: Situation) -> list[str]:
        return self._joined(self._commands(situation))

    @staticmethod
    def _joined(commands: Sequence[Command]) -> list[str]:
        return [word for command in commands for word in command.words()]

    def _program(self, program: Program) -> Spoilt:
        return self._said(self._joined(self._grammar.commands(self._rng, program)))

    def _with(self, situation: Situation, description: tuple[str, ...]) -> Spoilt:
        """A good sentence with this description of one of its objects."""
        place = self._any(len(situation.program))
        step = situation.program[place]
        spoilt = (
            replace(step, object=description)
            if self._rng.random() < 0.5
            else replace(step, reference=description)
        )
        return self._program(_replaced(situation.program, place, spoilt))

    def _change(self, commands: list[Command], fields: dict[str, str]) -> list[Command]:
        """One of the commands with other words for these fields."""
        place = self._any(len(commands))
        changed = replace(commands[place], fields={**commands[place].fields, **fields})
        return [*commands[:place], changed, *commands[place + 1 :]]

    def _cut_off(self, commands: Sequence[Command]) -> list[str]:
        """What is left of a sentence that ends before its last object is told apart."""
        before, last = self._joined(commands[:-1]), commands[-1]
        words = last.words()
        values = [i for i, word in enumerate(words) if word in self._domain.lexicon()]
        # The second description begins where concept words come again after others.
        again = next(b for a, b in pairwise(values) if b > a + 1)
        joining = last.connective.split()
        # A connective says that more was to come, a comma or nothing does not.
        least = len(joining) + (not joining or joining[-1] == ",")
        return before + words[: int(self._rng.integers(least, again + 1))]

    def _description(
        self, situation: Situation, wanted: Callable[[list[int]], bool]
    ) -> tuple[str, ...] | None:
        """One of the descriptions that fit the blocks wanted."""
        attributes = self._domain.attributes
        for _ in range(MAX_DRAWS):
            size = 1 + self._any(min(2, len(attributes)))
            types = self._rng.permutation(len(attributes))[:size]
            description = tuple(
                attributes[kind].values[self._any(len(attributes[kind].values))].name
                for kind in sorted(types)
            )
            if wanted(situation.fitting(description)):
                return description
        return None

    def _misspell(self, word: str) -> str:
        place = self._any(len(word))
        letter = "abcdefghijklmnopqrstuvwxyz"[self._any(26)]
        match self._any(4):
            case 0:
                return word[:place] + word[place + 1 :]
            case 1:
                return word[:place] + letter + word[place:]
            case 2:
                return word[:place] + letter + word[place + 1 :]
        return word[:place] + word[place : place + 2][::-1] + word[place + 2 :]

    def _unread(self, words: Sequence[str]) -> Spoilt | None:
        """None where the words say a command after all."""
        spoilt = self._said(words)
        return None if self._reads(spoilt.sentence) else spoilt

    def _said(self, words: Sequence[str]) -> Spoilt:
        return Spoilt(self._grammar.spell(self._rng, words))

    def _unknown(self, words: Sequence[str]) -> list[str]:
        return [word for word in words if word not in self._known]

    def _place(self, words: Sequence[str], allowed: Callable[[str], bool]) -> int:
        places = [place for place, word in enumerate(words) if allowed(word)]
        return places[self._any(len(places))]

    def _choose(self, texts: Sequence[str]) -> str:
        return texts[self._any(len(texts))]

    def _any(self, count: int) -> int:
        return int(self._rng.integers(count))


def _opened(template: str) -> str:
    """The template with a place for an opening."""
    return template if "{opening}" in template else "{opening} " + template


def _replaced(program: Program, place: int, step: Step) -> Program:
    return (*program[:place], step, *program[place + 1 :])


#: How each kind is made; the order is part of what seeds it. New ones go to the end.
KINDS: dict[str, Callable[[Spoiler, Situation], Spoilt | None]] = {
    make.__name__: make
    for make in (
        Spoiler.unknown_word,
        Spoiler.misspelt,
        Spoiler.incomplete,
        Spoiler.no_action,
        Spoiler.no_reference,
        Spoiler.missing_action,
        Spoiler.negation,
        Spoiler.other_subject,
        Spoiler.absent_object,
        Spoiler.ambiguous,
        Spoiler.too_many_steps,
        Spoiler.same_object,
        Spoiler.word_salad,
        Spoiler.relation_in_description,
        Spoiler.relation_behind_description,
        Spoiler.two_relations,
        Spoiler.ordinal,
        Spoiler.order_of_time,
        Spoiler.two_values,
    )
}

#: Kinds that a domain without order words does not have.
OF_ORDER_WORDS = (Spoiler.ordinal.__name__, Spoiler.order_of_time.__name__)
