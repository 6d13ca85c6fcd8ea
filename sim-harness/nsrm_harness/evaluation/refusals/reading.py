"""Checks whether words still form a command, by parsing with the domain's grammar.

Articles, nouns, openings and commas are ignored everywhere, and any run of concept words is a
description. So it accepts more than the grammar generates, for example "on white now set the red";
what it rejects has lost the word order of a command. In a domain with everyday wording, so are
the commands of that, and what the core reads in other words.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence

from nsrm_harness.domain import Domain
from nsrm_harness.domain.recogniser import Recogniser, means_rewritten
from nsrm_harness.domain.tokens import Tokenizer, UnknownWordError, split


class Reading:
    """Parses sentences about one domain."""

    def __init__(self, domain: Domain) -> None:
        grammar = domain.grammar
        self._domain = domain
        self._tokenizer = Tokenizer(domain)
        self._everyday = Recogniser.of(domain) if domain.everyday is not None else None
        self._left_aside = {
            ",",
            *(
                word
                for text in (*grammar.nouns, *grammar.openings, *grammar.descriptions)
                for word in text.split()
                if not word.startswith("{")
            ),
        }
        phrases = [phrase for action in domain.actions for phrase in action.phrases]
        description = f"(?:(?:{_any(domain.lexicon())}) )+"
        fields = {
            "{opening}": "",
            "{verb}": f"(?:{self._phrases(grammar.verbs)})",
            "{moved}": description,
            "{reference}": description,
            "{relation}": f"(?:{self._phrases(phrases)})",
        }
        commands = "|".join(
            "".join(
                fields[word] if word in fields else re.escape(self._bones([word]))
                for word in template.split()
            )
            for template in grammar.commands
        )
        connective = f"(?:{self._phrases(grammar.connectives)})?"
        self._program = re.compile(f"(?:{commands})(?:{connective}(?:{commands}))*")

    def __call__(self, sentence: str) -> bool:
        """Whether the sentence has the word order of a program, or is read in other words or
        fewer."""
        if means_rewritten(self._domain, sentence):
            return True
        if self._program.fullmatch(self._bones(split(sentence))) is not None:
            return True
        if self._everyday is None:
            return False
        try:
            words = self._tokenizer(sentence).words
        except UnknownWordError:
            return False
        return self._everyday.command(words)

    def _bones(self, words: Sequence[str]) -> str:
        return "".join(f"{word} " for word in words if word not in self._left_aside)

    def _phrases(self, phrases: Iterable[str]) -> str:
        """A pattern for any of these, longest first; each ends with a blank."""
        bones = {self._bones(phrase.split()) for phrase in phrases} - {""}
        return _any(sorted(bones, key=len, reverse=True)) or "(?!)"


def _any(texts: Iterable[str]) -> str:
    return "|".join(re.escape(text) for text in texts)
