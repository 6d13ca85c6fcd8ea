"""Reading a table of the domain file: each getter checks type and range and says
file and key when something is wrong."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from nsrm_harness.common.errors import DomainError
from nsrm_harness.domain.letters import lower_case

_IDENTIFIER = re.compile(r"[A-Za-z][A-Za-z0-9_]*")
# A token of a sentence, of letters in lower case: text without white space and the
# punctuation that the tokenizer takes off; or the comma.
_WORD = re.compile(r"""[^\s,.!?;:"'{}\[\]]+|,""")


class Table:
    """A table of the document; remembers which keys were asked for."""

    def __init__(self, content: Mapping[str, Any], source: str, where: str) -> None:
        self._content = content
        self._source = source
        self._where = where
        self._asked: set[str] = set()

    def error(self, key: str, problem: str) -> DomainError:
        """The error to raise: file, key and what is wrong."""
        where = f"{self._where}.{key}" if self._where else key
        return DomainError(f"{self._source}: {where}: {problem}")

    def no_other_keys(self) -> None:
        """Refuse keys that nobody asked for; most are misspelt."""
        for key in self._content:
            if key not in self._asked:
                expected = ", ".join(sorted(self._asked))
                raise self.error(key, f"unknown key; expected some of: {expected}")

    def table(self, key: str) -> Table:
        """A table within this one."""
        value = self._required(key)
        if not isinstance(value, Mapping):
            raise self.error(key, f"expected a table, got {value!r}")
        return Table(value, self._source, f"{self._where}.{key}" if self._where else key)

    def tables(self, key: str, least: int = 1) -> list[Table]:
        """A list of at least `least` tables."""
        value = self._required(key)
        if (
            not isinstance(value, list)
            or len(value) < least
            or not all(isinstance(item, Mapping) for item in value)
        ):
            raise self.error(key, f"expected {least} or more tables")
        where = f"{self._where}.{key}" if self._where else key
        return [Table(item, self._source, f"{where}[{index}]") for index, item in enumerate(value)]

    def identifier(self, key: str) -> str:
        """A name of letters, digits and underscores."""
        value = self._required(key)
        if not isinstance(value, str) or not _IDENTIFIER.fullmatch(value):
            raise self.error(key, f"expected a name of letters, digits and _, got {value!r}")
        return value

    def choice(self, key: str, choices: tuple[str, ...]) -> str:
        """One of `choices`."""
        value = self._required(key)
        if value not in choices:
            raise self.error(key, f"expected one of {', '.join(choices)}, got {value!r}")
        return value

    def numbers(self, key: str, length: int, least: float, most: float) -> tuple[float, ...] | None:
        """`length` numbers from `least` to `most`, or None where the key is absent."""
        value = self._optional(key)
        if value is None:
            return None
        if (
            not isinstance(value, list)
            or len(value) != length
            or not all(
                isinstance(item, int | float)
                and not isinstance(item, bool)
                and least <= item <= most
                for item in value
            )
        ):
            raise self.error(key, f"expected {length} numbers in {least}..{most}, got {value!r}")
        return tuple(float(item) for item in value)

    def integers(self, key: str, length: int, least: int, most: int) -> tuple[int, ...] | None:
        """`length` whole numbers from `least` to `most`, or None where the key is absent."""
        value = self._optional(key)
        if value is None:
            return None
        if (
            not isinstance(value, list)
            or len(value) != length
            or not all(
                isinstance(item, int) and not isinstance(item, bool) and least <= item <= most
                for item in value
            )
        ):
            raise self.error(
                key, f"expected {length} whole numbers in {least}..{most}, got {value!r}"
            )
        return tuple(value)

    def phrases(self, key: str) -> tuple[str, ...]:
        """A list of phrases of lower-case words with one space between; "" may stand in it."""
        value = self._texts(key)
        for text in value:
            for word in text.split(" ") if text else ():
                if not _is_word(word):
                    raise self.error(key, _not_words(text))
        return value

    def optional_phrases(self, key: str) -> tuple[str, ...]:
        """As :meth:`phrases`; empty where the key is absent."""
        return () if self._optional(key) is None else self.phrases(key)

    def templates(
        self, key: str, required: tuple[str, ...], optional: tuple[str, ...]
    ) -> tuple[str, ...]:
        """Phrases with each of the `required` fields once and the `optional` at most once."""
        value = self._texts(key)
        for text in value:
            words = text.split(" ")
            for field in required:
                if words.count(f"{{{field}}}") != 1:
                    raise self.error(key, f"{{{field}}} must stand once in {text!r}")
            fields = {f"{{{field}}}" for field in (*required, *optional)}
            for word in words:
                if word in fields and words.count(word) == 1:
                    continue
                if not _is_word(word):
                    raise self.error(key, f"{_not_words(text)}, or fields {sorted(fields)}")
        return value

    def _texts(self, key: str) -> tuple[str, ...]:
        value = self._required(key)
        if (
            not isinstance(value, list)
            or not value
            or not all(isinstance(item, str) for item in value)
        ):
            raise self.error(key, f"expected a list of one or more strings, got {value!r}")
        for text in value:
            if value.count(text) > 1:
                raise self.error(key, f"{text!r} is given twice")
        return tuple(value)

    def _optional(self, key: str) -> Any:
        self._asked.add(key)
        return self._content.get(key)

    def _required(self, key: str) -> Any:
        value = self._optional(key)
        if value is None:
            raise self.error(key, "is missing")
        return value


def _is_word(word: str) -> bool:
    return bool(_WORD.fullmatch(word)) and lower_case(word) == word


def _not_words(text: str) -> str:
    return f"expected lower-case words or commas with single spaces between, got {text!r}"
