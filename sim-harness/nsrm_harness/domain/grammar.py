"""Generates sentences from programs, in the words of the domain file's ``[grammar]``.

A sentence has one command per step, joined by connectives. Both orders of the arguments occur ("on
the blue block put the red block"), so that their order does not show which of the two is moved.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from nsrm_harness.common.errors import DomainError
from nsrm_harness.domain import Domain
from nsrm_harness.domain.letters import upper_case
from nsrm_harness.domain.program import Program, Step


@dataclass(frozen=True)
class Style:
    """How sentences are spelt; probabilities in 0..1. The rest is lower case. A letter whose upper
    case does not read back is always in lower case."""

    #: First letter in upper case.
    capital: float = 0.4
    #: All letters in upper case.
    shouted: float = 0.04
    #: Each letter in either case.
    mixed: float = 0.02
    #: A full stop at the end.
    full_stop: float = 0.4


@dataclass(frozen=True)
class Sentence:
    """A program in words."""

    text: str
    #: Where the words of each step end, in characters.
    ends: tuple[int, ...]


@dataclass(frozen=True)
class Command:
    """One step in words, with its parts still separate."""

    #: The connective before it; empty for the first command.
    connective: str
    #: One of the grammar's ``commands``.
    template: str
    #: Words for each field of the template.
    fields: Mapping[str, str]

    def words(self) -> list[str]:
        """The words in order."""
        return [*self.connective.split(), *_fill(self.template, self.fields)]


class Grammar:
    """Generates sentences about one domain.

    With these options, sentences use only wordings that are held out from training:

    * `held_out`: for the word order
    * `held_out_phrases`: for the relations, too
    """

    def __init__(
        self,
        domain: Domain,
        style: Style | None = None,
        held_out: bool = False,
        held_out_phrases: bool = False,
    ) -> None:
        self._domain = domain
        self._words = domain.grammar
        self._style = style or Style()
        self._commands = domain.grammar.commands
        self._phrases = {action.name: action.phrases for action in domain.actions}
        if held_out or held_out_phrases:
            if domain.held_out is None:
                raise DomainError(f"the domain {domain.name!r} has no [held_out] wordings")
            self._commands = domain.held_out.commands
            if held_out_phrases:
                self._phrases = domain.held_out.phrases

    def sentence(self, rng: np.random.Generator, program: Program) -> Sentence:
        """A random wording of `program`."""
        words: list[str] = []
        ends: list[int] = []
        for command in self.commands(rng, program):
            words += command.words()
            ends.append(len(_joined(words)))
        return Sentence(self.spell(rng, words), tuple(ends))

    def commands(self, rng: np.random.Generator, program: Program) -> list[Command]:
        """A random wording of each step of `program`."""
        return [
            self._command(rng, step, _choose(rng, self._words.connectives) if index > 0 else None)
            for index, step in enumerate(program)
        ]

    def plain(self, program: Program) -> str:
        """The plainest wording of `program`: the first one of each list, in lower case, "small
        green" rather than "green small"."""
        commands = [
            " ".join(
                _fill(
                    self._words.commands[0],
                    {
                        "opening": "",
                        "verb": self._words.verbs[0],
                        "moved": self._plain_description(step.object),
                        "relation": self._domain.action(step.action).phrases[0],
                        "reference": self._plain_description(step.reference),
                    },
                )
            )
            for step in program
        ]
        return f" {self._words.connectives[0]} ".join(commands)

    def _plain_description(self, concepts: Sequence[str]) -> str:
        spoken = reversed([self._domain.concept(name).words[0] for name in concepts])
        fields = {"values": " ".join(spoken), "noun": self._words.nouns[0]}
        return " ".join(_fill(self._words.descriptions[0], fields))

    def _command(self, rng: np.random.Generator, step: Step, connective: str | None) -> Command:
        return Command(
            connective or "",
            _choose(rng, self._commands),
            {
                "opening": _choose(rng, self._words.openings) if connective is None else "",
                "verb": _choose(rng, self._words.verbs),
                "moved": self.description(rng, step.object),
                "relation": _choose(rng, self._phrases[step.action]),
                "reference": self.description(rng, step.reference),
            },
        )

    def description(self, rng: np.random.Generator, concepts: Sequence[str]) -> str:
        """A random description of an object by these attribute values."""
        values = [_choose(rng, self._domain.concept(name).words) for name in concepts]
        filled = _fill(
            _choose(rng, self._words.descriptions),
            {
                "values": " ".join(values[index] for index in rng.permutation(len(values))),
                "noun": _choose(rng, self._words.nouns),
            },
        )
        return " ".join(filled)

    def spell(self, rng: np.random.Generator, words: Sequence[str]) -> str:
        """The words as a sentence, in a random spelling of the grammar's style."""
        text = _joined(words)
        draw = rng.random()
        style = self._style
        if draw < style.capital:
            text = upper_case(text[0]) + text[1:]
        elif draw < style.capital + style.shouted:
            text = upper_case(text)
        elif draw < style.capital + style.shouted + style.mixed:
            upper = rng.random(len(text)) < 0.5
            text = "".join(
                upper_case(letter) if up else letter for letter, up in zip(text, upper, strict=True)
            )
        return text + "." if rng.random() < style.full_stop else text


def _joined(words: Sequence[str]) -> str:
    return " ".join(words).replace(" ,", ",")


def _fill(template: str, fields: Mapping[str, str]) -> list[str]:
    """The template's words, with each field replaced by its words."""
    words: list[str] = []
    for word in template.split():
        is_field = word.startswith("{") and word.endswith("}")
        words += fields[word[1:-1]].split() if is_field else [word]
    return words


def _choose(rng: np.random.Generator, texts: Sequence[str]) -> str:
    return texts[int(rng.integers(len(texts)))]
