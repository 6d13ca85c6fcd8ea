"""Converts sentences for the baseline: split into steps, with every word as a token."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from nsrm_harness.data.ground_truth import GroundTruth
from nsrm_harness.domain import Domain
from nsrm_harness.domain.tokens import UnknownWordError, split
from nsrm_harness.learning.dataset import roomy


def vocabulary(domain: Domain) -> tuple[str, ...]:
    """All words of the domain, including the lexicon, without the group token."""
    return (*domain.vocabulary()[1:], *domain.lexicon())


@dataclass(frozen=True)
class StepWords:
    """The words of N commands, with at most S steps and T words in each."""

    tokens: np.ndarray
    """Rows of the embeddings, int32 `[N, S, T]`, right-padded with row 0; T is `roomy`."""
    length: np.ndarray
    """Number of words of each step, int32 `[N, S]`; 0 for missing steps."""
    count: np.ndarray
    """Number of steps, int32 `[N]`."""

    @classmethod
    def of(
        cls, words: Sequence[str], sentences: Sequence[str], ends: Sequence[Sequence[int]]
    ) -> StepWords:
        """Splits each sentence at its `ends`, in characters; `words` in the embeddings' order."""
        row = {word: index for index, word in enumerate(words)}
        cut = [
            [_rows(row, part) for part in parts(sentence, at)]
            for sentence, at in zip(sentences, ends, strict=True)
        ]
        count = np.array([len(steps) for steps in cut], np.int32)
        longest = roomy(max((len(step) for steps in cut for step in steps), default=1))
        tokens = np.zeros((len(cut), max(count, default=1), longest), np.int32)
        length = np.zeros(tokens.shape[:2], np.int32)
        for index, steps in enumerate(cut):
            for number, step in enumerate(steps):
                tokens[index, number, : len(step)] = step
                length[index, number] = len(step)
        return cls(tokens, length, count)


def parts(sentence: str, ends: Sequence[int]) -> list[str]:
    """A sentence split at `ends`; connectives belong to the later step."""
    return [sentence[start:end] for start, end in zip([0, *ends[:-1]], ends, strict=True)]


def read_ends(path: Path) -> list[list[int]]:
    """The ends of the steps of all sentences in an episode file, the only ground
    truth that is read."""
    with GroundTruth(path) as judge:
        return [[step.end for step in judge.truth(index).steps] for index in range(len(judge))]


def _rows(row: dict[str, int], part: str) -> list[int]:
    pieces = split(part)
    for piece in pieces:
        if piece not in row:
            raise UnknownWordError(piece, part)
    return [row[piece] for piece in pieces]
