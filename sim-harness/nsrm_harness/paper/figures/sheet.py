"""Draws a figure: its scene, the predicted sub-goals, and what is seen after each step, side by
side."""

from __future__ import annotations

from pathlib import Path

import nsrm
from PIL import Image

from nsrm_harness.paper.figures.scenes import Figure
from nsrm_harness.perception.observer import Location, ObjectNames, Observation
from nsrm_harness.visualization.pictures import (
    Arrow,
    BoxMark,
    Rect,
    annotate,
    in_rows,
    side_by_side,
)

SHOWN: Rect = (0.03, 0.14, 0.97, 0.97)
"""The part of the camera's image with blocks and labels, as fractions of its width and height."""
COLUMNS = 3
"""Number of panels in a row."""
WIDTH_PX = 1800
"""Largest width of the picture."""


class Sheet:
    """A picture made of panels, which are added one by one."""

    def __init__(self, figure: Figure) -> None:
        self._figure = figure
        self._panels: list[tuple[str, Image.Image]] = []

    def add_scene(self, sight: Observation, known: ObjectNames) -> None:
        """Adds the first observation, with the names that the model gives the objects."""
        self._first, self._known = sight, known
        marks = [self._mark(number, box, f"{number} ") for number, box in sight.locations.items()]
        self._add("The scene", annotate(sight.rgb, marks))

    def add_plan(self, plan: nsrm.Plan) -> None:
        """Adds all sub-goals, each with the number of its step."""
        self._plan = plan
        arrows, marks = [], []
        locations: dict[int, Location] = dict(self._first.locations)
        for number, step in enumerate(plan.steps, start=1):
            arrows.append(Arrow(_rect(locations[step.object_id]), _rect(step.location)))
            marks.append(self._mark(step.object_id, step.location, f"{number}: "))
            locations[step.object_id] = step.location
        self._add("The predicted sub-goals, step by step", annotate(self._first.rgb, marks, arrows))

    def add_step(self, number: int, sight: Observation, outcome: str) -> None:
        """Adds what is seen after a step: its block and, dashed, its sub-goal."""
        step = self._plan.steps[number - 1]
        seen = sight.locations.get(step.object_id)
        marks = [] if seen is None else [self._mark(step.object_id, seen)]
        goal = _rect(step.location)
        picture = annotate(sight.rgb, marks, [Arrow(goal, goal)])
        self._add(f"After step {number}: {outcome}", picture)

    def save(self, path: Path, ending: str = "") -> None:
        """Writes a PNG titled with the sentence and how it ended; without panels, removes it."""
        if not self._panels:
            path.unlink(missing_ok=True)
            return
        caption = f"Figure {self._figure.number}: “{self._figure.sentence}”"
        titles, images = zip(*self._panels, strict=True)
        panels = in_rows(images, titles, COLUMNS)
        sheet = side_by_side([panels], [f"{caption}\n{ending}" if ending else caption])
        # At full size it would fill three screens.
        sheet.thumbnail((WIDTH_PX, sheet.height), Image.Resampling.LANCZOS)
        sheet.save(path)

    def _mark(self, number: int, location: Location, before: str = "") -> BoxMark:
        label = f"{before}{self._known.words[number]}"
        return BoxMark(_rect(location), label, self._known.colors[number])

    def _add(self, title: str, image: Image.Image) -> None:
        x1, y1, x2, y2 = SHOWN
        width, height = image.size
        shown = (round(x1 * width), round(y1 * height), round(x2 * width), round(y2 * height))
        self._panels.append((title, image.crop(shown)))


def _rect(location: Location) -> Rect:
    x1, y1, x2, y2 = (float(value) for value in location[:4])
    return (x1, y1, x2, y2)
