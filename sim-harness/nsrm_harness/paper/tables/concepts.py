"""Draws the learned concepts: their similarity, and the scores of blocks on them."""

from __future__ import annotations

from collections import defaultdict
from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")
import nsrm
import numpy as np
from matplotlib import pyplot as plt
from matplotlib.axes import Axes
from numpy.typing import NDArray

from nsrm_harness.data.file import Demonstrations
from nsrm_harness.data.ground_truth import GroundTruth
from nsrm_harness.domain import Domain
from nsrm_harness.learning.export import read_model

EPISODES = 100
"""Number of episodes whose blocks are scored."""


def draw_concepts(model_file: Path, episodes: Path, path: Path) -> None:
    """Draws the cosines between the concepts' embeddings, and of blocks with them, as a PNG."""
    file = read_model(model_file)
    names = [value.name for value in file.domain.concepts]
    vectors = np.asarray(file.model.vision.concept.weight, np.float64)
    vectors /= np.linalg.norm(vectors, axis=1, keepdims=True)
    blocks, scores = _scores(nsrm.Model.load(model_file), file.domain, episodes)
    figure, (left, right) = plt.subplots(1, 2, figsize=(13.0, 5.6), layout="constrained")
    _draw(left, vectors @ vectors.T, names, names, "concepts: cosine of their embeddings")
    _draw(right, scores, blocks, names, "blocks: mean cosine with each concept")
    borders = np.cumsum([len(attribute.values) for attribute in file.domain.attributes])[:-1] - 0.5
    for border in borders:
        left.axhline(border, color="black", linewidth=1)
        left.axvline(border, color="black", linewidth=1)
        right.axvline(border, color="black", linewidth=1)
    figure.savefig(path, dpi=110)
    plt.close(figure)


def _scores(
    model: nsrm.Model, domain: Domain, episodes: Path
) -> tuple[list[str], NDArray[np.float64]]:
    """Names of the kinds of blocks, and for each its mean cosine with each concept `[kinds, C]`."""
    order = [value.name for value in domain.concepts]
    found: defaultdict[str, list[list[float]]] = defaultdict(list)
    with Demonstrations(episodes) as demonstrations, GroundTruth(episodes) as judge:
        for index in range(min(EPISODES, len(demonstrations))):
            image, truth = demonstrations.initial_image(index), judge.truth(index)
            for row in range(len(truth.attributes)):
                crop = nsrm.crop(image, demonstrations.initial_boxes[index, row])
                cosines = model.similarities(model.encode_crop(crop))
                found[truth.name(row + 1)].append([cosines[name] for name in order])
    kinds = sorted(found, key=lambda kind: [order.index(word) for word in reversed(kind.split())])
    return kinds, np.array([np.mean(found[kind], axis=0) for kind in kinds])


def _draw(
    axis: Axes, values: NDArray[np.float64], rows: list[str], columns: list[str], title: str
) -> None:
    axis.imshow(values, cmap="RdBu_r", vmin=-1.0, vmax=1.0, aspect="auto")
    axis.set_xticks(range(len(columns)), columns, rotation=45, ha="right")
    axis.set_yticks(range(len(rows)), rows)
    axis.set_title(title)
    for (row, column), value in np.ndenumerate(values):
        color = "white" if abs(value) > 0.6 else "black"
        axis.text(column, row, f"{value:.2f}", ha="center", va="center", fontsize=7, color=color)
