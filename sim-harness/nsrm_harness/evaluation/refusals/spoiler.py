"""Spoils good sentences: each kind of fault is a method of `Spoiler`.

For kinds that the trainer generates, too, only patterns that are kept from training are used
(`domain.patterns`).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np
from nsrm import MAX_STEPS

from nsrm_harness.domain import Domain
from nsrm_harness.domain.grammar import Command, Grammar
from nsrm_harness.domain.patterns import is_reserved
from nsrm_harness.domain.program import Program, Step
from nsrm_harness.domain.recogniser import means_compound
from nsrm_harness.domain.spelling import one_edit
from nsrm_harness.domain.tokens import Tokenizer
from nsrm_harness.evaluation.refusals import topics
from nsrm_harness.evaluation.refusals.reading import Reading

#: Number of draws of a description before giving up.
MAX_DRAWS = 100
#: Numbers of steps of a sentence with too many.
TOO_MANY_STEPS = (MAX_STEPS + 1, MAX_STEPS + 4)
#: Share of missing actions in words that the domain knows, if possible.
FAMILIAR = 0.4
#: Words that join two relations or two values.
JOINTS = ("and", ",", "")
#: The fields of a command that describe objects.
ARGUMENTS = ("moved", "reference")
#: Shorter words are not misspelt.
LEAST_LETTERS = 3


@dataclass(frozen=True)
class Situation:
    """A scene, the program of a good sentence, and the ground truth of the blocks."""

    #: Number of the episode in its file.
    scene: int
    #: Value of each attribute type, for each block.
    attributes: tuple[dict[str, str], ...]
    program: Program

    def fitting(self, description: Sequence[str]) -> list[int]:
        """The blocks that a description fits, by index."""
        values = set(description)
        return [number for number, own in enumerate(self.attributes) if values <= set(own.values())]


@dataclass(frozen=True)
class Spoilt:
    """A spoilt sentence, and the word that was misspelt, if any."""

    sentence: str
    meant: str | None = None


class Spoiler:
    """Spoils good sentences. Each method is a kind; it returns None if impossible in the scene."""

    def __init__(self, domain: Domain, rng: np.random.Generator) -> None:
        self._domain = domain
        self._rng = rng
        self._grammar = Grammar(domain)
        self._reads = Reading(domain)
        self._tokenizer = Tokenizer(domain)
        grammar = domain.grammar
        self._known = {*domain.lexicon(), *domain.vocabulary()}
        # Words that must not be taken for misspelt ones.
        self._other_words = {*domain.spelling.other_words} if domain.spelling else set()
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
        # Number of actions whose phrases contain each word.
        self._relation_words = Counter(
            word
            for action in domain.actions
            for word in {word for phrase in action.phrases for word in phrase.split()}
        )
        relations = [
            phrase
            for phrase in topics.RELATIONS
            if phrase not in phrases and not means_compound(domain, phrase)
        ]
        self._familiar = [p for p in relations if self._known.issuperset(p.split())]
        self._unfamiliar = [p for p in relations if p not in self._familiar]
        if topics.BETWEEN not in phrases:
            self._unfamiliar.append(topics.BETWEEN)

    @cached_property
    def _subjects(self) -> list[str]:
        return [each for each in topics.other_subjects() if not self._reads(each)]

    def unknown_word(self, situation: Situation) -> Spoilt | None:
        """A known word is replaced by an unknown one."""
        words = self._words(situation)
        place = self._place(words, lambda word: word in self._strange)
        words[place] = self._choose(self._strange[words[place]])
        return self._said(words)

    def misspelt(self, situation: Situation) -> Spoilt | None:
        """One letter is omitted, added, changed or swapped with its neighbour; in a domain that
        reads misspelt words as its own, so that another word of the dictionary comes of it."""
        words = self._words(situation)
        place = self._place(
            words, lambda word: word in self._content and len(word) >= LEAST_LETTERS
        )
        meant = words[place]
        if self._other_words:
            near = sorted(one_edit(meant) & self._other_words)
            if not near:
                return None
            words[place] = self._choose(near)
        else:
            words[place] = self._misspell(meant)
        if words[place] in self._known:
            return None
        return Spoilt(self._grammar.spell(self._rng, words), meant)

    def incomplete(self, situation: Situation) -> Spoilt | None:
        """The sentence is cut before the last step's second object, or one object is missing."""
        commands = self._commands(situation)
        if self._rng.random() < 0.5:
            return self._unread(self._cut_off(commands))
        dropped = self._choose(("moved", "reference"))
        return self._unread(self._joined(self._change(commands, {dropped: ""})))

    def no_action(self, situation: Situation) -> Spoilt | None:
        """The words of the action are missing."""
        commands = self._change(self._commands(situation), {"relation": ""})
        return self._unread(self._joined(commands))

    def no_reference(self, situation: Situation) -> Spoilt | None:
        """The object is given, but not where to move it."""
        commands = self._commands(situation)
        place = self._any(len(commands))
        kept = ("{opening}", "{verb}", "{moved}")
        words = [word for word in commands[place].template.split() if word in kept]
        commands[place] = replace(commands[place], template=" ".join(words))
        return self._unread(self._joined(commands))

    def missing_action(self, situation: Situation) -> Spoilt | None:
        """A relation of none of the actions."""
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
        """A negated command."""
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
        """A sentence about another subject."""
        fixed = self._rng.random() < 0.6
        few = self._subjects[: len(topics.SENTENCES)] if fixed else self._subjects
        return Spoilt(self._choose(few))

    def absent_object(self, situation: Situation) -> Spoilt | None:
        """A description that fits no block of the scene."""
        description = self._description(situation, lambda fitting: not fitting)
        return None if description is None else self._with(situation, description)

    def ambiguous(self, situation: Situation) -> Spoilt | None:
        """A description that fits several blocks, not counting the other object of its step."""
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
        """More steps than a program can hold, each of them good."""
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
        """A block relative to itself, by one description or by two of it."""
        place = self._any(len(situation.program))
        step = situation.program[place]
        meant = situation.fitting(step.object)
        other = self._description(situation, lambda fitting: fitting == meant)
        if other is None or len(meant) != 1:
            return None
        spoilt = replace(step, reference=other)
        return self._program(_replaced(situation.program, place, spoilt))

    def relation_in_description(self, situation: Situation) -> Spoilt | None:
        """An object described only by where it is: "the block left of the red block". A good
        sentence with one relation too many."""
        return self._described_by_relation(situation, described=False)

    def relation_behind_description(self, situation: Situation) -> Spoilt | None:
        """An object described by its look and by where it is: "the green block left of the red
        block"."""
        return self._described_by_relation(situation, described=True)

    def two_relations(self, situation: Situation) -> Spoilt | None:
        """Two relations at once: "above and to the left of", "to the top left of"."""
        commands = self._commands(situation)
        place = self._any(len(commands))
        own, action = commands[place].fields["relation"], situation.program[place].action
        other = self._relation(without=action)
        words = own.split()
        if set(words) <= set(other.split()):
            # Not "on on the right of".
            return None
        if self._rng.random() < 0.5:
            # Another complete relation before or after it.
            joined = [own, self._choose(self._joints), other]
            relation = joined if self._rng.random() < 0.5 else joined[::-1]
        else:
            # A word that only the other action has, somewhere inside this relation.
            foreign = [word for word in other.split() if self._relation_words[word] == 1]
            if not foreign:
                return None
            at = self._any(len(words) + 1)
            relation = [*words[:at], self._choose(foreign), *words[at:]]
        fields = {**commands[place].fields, "relation": " ".join(" ".join(relation).split())}
        commands[place] = replace(commands[place], fields=fields)
        # "On" and "left of" would be "on the left of" without an article.
        return self._misused(commands, place) and self._unread(self._joined(commands))

    def ordinal(self, situation: Situation) -> Spoilt | None:
        """An ordinal: "the first red block"."""
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
        """A later command that must be executed before an earlier one."""
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
        """The words of a good sentence in a meaningless order."""
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
        """A phrase of one of the actions."""
        actions = [action for action in self._domain.actions if action.name != without]
        return self._choose(actions[self._any(len(actions))].phrases)

    def _order_word(self) -> str:
        return self._choose(self._domain.grammar.order_words)

    def _misused(self, commands: Sequence[Command], place: int) -> Spoilt | None:
        """The sentence; None if the step may be in training."""
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
        """The commands with other words for these fields in one of them."""
        place = self._any(len(commands))
        changed = replace(commands[place], fields={**commands[place].fields, **fields})
        return [*commands[:place], changed, *commands[place + 1 :]]

    def _cut_off(self, commands: Sequence[Command]) -> list[str]:
        """The sentence cut before its last object is identified."""
        before, last = self._joined(commands[:-1]), commands[-1]
        words = last.words()
        values = [i for i, word in enumerate(words) if word in self._domain.lexicon()]
        # The second description begins at the first concept words after other words.
        again = next(b for a, b in pairwise(values) if b > a + 1)
        joining = last.connective.split()
        # A connective announces another step; a comma or nothing does not.
        least = len(joining) + (not joining or joining[-1] == ",")
        return before + words[: int(self._rng.integers(least, again + 1))]

    def _description(
        self, situation: Situation, wanted: Callable[[list[int]], bool]
    ) -> tuple[str, ...] | None:
        """One of the descriptions that fit the requested blocks."""
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
        """The sentence; None if the words form a command after all."""
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
    """The template with a field for an opening."""
    return template if "{opening}" in template else "{opening} " + template


def _replaced(program: Program, place: int, step: Step) -> Program:
    return (*program[:place], step, *program[place + 1 :])


#: The method of each kind. The order affects the seeds: append new kinds.
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

#: Kinds that need a domain with order words.
OF_ORDER_WORDS = (Spoiler.ordinal.__name__, Spoiler.order_of_time.__name__)
#: Kinds that mean something in a domain whose descriptions have relations.
OF_PLAIN_DESCRIPTIONS = (
    Spoiler.relation_in_description.__name__,
    Spoiler.relation_behind_description.__name__,
)
