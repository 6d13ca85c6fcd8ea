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
    "words": ("words", "embeddings"),
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
        "placing",
        "conjunctions",
        "several",
        "rephrasing",
        "simplification",
        "exceptions",
        "perspectives",
        "lists",
        "repairs",
        "sequence",
        "distances",
        "apart",
        "ordinals",
        "arrangements",
        "table",
        "compounds",
    ),
    "action simulator": ("simulator", "camera"),
}
CODE = "code and constants"
#: Parts that a planner without vision leaves out.
OF_VISION = ("colour view", "brightness view")
COLUMNS = ("target", "precision", "vision", "flash_bytes", "ram_bytes", "stack_bytes")
KB = 1024


class FootprintError(HarnessError):
    """Counts that cannot be read."""


@dataclass(frozen=True)
class Footprint:
    """A row of the counts: bytes."""

    target: str
    precision: str
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
                    row["precision"],
                    row["vision"] == "yes",
                    *(int(row[name]) for name in COLUMNS[3:]),
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


def draw(rows: Sequence[Footprint], flash: Mapping[str, Mapping[str, Any]], path: Path) -> None:
    """The parts of the flash of the last processor, and memory by processor.

    * `flash`: of the model in each precision, as in ``nsrm info``
    """
    target = rows[-1].target
    figure, (left, right) = plt.subplots(
        1, 2, figsize=(11.0, 5.0), layout="constrained", width_ratios=(1.25, 1.0)
    )
    shades = {"f32": ("tab:blue", "tab:orange"), "int8": ("lightskyblue", "moccasin")}
    for place, (precision, of_model) in enumerate(flash.items()):
        images = (row for row in rows if row.vision and row.target == target)
        image = next(row.flash for row in images if row.precision == precision)
        sizes = parts(of_model, image)
        colors = [shades[precision][name in OF_VISION] for name in sizes]
        at = [index + 0.4 * place for index in range(len(sizes))]
        label = f"{precision}, {image / KB:.0f} KB"
        kilobytes = [size / KB for size in sizes.values()]
        bars = left.barh(at, kilobytes, 0.38, color=colors, label=label)
        left.bar_label(bars, fmt="%.0f", padding=2, fontsize=8)
        left.set_yticks([index + 0.2 for index in range(len(sizes))], list(sizes))
    left.invert_yaxis()
    left.set(title=f"{target}: flash with vision", xlabel="KB")
    left.margins(x=0.12)
    left.legend(fontsize=8, loc="center right")

    targets = list(dict.fromkeys(row.target for row in rows))
    shown = (
        ("RAM, planner alone", False, "ram", "tab:blue"),
        ("stack, planner alone", False, "stack", "lightskyblue"),
        ("RAM, with vision", True, "ram", "tab:orange"),
        ("stack, with vision", True, "stack", "moccasin"),
    )
    for place, (label, vision, kind, color) in enumerate(shown):
        at = [index + (place - 1.5) * 0.2 for index in range(len(targets))]
        # The greater of both precisions.
        heights = [
            max(
                getattr(row, kind) / KB
                for row in rows
                if (row.target, row.vision) == (each, vision)
            )
            for each in targets
        ]
        drawn = right.bar(at, heights, 0.19, color=color, label=label)
        right.bar_label(drawn, fmt="%.0f", fontsize=8, padding=1)
    right.set_xticks(range(len(targets)), targets)
    right.set(title="memory", ylabel="KB", ylim=(0.0, 1.3 * max(row.ram for row in rows) / KB))
    right.legend(fontsize=8, ncols=2)
    figure.savefig(path, dpi=110)
    plt.close(figure)
