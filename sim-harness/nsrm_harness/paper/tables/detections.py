"""Measures how well the detector finds the blocks, compared with the simulator's mask."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import asdict, dataclass, fields
from itertools import islice
from pathlib import Path
from typing import Any, NamedTuple

from nsrm_harness.common.number_text import or_dash
from nsrm_harness.domain import Domain
from nsrm_harness.evaluation.detector.measure import measure
from nsrm_harness.evaluation.detector.scenes import Picture, after_programs, of_file, with_noise
from nsrm_harness.paper.tables.cache import make_all
from nsrm_harness.paper.tables.lines import TITLES

SCENES = 500
"""Largest number of scenes used from a file."""
SPLITS = ("test", "objects_10")
STEPS = (3, 5)
"""Numbers of steps of the programs that leave stacks and hidden blocks."""
AFTER = "after_3_5"
NOISES_MM = (0.0, 2.0)
"""Standard deviations of the depth noise."""
DROPOUT = 0.01
"""Share of the pixels without depth, if there is noise."""


@dataclass(frozen=True)
class DetectorRow:
    """Figures of the detector on one set of scenes; shares in 0..1. None as in `Measure`."""

    scenes: str
    """A split's name, or `after_3_5`: scenes after programs of 3 to 5 steps."""
    noise_mm: float
    count: int
    objects: int
    recall_50: float | None
    precision_50: float | None
    recall_75: float | None
    precision_75: float | None
    mean_iou: float | None
    depth_error_mm: float | None
    place_p95_mm: float | None
    scene_ms: float


COLUMNS = tuple(field.name for field in fields(DetectorRow))


class Sighting(NamedTuple):
    """A set of scenes to measure on."""

    name: str
    """See `DetectorRow.scenes`."""
    noise_mm: float
    data: Path | None
    """None: scenes after programs."""
    domain: Domain
    count: int
    seed: int

    def pictures(self) -> Iterable[Picture]:
        """The images for the detector."""
        if self.data is None:
            pictures = after_programs(self.domain, STEPS, self.count, self.seed)
        else:
            pictures = islice(of_file(self.data), self.count)
        if self.noise_mm > 0.0:
            return with_noise(pictures, self.noise_mm / 1000, DROPOUT, self.seed)
        return pictures

    def figures(self) -> dict[str, Any]:
        """The row as JSON."""
        return asdict(self.row())

    def row(self) -> DetectorRow:
        """Figures of the detector on these scenes."""
        found, _ = measure(self.pictures())
        return DetectorRow(
            self.name,
            self.noise_mm,
            found.scenes,
            found.objects,
            found.recall_50,
            found.precision_50,
            found.recall_75,
            found.precision_75,
            found.mean_iou,
            _mm(found.depth_error_m),
            _mm(found.place_error_p95_m),
            found.scene_ms,
        )


def _mm(length_m: float | None) -> float | None:
    return None if length_m is None else 1000 * length_m


def detect_all(sightings: Iterable[Sighting], folder: Path, jobs: int) -> tuple[DetectorRow, ...]:
    """A row for each set; those cached in `folder` are not computed again.

    Raises `TaskError`.
    """
    named = {f"found-{each.name}-{each.noise_mm:g}": each for each in sightings}
    return tuple(DetectorRow(**row) for row in make_all(named, folder, jobs, "detector"))


def table_of(rows: Iterable[DetectorRow]) -> str:
    """The rows as a Markdown table."""
    lines = [
        "| scenes | noise | blocks | recall, precision at IoU 0.5 | at 0.75 | mean IoU | depth | "
        "position, p95 | time |",
        "|---|---|---:|---:|---:|---:|---:|---:|---:|",
    ]
    for row in rows:
        title = TITLES.get(row.scenes, "after programs of 3-5 steps")
        noise = f"{row.noise_mm:g} mm" if row.noise_mm > 0.0 else "none"
        shares = (row.recall_50, row.precision_50, row.recall_75, row.precision_75)
        recall_50, precision_50, recall_75, precision_75 = (or_dash(s, ".4f") for s in shares)
        depth = or_dash(row.depth_error_mm, ".2f", unit=" mm")
        place = or_dash(row.place_p95_mm, ".1f", unit=" mm")
        lines.append(
            f"| {row.count}, {title} | {noise} | {row.objects} | "
            f"{recall_50}, {precision_50} | {recall_75}, {precision_75} | "
            f"{or_dash(row.mean_iou, '.3f')} | {depth} | {place} | {row.scene_ms:.0f} ms |"
        )
    return "\n".join(lines)
