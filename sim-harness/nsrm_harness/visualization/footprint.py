"""Plots what the image of a micro-controller is made of, from the counts of `cargo footprint`."""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import matplotlib as mpl

mpl.use("Agg")
from matplotlib import pyplot as plt

from nsrm_harness.common.errors import HarnessError

#: The parts of a model in read-only memory, each with the beginnings of its arrays' paths; an array
#: belongs to the first that it begins with.
PARTS = {
    "words": ("words", "group"),
    "sentence encoder": ("language.forward", "language.backward"),
    "argument decoders": ("language.object_decoder", "language.reference_decoder"),
    "splitter": ("language.splitter", "language.hazard"),
    "actions, relations,\nacceptability": ("actions", "language"),
    "spelling": ("spelling",),
    "colour view": ("vision.color",),
    "brightness view": ("vision.brightness",),
    "attributes, concepts": (
        "attributes",
        "concepts",
        "lexicon",
        "pronouns",
        "several",
        "arrangements",
    ),
    "action simulator": ("simulator", "camera"),
}
CODE = "code and constants"
#: Parts that a planner without vision leaves out.
OF_VISION = ("colour view", "brightness view")
COLUMNS = ("target", "vision", "flash_bytes", "ram_bytes", "stack_bytes")
KB = 1024


class FootprintError(HarnessError):
    """Counts that cannot be read."""


@dataclass(frozen=True)
class Footprint:
    """A row of the counts: bytes."""

    target: str
    vision: bool
    flash: int
    ram: int
    stack: int


def read(path: Path) -> list[Footprint]:
    """The rows of a file. Raises `FootprintError`."""
    advice = "write it with 'cargo footprint'"
    try:
        with path.open(encoding="utf-8", newline="") as file:
            rows = csv.DictReader(file)
            if missing := set(COLUMNS) - set(rows.fieldnames or ()):
                raise FootprintError(f"{path}: no columns {', '.join(sorted(missing))}: {advice}")
            found = [
                Footprint(
                    row["target"],
                    row["vision"] == "yes",
                    *(int(row[name]) for name in COLUMNS[2:]),
                )
                for row in rows
            ]
    except (OSError, ValueError) as error:
        raise FootprintError(f"{path}: cannot read the counts: {error}: {advice}") from error
    if not any(row.vision for row in found):
        raise FootprintError(f"{path}: no row with vision in it: {advice}")
    return found


def parts(flash: Mapping[str, Any], image: int) -> dict[str, int]:
    """The bytes of each part of an image with vision.

    * `flash`: as in ``nsrm info``
    * `image`: all its bytes
    """
    sizes = dict.fromkeys(PARTS, 0)
    for array in flash["arrays"]:
        owners = (
            name for name, paths in PARTS.items() if any(map(array["path"].startswith, paths))
        )
        if (name := next(owners, None)) is not None:
            sizes[name] += array["bytes"]
    return {**sizes, CODE: image - sum(sizes.values())}


def draw(rows: Sequence[Footprint], flash: Mapping[str, Any], path: Path) -> None:
    """The parts of the flash of the last processor, and memory by processor."""
    last = next(row for row in reversed(rows) if row.vision)
    sizes = parts(flash, last.flash)
    figure, (left, right) = plt.subplots(
        1, 2, figsize=(10.0, 4.2), layout="constrained", width_ratios=(1.25, 1.0)
    )
    names = list(sizes)
    colors = ["tab:orange" if name in OF_VISION else "tab:blue" for name in names]
    bars = left.barh(names, [size / KB for size in sizes.values()], color=colors)
    left.bar_label(bars, fmt="%.0f", padding=2)
    left.invert_yaxis()
    left.set(title=f"{last.target}: flash with vision, {last.flash / KB:.0f} KB", xlabel="KB")
    left.margins(x=0.12)

    targets = list(dict.fromkeys(row.target for row in rows))
    shown = (
        ("RAM, planner alone", False, "ram", "tab:blue"),
        ("stack, planner alone", False, "stack", "lightskyblue"),
        ("RAM, with vision", True, "ram", "tab:orange"),
        ("stack, with vision", True, "stack", "moccasin"),
    )
    for place, (label, vision, kind, color) in enumerate(shown):
        sized = {row.target: getattr(row, kind) / KB for row in rows if row.vision == vision}
        at = [index + (place - 1.5) * 0.2 for index in range(len(targets))]
        heights = [sized.get(target, 0.0) for target in targets]
        drawn = right.bar(at, heights, 0.19, color=color, label=label)
        right.bar_label(drawn, fmt="%.0f", fontsize=8, padding=1)
    right.set_xticks(range(len(targets)), targets)
    right.set(title="memory", ylabel="KB", ylim=(0.0, 1.3 * max(row.ram for row in rows) / KB))
    right.legend(fontsize=8, ncols=2)
    figure.savefig(path, dpi=110)
    plt.close(figure)
