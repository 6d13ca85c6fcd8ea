"""Converts demonstrations to arrays: initial scene, sentence and final scene, and nothing else.

It reads through `data.file.Demonstrations`, which has no access to the ground truth in a file. The
number of steps of a command is not given either: it follows from the number of concept groups in
its sentence, two per step.
"""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING

import numpy as np
from tqdm import tqdm

from nsrm_harness.domain.tokens import Tokenizer, Tokens
from nsrm_harness.learning.model import GROUP_TOKEN

if TYPE_CHECKING:
    from nsrm_harness.data.file import Demonstrations
    from nsrm_harness.domain import Domain

GROUPS_PER_STEP = 2
"""The moved object and the reference."""
TOKENS = 4
"""Sentences are padded to a multiple of this many tokens."""


def roomy(length: int) -> int:
    """A number of tokens rounded up, so that similar data have the same shapes and share compiled
    code."""
    return -(-length // TOKENS) * TOKENS


def doubled(count: int) -> int:
    """The next power of two, so that similar large numbers share compiled code."""
    return 1 << (count - 1).bit_length()


@dataclass(frozen=True)
class Sentences:
    """Sentences as padded arrays; N sentences, T tokens, G groups, K concepts in a group."""

    tokens: np.ndarray
    """Rows of the embeddings, int32 `[N, T]`, right-padded with row 0."""
    length: np.ndarray
    """Number of tokens, int32 `[N]`."""
    groups: np.ndarray
    """Concepts of each group, int32 `[N, G, K]`, padded with -1."""
    group_count: np.ndarray
    """Number of groups, int32 `[N]`."""

    @classmethod
    def of(cls, tokenizer: Tokenizer, sentences: Sequence[Tokens]) -> Sentences:
        """Pads to the longest sentence, rounded up; see `roomy`."""
        count = len(sentences)
        length = np.array([len(tokens.words) for tokens in sentences], np.int32)
        group_count = np.array([len(tokens.groups) for tokens in sentences], np.int32)
        most = max((len(g) for tokens in sentences for g in tokens.groups), default=1)
        most = max(most, tokenizer.attributes)
        rows = np.zeros((count, roomy(max(length, default=1))), np.int32)
        groups = np.full((count, max(group_count, default=1), most), -1, np.int32)
        for index, tokens in enumerate(sentences):
            rows[index, : len(tokens.words)] = tokenizer.rows(tokens)
            for number, group in enumerate(tokens.groups):
                groups[index, number, : len(group)] = group
        return cls(rows, length, groups, group_count)

    def longest_step(self) -> int:
        """Largest possible number of tokens of a step, rounded up, given that each step has two
        groups."""
        most = 1
        for row, length in zip(self.tokens, self.length, strict=True):
            groups = np.flatnonzero(row[:length] == GROUP_TOKEN)
            if len(groups) <= GROUPS_PER_STEP:
                most = max(most, int(length))
            else:
                second, third = groups[GROUPS_PER_STEP - 1 : GROUPS_PER_STEP + 1]
                most = max(most, int(third), int(length - second) - 1)
        return roomy(most)

    def usual_ends(self) -> np.ndarray:
        """The usual end of the first step of each sentence: its last token, int32 `[N]`.

        The step ends after its second group and as many of the following tokens as also follow the
        last group of some sentence: "red block, then put" ends after "red block" if a sentence ends
        with that. In a sentence with one step it is the last token.
        """
        at = [
            np.flatnonzero(row[:length] == GROUP_TOKEN)
            for row, length in zip(self.tokens, self.length, strict=True)
        ]
        endings = {
            self.tokens[n, groups[-1] + 1 : self.length[n]].tobytes()
            for n, groups in enumerate(at)
            if len(groups) > 0
        }
        ends = self.length - 1
        for n, groups in enumerate(at):
            if len(groups) > GROUPS_PER_STEP:
                second, third = groups[GROUPS_PER_STEP - 1 : GROUPS_PER_STEP + 1]
                between = self.tokens[n, second + 1 : third]
                known = [k for k in range(len(between)) if between[:k].tobytes() in endings]
                ends[n] = second + max(known, default=0)
        return ends


@dataclass(frozen=True)
class TrainingSet:
    """Demonstrations as arrays; N episodes, at most M objects, B crops in all."""

    sentences: Sentences
    crops: np.ndarray
    """Every object's crop in the initial image, float32 `[B, 3, 32, 32]` in 0..1."""
    crop_of: np.ndarray
    """Index into `crops`, int32 `[N, M]`; 0 for missing objects."""
    present: np.ndarray
    """bool `[N, M]`."""
    before: np.ndarray
    """Locations in the initial scene, float32 `[N, M, 5]`: corners, mean depth."""
    after: np.ndarray
    """The same in the final scene."""

    def __len__(self) -> int:
        return len(self.present)

    def hash(self) -> str:
        """SHA-256 of the whole set."""
        digest = hashlib.sha256()
        for part in (self.sentences, self):
            for field in fields(part):
                if isinstance(array := getattr(part, field.name), np.ndarray):
                    digest.update(f"{field.name} {array.dtype.str} {array.shape}".encode())
                    digest.update(np.ascontiguousarray(array).tobytes())
        return digest.hexdigest()

    def select(self, steps: int, single_attribute: bool = False) -> np.ndarray:
        """Indices of the episodes with this many steps; optionally only with one
        concept per group."""
        chosen = self.sentences.group_count == GROUPS_PER_STEP * steps
        if single_attribute:
            chosen &= ((self.sentences.groups >= 0).sum(axis=2) <= 1).all(axis=1)
        return np.flatnonzero(chosen)

    def location_statistics(self) -> tuple[np.ndarray, np.ndarray]:
        """Mean and standard deviation `[5]` of centre, size and depth over the initial scenes."""
        x1, y1, x2, y2, depth = np.moveaxis(self.before[self.present].astype(np.float64), -1, 0)
        values = np.stack([(x1 + x2) / 2, (y1 + y2) / 2, x2 - x1, y2 - y1, depth], axis=-1)
        return values.mean(axis=0).astype(np.float32), values.std(axis=0).astype(np.float32)


def told(
    data: TrainingSet, domain: Domain, sentences: Sequence[str], episodes: Sequence[int]
) -> TrainingSet:
    """The demonstrations with other sentences: each with the scenes of the episode given for it.

    `domain`: that of the sentences.
    """
    tokenizer, chosen = Tokenizer(domain), np.asarray(episodes, np.int64)
    return TrainingSet(
        sentences=Sentences.of(tokenizer, [tokenizer(sentence) for sentence in sentences]),
        crops=data.crops,
        crop_of=data.crop_of[chosen],
        present=data.present[chosen],
        before=data.before[chosen],
        after=data.after[chosen],
    )


def training_set(demonstrations: Demonstrations, quiet: bool = False) -> TrainingSet:
    """The demonstrations of a file as arrays; crops are cut as in the core."""
    # Imported here: training on other arrays does not need the compiled module.
    from nsrm import crop

    count, boxes = demonstrations.object_count, demonstrations.initial_boxes
    present = np.arange(boxes.shape[1]) < count[:, None]
    crops = []
    for index in tqdm(range(len(demonstrations)), desc="     crops", disable=quiet):
        image = demonstrations.initial_image(index)
        crops += [crop(image, box) for box in boxes[index, present[index]]]
    crop_of = np.where(present, np.cumsum(present).reshape(present.shape) - 1, 0)
    tokenizer = Tokenizer(demonstrations.domain)
    before = (boxes, demonstrations.initial_depths[..., None])
    after = (demonstrations.final_boxes, demonstrations.final_depths[..., None])
    return TrainingSet(
        sentences=Sentences.of(tokenizer, [tokenizer(s) for s in demonstrations.sentences]),
        crops=np.stack(crops),
        crop_of=crop_of.astype(np.int32),
        present=present,
        before=np.concatenate(before, axis=-1).astype(np.float32),
        after=np.concatenate(after, axis=-1).astype(np.float32),
    )
