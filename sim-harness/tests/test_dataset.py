"""What training reads from an episode file, and what it does not."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from nsrm_harness import domain as domains
from nsrm_harness.common.workers import LocalProcesses
from nsrm_harness.data.file import Demonstrations
from nsrm_harness.data.generate import SPLITS, generate
from nsrm_harness.domain.tokens import Tokenizer
from nsrm_harness.learning import reference
from nsrm_harness.learning.config import StageConfig, TrainingConfig
from nsrm_harness.learning.dataset import Sentences, TrainingSet, training_set
from nsrm_harness.learning.model import tensors
from nsrm_harness.learning.train import Curriculum, train

DOMAIN = domains.load()
SETTINGS = replace(SPLITS["train"], count=12, seed=3, attributes=(1, 1), renderer="pybullet")
NONE = StageConfig(epochs=0, learning_rate=1e-3, batch=4)
FEW_STEPS = TrainingConfig(
    attempts=1,
    actions=replace(NONE, epochs=2),
    selection=NONE,
    attributes=NONE,
    splitter=NONE,
    joint=NONE,
    simulator=NONE,
    perception=NONE,
    parser=NONE,
)

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def episodes(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("episodes") / "train.h5"
    assert generate(SETTINGS, DOMAIN, path, LocalProcesses(2))
    return path


def read(path: Path) -> TrainingSet:
    with Demonstrations(path) as demonstrations:
        return training_set(demonstrations, quiet=True)


def weights(path: Path, folder: Path) -> dict[str, np.ndarray]:
    curriculum = Curriculum(DOMAIN, read(path), FEW_STEPS, seed=0)
    model = train(curriculum, folder, quiet=True).model
    return {name: np.asarray(array) for name, array in tensors(model).items()}


def test_shuffled_truth_changes_no_weight(episodes: Path, tmp_path: Path) -> None:
    shuffled = Path(shutil.copy(episodes, tmp_path / "shuffled.h5"))
    rng = np.random.default_rng(0)
    changed = 0
    with h5py.File(shuffled, "r+") as file:
        truth: Any = file["evaluation"]
        for name in truth:
            before = truth[name][:]
            truth[name][:] = after = before[rng.permutation(len(before))]
            changed += not np.array_equal(before, after)
    assert changed >= 5
    assert read(episodes).hash() == read(shuffled).hash()
    expected, found = weights(episodes, tmp_path / "a"), weights(shuffled, tmp_path / "b")
    for name, array in expected.items():
        np.testing.assert_array_equal(array, found[name], err_msg=name)


def test_another_outcome_changes_weights(episodes: Path, tmp_path: Path) -> None:
    """The counterpart: what is learned from does matter."""
    other = Path(shutil.copy(episodes, tmp_path / "other.h5"))
    with h5py.File(other, "r+") as file:
        boxes: Any = file["final/boxes"]
        boxes[:] = boxes[:][::-1]
    assert read(episodes).hash() != read(other).hash()
    expected, found = weights(episodes, tmp_path / "a"), weights(other, tmp_path / "b")
    assert any(not np.array_equal(array, found[name]) for name, array in expected.items())


def test_arrays_are_what_the_file_shows(episodes: Path) -> None:
    data = read(episodes)
    with Demonstrations(episodes) as demonstrations:
        for index in range(len(demonstrations)):
            count = int(demonstrations.object_count[index])
            assert data.present[index].sum() == count
            boxes = demonstrations.initial_boxes[index]
            np.testing.assert_array_equal(data.before[index, :, :4], boxes)
            box = boxes[count - 1].astype(np.float64)
            expected = reference.crop(demonstrations.initial_image(index), box)
            found = data.crops[data.crop_of[index, count - 1]]
            np.testing.assert_allclose(found, expected, atol=1e-5)
    words = data.sentences
    assert ((words.tokens == 0).sum(axis=1) >= words.group_count).all()
    assert len(data.select(1)) + len(data.select(2)) == len(data)
    assert set(data.select(1, single_attribute=True)) == set(data.select(1))


def test_steps_usually_end_as_sentences_do() -> None:
    tokenizer = Tokenizer(DOMAIN)
    sentences = [
        "put the red block on the blue block",
        "put the red block on the blue",
        "put red on blue block, then put green on the red one",
        "on blue put red put green on red",
    ]
    padded = Sentences.of(tokenizer, [tokenizer(sentence) for sentence in sentences])
    words = [
        " ".join(DOMAIN.vocabulary()[row] for row in tokens[: end + 1])
        for tokens, end in zip(padded.tokens, padded.usual_ends(), strict=True)
    ]
    assert words[0].endswith("[[X]] block") and words[1].endswith("on the [[X]]")
    assert words[2:] == ["put [[X]] on [[X]] block", "on [[X]] put [[X]]"]
