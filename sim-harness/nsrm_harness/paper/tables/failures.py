"""Draws the episodes on which a model does worst, with what went wrong."""

from __future__ import annotations

import heapq
from pathlib import Path

import nsrm
import numpy as np
from PIL import Image

from nsrm_harness.common.json_text import json_text
from nsrm_harness.data.file import Demonstrations
from nsrm_harness.data.ground_truth import StepTruth
from nsrm_harness.evaluation.metrics import JudgedPlans, judge_episodes
from nsrm_harness.visualization.illustrate import draw_steps

COUNT = 20
COLUMNS = 4
TILE_PX = 640
"""Width of an episode's tile on the sheet."""
GAP_PX = 16
PALETTE = 192
"""Number of colours of the sheet, which reduces it to a third of the bytes."""


def worst_episodes(model: nsrm.Model, path: Path) -> list[JudgedPlans]:
    """The `COUNT` worst episodes, worst first: wrong programs, then wrong objects, then by IoU."""
    judged = (each for (each,) in judge_episodes([model], path, name="worst episodes"))
    return heapq.nsmallest(COUNT, judged, key=_merit)


def _merit(judged: JudgedPlans) -> tuple[float, ...]:
    score = judged.score
    return (score.program, score.object and score.reference, score.iou_3d)


def what_went_wrong(judged: JudgedPlans) -> str:
    """One sentence for each wrong step; if all are right, their position errors."""
    if judged.outcome is None:
        return "The detector cannot use the image."
    if isinstance(judged.outcome, nsrm.Refused):
        return f"Refused: {judged.outcome}"
    planned, meant = judged.outcome.steps, judged.truth.steps
    if len(planned) != len(meant):
        return f"Understood as {len(planned)} steps instead of {len(meant)}."
    wrong = [
        f"Step {number}: {problem}."
        for number, (own, true) in enumerate(zip(planned, meant, strict=True), start=1)
        if (problem := _difference(own, true))
    ]
    return " ".join(wrong) or _misses(judged.outcome.steps, meant)


def _difference(planned: nsrm.PlannedStep, meant: StepTruth) -> str:
    if planned.action != meant.step.action:
        return f"{planned.action} instead of {meant.step.action}"
    for what, own, true in (
        ("moves", planned.object_id, meant.object_id),
        ("refers to", planned.reference_id, meant.reference_id),
    ):
        if own != true:
            return f"{what} block {own} instead of {true}"
    for what, own, true in (
        ("object", planned.object, meant.step.object),
        ("reference", planned.reference, meant.step.reference),
    ):
        if isinstance(own, dict) or sorted(own) != sorted(true):
            understood = json_text(own) if isinstance(own, dict) else " ".join(own)
            return f"the {what} is understood as {understood} instead of {' '.join(true)}"
    return ""


def _misses(planned: list[nsrm.PlannedStep], meant: tuple[StepTruth, ...]) -> str:
    parts = []
    for number, (own, true) in enumerate(zip(planned, meant, strict=True), start=1):
        x, y, z = np.subtract(own.position, true.sub_goal.position) * 1e3
        parts.append(f"step {number} by {x:+.1f}, {y:+.1f}, {z:+.1f} mm")
    return f"Understood; errors along x, y, z: {'; '.join(parts)}."


def draw_failures(worst: list[JudgedPlans], path: Path, out: Path) -> None:
    """Draws all of them on one sheet: the plan, if any, over the initial scene."""
    tiles = []
    with Demonstrations(path) as demonstrations:
        for judged in worst:
            plan = judged.outcome
            steps = plan.steps if isinstance(plan, nsrm.Plan) else []
            sentence = demonstrations.sentences[judged.index]
            caption = f"{judged.index}: “{sentence}”\n{what_went_wrong(judged)}"
            tile = draw_steps(demonstrations, judged.truth, judged.index, steps, caption)
            height = round(tile.height * TILE_PX / tile.width)
            tiles.append(tile.resize((TILE_PX, height), Image.Resampling.LANCZOS))
    sheet = _sheet(tiles)
    sheet.quantize(PALETTE, dither=Image.Dither.NONE).save(out, optimize=True)


def _sheet(tiles: list[Image.Image]) -> Image.Image:
    rows = [tiles[start : start + COLUMNS] for start in range(0, len(tiles), COLUMNS)]
    heights = [max(tile.height for tile in row) for row in rows]
    width = COLUMNS * (TILE_PX + GAP_PX) + GAP_PX
    sheet = Image.new("RGB", (width, sum(heights) + GAP_PX * (len(rows) + 1)), "white")
    top = GAP_PX
    for row, height in zip(rows, heights, strict=True):
        for column, tile in enumerate(row):
            sheet.paste(tile, (GAP_PX + column * (TILE_PX + GAP_PX), top))
        top += height + GAP_PX
    return sheet
