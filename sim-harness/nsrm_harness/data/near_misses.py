"""Near misses: sentences of known words that mean no program, made from everyday wording.

After such a sentence a demonstrator does nothing. A near miss is a command with a few words changed
(`_changed`), a sentence with the parts of commands in the wrong places (`_rearranged`), two
commands in an order of time that no program has, or a command that no demonstrator carries out.
Nothing else that the recogniser takes for a command is a near miss.

Each has the descriptions of one step, from two to `MOST_GROUPS`, or four if it is about the order
of time: with another number, the core refuses it anyway.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TypeVar

import numpy as np

from nsrm_harness.data.near_miss_texts import (
    AUXILIARIES,
    COMPARED_TEXTS,
    INSERTED,
    JOINED_TEXTS,
    JOINTS,
    PARTS,
    REFERRING_TEXTS,
    SUBJECTS,
)
from nsrm_harness.data.plain_wording import plain_words
from nsrm_harness.domain import GROUP_TOKEN, Domain
from nsrm_harness.domain.everyday import Speaker, everyday_of, filled_in
from nsrm_harness.domain.grammar import Command, Grammar
from nsrm_harness.domain.program import SUPERLATIVES, Relation, Step
from nsrm_harness.domain.reader import MAX_STEPS
from nsrm_harness.domain.recogniser import Recogniser, means_rewritten, with_values_joined
from nsrm_harness.domain.tokens import Tokenizer

#: Share that is made from plain commands, in the grammar that a model is first trained on.
PLAIN = 0.35
#: Share of near misses about the order of time.
UNTIMELY = 0.1
#: Share of those about what is never shown, if there is anything.
UNSHOWN = 0.03
#: Of the others, share of those that are rearranged, of those with a relation in a description or a
#: pronoun that stands for no object, and of those with a relation that is none.
REARRANGED, REFERRING, RELATED = 0.1, 0.1, 0.4
#: If descriptions may have relations, share of steps with one among those that are changed, and
#: share of sentences that join more descriptions than a command has.
DESCRIBED_FURTHER, JOINED = 0.4, 0.25
#: If descriptions may have superlatives, share of sentences with a wrong one.
COMPARED = 0.15
#: If the domain has extremes, share of group tokens with one.
EXTREME = 0.15
#: Largest number of descriptions in a step that is learned from, a near miss or a command: more
#: have four times the structures, and hardly anybody says them.
MOST_GROUPS = 4
#: Of the wrong relations, share of two at once, of a few random words, of a part of one, and of
#: some of the words of one; the others have one word more, less or another.
DOUBLED, FEW, CUT, THINNED = 0.25, 0.25, 0.15, 0.1
#: Share of sentences without a relation's words among those with a few.
BARE = 0.4
#: Share of the others that have more than one change.
CHANGED_TWICE = 0.25

Item = TypeVar("Item")


@dataclass(frozen=True)
class NearMiss:
    """A sentence after which nothing is done."""

    sentence: str
    #: Whether its commands are in an order of time that no program has.
    is_untimely: bool


class NearMisses:
    """Makes near misses of one domain's everyday wording."""

    def __init__(
        self,
        domain: Domain,
        rng: np.random.Generator,
        never_shown: Sequence[tuple[str, str]] = (),
    ) -> None:
        """`never_shown`: actions, each with a relation of the reference with which nobody
        demonstrates it."""
        words = everyday_of(domain)
        self._never_shown = never_shown
        self._domain = domain
        self._rng = rng
        self._speaker = Speaker(domain, rng)
        self._grammar = Grammar(domain)
        self._tokenizer = Tokenizer(domain)
        self._recogniser = Recogniser.of(domain)
        self._states = list(words.states())
        self._vocabulary = domain.vocabulary()[1:]
        # Other words are not known.
        self._joined_texts = [
            text
            for text in JOINED_TEXTS
            if all(word in self._vocabulary for word in text.split() if word[0] != "{")
        ]
        self._inserted = [name for name in INSERTED if name in words.rules]
        self._parts = [name for name in PARTS if name in words.rules]
        self._who = [word for word in SUBJECTS if word in self._vocabulary]
        self._how = [word for word in AUXILIARIES if word in self._vocabulary]
        self._rules = words.rules
        self._relation_texts = [
            filled_in(text, relation).split()
            for relation in words.placements().values()
            for text in words.rules[relation["rule"]]
        ]
        self._plain_relations = [
            [*phrase.split(), "{reference}"]
            for action in domain.actions
            for phrase in action.phrases
        ]
        superlatives = {name: words.states()[name] for name in SUPERLATIVES if name in self._states}
        #: "nearest to", and "nearest" before a noun.
        self._compared = [
            _literal(text.split())
            for state in superlatives.values()
            for text in words.rules[state["state"]]
        ]
        self._most = [
            before
            for name in superlatives
            for text in words.own_texts(name, "undescribed")
            for before, word in pairwise(text.split())
            if word == "{noun}"
        ]
        self._extremes = [word for words in domain.extremes.values() for word in words]
        self._relations = [*map(_literal, self._relation_texts), *self._compared]
        self._order_words = domain.grammar.order_words or ("first",)
        # Half of them plain, as there are many.
        joints = ("and", "then", "and then", ",", ", and", ", then", ", and then", ".", ". then")
        self._joints = (*joints, *("{next}" for _ in joints))
        # With a comma, "…, first, put …" says that what stands before it comes first.
        self._starting = [text for text in words.rules["starting"] if "," not in text]
        self._changes: tuple[Callable[[list[str]], list[str]], ...] = (
            self._with_words_left_out,
            self._with_words_inserted,
            self._with_a_word_replaced,
            self._with_words_swapped,
            self._with_another_end,
            self._with_a_relation,
            self._with_a_part,
            self._with_words_shuffled,
            self._with_order_word,
            self._with_relation_words,
            self._with_relation_words_behind,
        )

    def sentence(self) -> str:
        """A near miss."""
        return self.draw().sentence

    def draw(self) -> NearMiss:
        """A near miss."""
        while True:
            is_untimely = self._rng.random() < UNTIMELY
            if is_untimely:
                words = self._untimely()
            elif self._never_shown and self._rng.random() < UNSHOWN:
                words = self._unshown()
            else:
                words = self._changed()
            if words is None:
                continue
            sentence = " ".join(self._described(words))
            joined = with_values_joined(self._domain, sentence)
            is_joined = joined.count(GROUP_TOKEN) < words.count(GROUP_TOKEN)
            means_apart = is_joined and self._recogniser.command(joined)
            if not (means_apart or means_rewritten(self._domain, sentence)):
                return NearMiss(sentence, is_untimely)

    def _changed(self) -> list[str] | None:
        """A step that is none; None if it is one after all, or would be refused anyway."""
        draw = self._rng.random()
        if self._compared and self._rng.random() < COMPARED:
            words = self._wrongly_compared()
        elif self._states and self._rng.random() < JOINED:
            words = self._joined()
        elif draw < REARRANGED:
            words = self._rearranged()
        elif draw < REARRANGED + REFERRING:
            words = self._referring()
        elif draw < REARRANGED + REFERRING + RELATED:
            words = self._with_no_relation()
        else:
            words = self._step()
            changes = 1 if self._rng.random() > CHANGED_TWICE else 2 + self._any(2)
            for _ in range(changes):
                words = self._choose(self._changes)(words) or self._step()
        groups = [place for place, word in enumerate(words) if word == GROUP_TOKEN]
        most = MOST_GROUPS if self._states else 2
        if not 2 <= len(groups) <= most or any(b == a + 1 for a, b in pairwise(groups)):
            return None
        return None if self._recogniser.command(words) else words

    def _unshown(self) -> list[str]:
        """A command that no demonstrator carries out: "put the red block left of the one on the
        blue block"."""
        action, relation = self._choose(self._never_shown)
        is_plain = self._rng.random() < PLAIN
        # The values mean nothing.
        values = (self._domain.concepts[0].name if is_plain else GROUP_TOKEN,)
        reference = values if self._any(2) else ()
        step = Step(action, values, reference, (), (Relation(relation, values),))
        if is_plain:
            words = plain_words(self._domain, self._grammar, self._rng, (step,))
            return list(self._tokenizer(" ".join(words)).words)
        index = self._any(2)
        return self._speaker.step(step, index, "{next}" if index else "")

    def _untimely(self) -> list[str] | None:
        """A second command that must come first: "…, first put the green block there".

        With a connective it is meaningless without the first one, too, which is left out: "and then
        first put the green block there".
        """
        if self._rng.random() < PLAIN:
            return self._plainly_untimely()
        start = self._choose((*self._order_words, "{starting}"))
        if self._rng.random() < 0.6:
            words = self._speaker.step(None, 0, f"{self._choose(self._joints)} {start}")
            return None if self._recogniser.step(words) else words
        if start not in self._order_words:
            start = self._choose(self._starting)
        second = self._speaker.step(None, 0, start)
        words = [*self._speaker.step(None, 0), *second]
        return None if self._recogniser.program(words) else words

    def _plainly_untimely(self) -> list[str] | None:
        """A plain command with an order word behind its connective, or two with nothing else in
        between."""
        later, order_word = self._plain(is_first=False), self._choose(self._order_words)
        if self._rng.random() < 0.5:
            words = self._pattern(self._plain(is_first=True), replace(later, connective=order_word))
        else:
            words = self._pattern(replace(later, connective=f"{later.connective} {order_word}"))
        return None if self._recogniser.program(words) else words

    def _plain(self, is_first: bool) -> Command:
        """A plain command, the first or a later one; its values mean nothing."""
        value = self._domain.concepts[0].name
        action = self._choose(self._domain.actions).name
        step = Step(action, (value,), (value,))
        return self._grammar.commands(self._rng, (step, step))[0 if is_first else 1]

    def _pattern(self, *commands: Command) -> list[str]:
        """The words, with a group token for the values of each description."""
        words = " ".join(word for command in commands for word in command.words())
        return list(self._tokenizer(words).words)

    def _step(self) -> list[str]:
        if self._states and self._rng.random() < DESCRIBED_FURTHER:
            index = self._any(MAX_STEPS) if self._rng.random() < 0.5 else 0
            return self._speaker.step(self._described_further(), index, "{next}" if index else "")
        if self._rng.random() < PLAIN:
            return self._pattern(self._plain(self._rng.random() < 0.5))
        if self._rng.random() < 0.5:
            lead = "{starting}" if self._rng.random() < 0.1 else ""
            return self._speaker.step(None, 0, lead)
        lead = "{listing}" if self._rng.random() < 0.1 else "{next}"
        return self._speaker.step(None, 1 + self._any(MAX_STEPS - 1), lead)

    def _rearranged(self) -> list[str]:
        """A command with its parts exchanged: "you put …", "the red block placed on …"."""
        objects = ["{moved}", "{where}"]
        if self._rng.random() < 0.25:
            objects.reverse()
        around: list[list[str]] = [[], [], []]
        for _ in range(self._any(4)):
            around[self._any(3)].append(f"{{{self._choose(self._parts)}}}")
        if self._who and self._rng.random() < 0.35:
            around[0].insert(0, self._choose(self._who))
        if self._how and self._rng.random() < 0.5:
            # "I have put …", "have I put …", "the red block is on …", "is the red block on …"
            place = around[self._any(2)]
            place.insert(self._any(len(place) + 1), self._choose(self._how))
        text = [*around[0], objects[0], *around[1], objects[1], *around[2]]
        return self._speaker.words(f"{{before}} {' '.join(text)} {{after}}")

    def _described_further(self) -> Step:
        """A step with a relation in a description, of group tokens."""
        group, related = (GROUP_TOKEN,), (Relation(self._choose(self._states), (GROUP_TOKEN,)),)
        moved, reference = ((group if self._any(2) else ()) for _ in range(2))
        action = self._choose(self._domain.actions).name
        which = self._any(5)
        if which < 2:
            return Step(action, moved, group, related)
        if which < 4:
            return Step(action, group, reference, (), related)
        other = (Relation(self._choose(self._states), group),)
        return Step(action, moved, reference, related, other)

    def _joined(self) -> list[str]:
        """Descriptions or relations that are joined: "put the red block and the blue one on …"."""
        text = self._with_relation_texts(self._choose(self._joined_texts))
        lead = "{next}" if self._any(2) else ""
        step = self._described_further() if self._any(4) == 0 else None
        return self._speaker.words(f"{lead} {{before}} {text} {{after}}", step)

    def _wrongly_compared(self) -> list[str]:
        """A superlative that compares with nothing, or is no description's: "put the nearest red
        block on the blue one", "put the red block nearest to the blue one"."""
        text = self._with_relation_texts(self._choose(COMPARED_TEXTS))
        lead = "{next}" if self._any(2) else ""
        index = self._any(MAX_STEPS)
        return self._speaker.words(f"{lead} {{before}} {text} {{after}}", index=index)

    def _with_relation_texts(self, text: str) -> str:
        """The text with words for what stands for words of relations."""
        for field, words in (
            ("{part}", lambda: self._part_of(self._choose(self._relations))),
            ("{words}", lambda: self._choose(self._relations)),
            ("{most}", lambda: [self._choose(self._most)]),
            ("{compared}", lambda: self._choose(self._compared)),
            ("{some}", lambda: self._part_of(self._choose(self._compared))),
        ):
            while field in text:
                text = text.replace(field, " ".join(words()), 1)
        return text

    def _referring(self) -> list[str]:
        """A relation in a description, "put the block that is on the red block on the blue block",
        or a pronoun that stands for no object: "take the red block and put the blue one on it"."""
        text = self._with_relation_texts(self._choose(REFERRING_TEXTS))
        lead = "{next}" if self._any(2) else ""
        return self._speaker.words(f"{lead} {{before}} {text} {{after}}")

    def _with_no_relation(self) -> list[str]:
        """A command with a relation that is none: "to the blue", "on the blue block's top"."""
        if self._rng.random() < PLAIN:
            command = self._plain(self._rng.random() < 0.5)
            relation = self._no_relation(self._choose(self._plain_relations))
            words = " ".join(word for word in relation if word != "{reference}")
            return self._pattern(replace(command, fields={**command.fields, "relation": words}))
        text, order = (self._choose(self._rules[name]) for name in ("command", "order"))
        relation = self._no_relation(self._choose(self._relation_texts))
        lead = "{next}" if self._any(2) else ""
        text = text.replace("{order}", order).replace("{where}", " ".join(relation))
        return self._speaker.words(f"{lead} {{before}} {text} {{after}}")

    def _no_relation(self, text: Sequence[str]) -> list[str]:
        """The words of a relation with two at once, only few words or one wrong word."""
        draw, relation = self._rng.random(), list(text)
        if draw < DOUBLED:
            other = self._choose(self._relations)
            return [*other, *self._choose(JOINTS).split(), *relation]
        if draw < DOUBLED + FEW:
            # "to", "at the", or none at all.
            count = 0 if self._rng.random() < BARE else 1 + self._any(3)
            some = [self._choose(self._choose(self._relations)) for _ in range(count)]
            return [*some, "{reference}"]
        if draw < DOUBLED + FEW + CUT:
            # "next to" of "next to …, on the left".
            place = next(at for at, word in enumerate(relation) if word.startswith("{"))
            return relation[self._any(place + 1) : place + 1 + self._any(len(relation) - place)]
        if draw < DOUBLED + FEW + CUT + THINNED:
            kept = self._rng.random()
            return [w for w in relation if w.startswith("{") or self._rng.random() < kept]
        places = [at for at, word in enumerate(relation) if not word.startswith("{")]
        at, change = self._choose(places), self._any(3)
        word = self._choose(self._choose(self._relations)) if self._any(2) else self._word()
        relation[at : at + (change > 0)] = [word] if change < 2 else []
        return relation

    def _with_words_left_out(self, words: list[str]) -> list[str]:
        first = self._any(len(words))
        behind = first + 1 + self._any(3)
        return [
            word
            for place, word in enumerate(words)
            if word == GROUP_TOKEN or not first <= place < behind
        ]

    def _with_words_inserted(self, words: list[str]) -> list[str]:
        return self._insert(words, [self._word() for _ in range(1 + self._any(2))])

    def _with_a_word_replaced(self, words: list[str]) -> list[str]:
        place = self._any(len(words))
        return [
            self._word() if at == place and word != GROUP_TOKEN else word
            for at, word in enumerate(words)
        ]

    def _with_words_swapped(self, words: list[str]) -> list[str]:
        place = self._any(len(words))
        return [*words[:place], *reversed(words[place : place + 2]), *words[place + 2 :]]

    def _with_another_end(self, words: list[str]) -> list[str]:
        other = self._step()
        return [*words[: self._any(len(words))], *other[self._any(len(other)) :]]

    def _with_a_relation(self, words: list[str]) -> list[str]:
        relation = self._choose(self._relations)
        if self._rng.random() < 0.5:
            first = self._any(len(relation))
            relation = relation[first : first + 1 + self._any(3)]
        return self._insert(words, relation)

    def _with_a_part(self, words: list[str]) -> list[str]:
        part = self._speaker.words(
            f"{{{self._choose(self._inserted)}}}", index=self._any(MAX_STEPS)
        )
        return self._insert(words, [word for word in part if word != GROUP_TOKEN])

    def _with_words_shuffled(self, words: list[str]) -> list[str]:
        first = self._any(len(words))
        behind = first + 2 + self._any(5)
        some = words[first:behind]
        shuffled = [some[index] for index in self._rng.permutation(len(some))]
        return [*words[:first], *shuffled, *words[behind:]]

    def _with_order_word(self, words: list[str]) -> list[str]:
        """An ordinal, "the first red block", or an order word anywhere else."""
        places = [at for at, word in enumerate(words) if word == GROUP_TOKEN or self._any(8) == 0]
        at = self._choose(places) if places else 0
        return [*words[:at], self._choose(self._order_words), *words[at:]]

    def _with_relation_words(self, words: list[str]) -> list[str]:
        return self._insert(words, self._relation_words())

    def _with_relation_words_behind(self, words: list[str]) -> list[str]:
        return [*words, *self._relation_words()]

    def _relation_words(self) -> list[str]:
        return [self._choose(self._choose(self._relations)) for _ in range(1 + self._any(2))]

    def _part_of(self, words: list[str]) -> list[str]:
        """The words without the last few or the first few: "on the right"."""
        cut = 1 + self._any(max(1, len(words) - 1))
        return words[:cut] if self._rng.random() < 0.7 else words[cut:]

    def _insert(self, words: list[str], added: Sequence[str]) -> list[str]:
        place = self._any(len(words) + 1)
        return [*words[:place], *added, *words[place:]]

    def _word(self) -> str:
        return self._choose(self._vocabulary)

    def _described(self, words: Sequence[str]) -> list[str]:
        """The words with random attribute values and extremes for the group tokens."""
        described: list[str] = []
        for word in words:
            described += self._values() if word == GROUP_TOKEN else [word]
        return described

    def _values(self) -> list[str]:
        attributes = self._domain.attributes
        kinds = self._rng.permutation(len(attributes))[: 1 + self._any(min(2, len(attributes)))]
        values = [self._choose(self._choose(attributes[kind].values).words) for kind in kinds]
        if self._extremes and self._rng.random() < EXTREME:
            values[0] = self._choose(self._extremes)
        return values

    def _choose(self, items: Sequence[Item]) -> Item:
        return items[self._any(len(items))]

    def _any(self, count: int) -> int:
        return int(self._rng.integers(count))


def _literal(words: Sequence[str]) -> list[str]:
    """The words that stand for themselves."""
    return [word for word in words if not word.startswith("{")]
