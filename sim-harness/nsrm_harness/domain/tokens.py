"""Splits a sentence into tokens: the reference for the trainer and the core.

1. The sentence is split at white space and quotation marks (``" “ ” „``) and read in lower case,
   letter by letter: see `letters`. The apostrophe ``’`` is read as ``'``.
2. ``,`` and ``;`` become the token ``,`` everywhere.
3. ``. ! ?`` at the very end of the sentence are dropped. Elsewhere, each of ``. ! ? : '`` at the
   start or end of a word is a separate token.
4. Adjacent words that name attribute values, the paper's only lexicon, or extremes ("leftmost"), or
  say that several objects are meant ("all"), form a group, which one group token replaces
  (section IV-B).
5. Behind "all", "of" and "the" are dropped up to the values, and a plural becomes its singular,
   unless another group stands before it. Where none of these follows, an "all" that is in
   the vocabulary is any other word.
6. Every other token must be in the vocabulary.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from nsrm_harness.common.errors import HarnessError
from nsrm_harness.domain import GROUP_TOKEN, Domain
from nsrm_harness.domain.letters import SPACE, lower_case

_BETWEEN = rf"(?:[,;]|{SPACE})"
_PIECES = re.compile(rf"""[,;]|[.!?:']+(?={_BETWEEN}|\Z)|(?:(?<={_BETWEEN})|^)[.!?:']+""")
_QUOTES = str.maketrans(dict.fromkeys('"“”„', " ") | {"’": "'"})
_END = re.compile(rf"(?:[.!?]|{SPACE})+\Z")
_SPACES = re.compile(rf"{SPACE}+")


class UnknownWordError(HarnessError):
    """A word that is neither in the lexicon nor in the vocabulary."""

    def __init__(self, word: str, sentence: str) -> None:
        super().__init__(f"unknown word {word!r} in {sentence!r}")
        self.word = word


@dataclass(frozen=True)
class Tokens:
    """A sentence in the form that the networks get."""

    #: Words of the vocabulary, with the group token for each group.
    words: tuple[str, ...]
    #: Indices of the concepts of each group, in the order spoken.
    groups: tuple[tuple[int, ...], ...]


class Tokenizer:
    """Splits sentences about one domain into tokens."""

    def __init__(self, domain: Domain) -> None:
        self._lexicon, self._group_words = domain.lexicon(), domain.group_words()
        self.attributes = len(domain.attributes)
        self._quantifiers = {word for each in domain.quantifier_words().values() for word in each}
        several = domain.several
        self._between = () if several is None else several.between
        self._singular = {} if several is None else several.plurals
        #: Row of each word in the embeddings; the group token has row 0.
        self.row = {word: row for row, word in enumerate(domain.vocabulary())}

    def __call__(self, sentence: str) -> Tokens:
        """The tokens of `sentence`. Raises ``UnknownWordError``."""
        words: list[str] = []
        groups: list[tuple[int, ...]] = []
        in_group = is_quantified = False
        for piece, behind in pairwise([*split(sentence), ""]):
            is_value = piece in self._group_words
            if piece in self._quantifiers and piece in self.row:
                # "All right", unlike "all the red blocks".
                is_value = self._goes_on_with_several(behind)
            if not is_value:
                if in_group and is_quantified and not groups[-1] and piece in self._between:
                    continue
                if is_quantified:
                    piece = self._singular.get(piece, piece)
                if piece == GROUP_TOKEN or piece not in self.row:
                    raise UnknownWordError(piece, sentence)
                words.append(piece)
            else:
                if not in_group:
                    words.append(GROUP_TOKEN)
                    groups.append(())
                    is_quantified = False
                is_quantified |= piece in self._quantifiers
                if (concept := self._lexicon.get(piece)) is not None:
                    groups[-1] = (*groups[-1], concept)
            in_group = is_value
        return Tokens(tuple(words), tuple(groups))

    def _goes_on_with_several(self, piece: str) -> bool:
        return piece in self._group_words or piece in self._between or piece in self._singular

    def pattern(self, words: Sequence[str]) -> list[int]:
        """Row of each token of a sentence in these words."""
        return self.rows(self(" ".join(words)))

    def rows(self, tokens: Tokens) -> list[int]:
        """Row of each token in the embeddings."""
        return [self.row[word] for word in tokens.words]


def split(sentence: str) -> list[str]:
    """Rules 1 to 3: lower-case words and punctuation, before any lookup."""
    text = _END.sub("", lower_case(sentence.translate(_QUOTES)))
    spaced = _PIECES.sub(lambda match: f" {' '.join(match.group())} ", text)
    return ["," if piece == ";" else piece for piece in _SPACES.split(spaced) if piece]
