"""The types of words and templates in a domain file."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Annotated

from pydantic import AfterValidator, Field

from nsrm_harness.common.toml_file import Text
from nsrm_harness.domain.letters import lower_case

_IDENTIFIER = re.compile(r"[A-Za-z][A-Za-z0-9_]*")
# A token of a sentence in lower case: text without white space, brackets, quotation marks and
# punctuation, except for an apostrophe inside; or a punctuation mark.
_WORD = re.compile(r"""[^\s,.!?;:"'{}\[\]]+(?:'[^\s,.!?;:"'{}\[\]]+)*|[,.!?:]""")
_FIELD = re.compile(r"\{[a-z_]+\}")

Texts = tuple[str, ...]


def _identifier(text: str) -> str:
    if not _IDENTIFIER.fullmatch(text):
        raise ValueError(f"expected a name of letters, digits and _, got {text!r}")
    return text


def _phrase(text: str) -> str:
    if text and not all(map(_is_word, text.split(" "))):
        raise ValueError(_not_words(text))
    return text


def _single_word(text: str) -> str:
    if " " in text or text == "," or not text:
        raise ValueError(f"expected a single word, got {text!r}")
    return text


def _no_twice(texts: Texts) -> Texts:
    for text in texts:
        if texts.count(text) > 1:
            raise ValueError(f"duplicate {text!r}")
    return texts


def _none_empty(reason: str) -> AfterValidator:
    def check(texts: Texts) -> Texts:
        if "" in texts:
            raise ValueError(reason)
        return texts

    return AfterValidator(check)


def _template(required: Texts, optional: Texts) -> Callable[[str], str]:
    """A check that each of the `required` fields occurs once, and the `optional` ones
    at most once."""
    fields = {f"{{{field}}}" for field in (*required, *optional)}

    def check(text: str) -> str:
        words = text.split(" ")
        for field in required:
            if words.count(f"{{{field}}}") != 1:
                raise ValueError(f"{{{field}}} must occur once in {text!r}")
        for word in words:
            if not (word in fields and words.count(word) == 1) and not _is_word(word):
                raise ValueError(f"{_not_words(text)}, or fields {sorted(fields)}")
        return text

    return check


def _command(template: str) -> str:
    fields = [word for word in template.split() if word != "{opening}"]
    if abs(fields.index("{moved}") - fields.index("{reference}")) == 1:
        raise ValueError(f"no word between the two objects in {template!r}")
    if fields[0] in ("{moved}", "{reference}"):
        raise ValueError(f"a command cannot begin with an object: {template!r}")
    return template


def _alternative(text: str) -> str:
    for word in text.split(" ") if text else ():
        if not _FIELD.fullmatch(word) and not _is_word(word):
            raise ValueError(f"{_not_words(text)}, or {{rules}}")
    return text


def _is_word(word: str) -> bool:
    return bool(_WORD.fullmatch(word)) and lower_case(word) == word


def _not_words(text: str) -> str:
    return (
        f"expected lower-case words or punctuation marks with single spaces between, got {text!r}"
    )


_ONE_OR_MORE = Field(min_length=1)
_EACH_ONCE = AfterValidator(_no_twice)

Identifier = Annotated[Text, AfterValidator(_identifier)]
"""A name of letters, digits and underscores."""
Phrase = Annotated[Text, AfterValidator(_phrase)]
"""Lower-case words with single spaces between; may be empty."""
Phrases = Annotated[tuple[Phrase, ...], _ONE_OR_MORE, _EACH_ONCE]
"""One or more different phrases; one of them may be empty."""
Relations = Annotated[Phrases, _none_empty("an action needs a phrase: remove the empty string")]
"""The phrases of an action."""
Words = Annotated[Phrases, _none_empty("an empty word would join two descriptions: remove it")]
"""Verbs or nouns."""
ConceptWords = Annotated[
    tuple[Annotated[Phrase, AfterValidator(_single_word)], ...], _ONE_OR_MORE, _EACH_ONCE
]
"""Single words that name a concept."""
Descriptions = Annotated[
    tuple[Annotated[Text, AfterValidator(_template(("values",), ("noun",)))], ...],
    _ONE_OR_MORE,
    _EACH_ONCE,
]
"""Templates with ``{values}`` and optionally ``{noun}``."""
Commands = Annotated[
    tuple[
        Annotated[
            Text,
            AfterValidator(_template(("verb", "moved", "relation", "reference"), ("opening",))),
            AfterValidator(_command),
        ],
        ...,
    ],
    _ONE_OR_MORE,
    _EACH_ONCE,
]
"""Templates with ``{verb}``, ``{moved}``, ``{relation}``, ``{reference}``, each once."""
Alternatives = Annotated[tuple[Annotated[Text, AfterValidator(_alternative)], ...], _ONE_OR_MORE]
"""One or more texts of words and ``{rules}``, some of them perhaps more than once."""
