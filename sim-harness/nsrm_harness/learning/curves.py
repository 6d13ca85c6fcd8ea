"""Plots the training curves of a run."""

from __future__ import annotations

from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")
from matplotlib import pyplot as plt

from nsrm_harness.learning.checkpoint import TrainingProgress


def draw_curves(progress: TrainingProgress, path: Path) -> None:
    """Plots the loss of each stage over its epochs, as a PNG."""
    names = [name for name, losses in progress.losses.items() if losses]
    figure, axes = plt.subplots(
        1, len(names), figsize=(3.2 * len(names), 3.2), layout="constrained", squeeze=False
    )
    for axis, name in zip(axes[0], names, strict=True):
        losses = progress.losses[name]
        axis.plot(range(1, len(losses) + 1), losses, color="tab:blue")
        axis.set(title=name, xlabel="epoch", yscale="log")
        axis.grid(alpha=0.3, which="both")
    axes[0][0].set_ylabel("mean loss")
    figure.savefig(path, dpi=110)
    plt.close(figure)
