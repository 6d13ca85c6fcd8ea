"""Draws boxes, names, groundings and arrows over a camera image, for people.

It draws only what is passed in and reads nothing from the simulator.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray
from PIL import Image, ImageDraw, ImageFont

SCALE = 2
"""Factor by which an image is enlarged before drawing, to keep text sharp."""

MOVED_RGB = (255, 128, 0)
REFERENCE_RGB = (40, 110, 255)
ANCHOR_RGB = (0, 150, 70)
_QUIET_RGB = (70, 70, 70)
_INK_RGB = (30, 32, 36)
_PAPER_RGB = (250, 250, 248)
_HALO_RGBA = (255, 255, 255, 215)

_LABEL_PX = 19
_BADGE_PX = 18
_CAPTION_PX = 24
_TITLE_PX = 28
_MARGIN_PX = 20

Font = ImageFont.FreeTypeFont | ImageFont.ImageFont
Rect = tuple[float, float, float, float]


@dataclass(frozen=True)
class BoxMark:
    """A box to draw around an object.

    * `box`: x1, y1, x2, y2 as fractions of the image's width and height
    * `label`: a short text, such as "3 small green"
    * `rgb`: colour of the label's background, that of the object, each in 0..1
    * `moved_in`, `reference_in`, `anchor_in`: numbers of the steps that move it, refer to it, or
      describe another object by its relation to it
    """

    box: Rect
    label: str = ""
    rgb: tuple[float, float, float] = (0.5, 0.5, 0.5)
    moved_in: tuple[int, ...] = ()
    reference_in: tuple[int, ...] = ()
    anchor_in: tuple[int, ...] = ()


@dataclass(frozen=True)
class Arrow:
    """An arrow from an object's box to the box where a step will put it, drawn dashed; both as
    fractions of the image."""

    start: Rect
    end: Rect
    step: int | None = None


@dataclass(frozen=True)
class Tie:
    """A line from an object's box to that of the object that its description relates it to; both
    as fractions of the image."""

    start: Rect
    end: Rect


def annotate(
    observation_rgb: ArrayLike,
    boxes: Sequence[BoxMark] = (),
    arrows: Sequence[Arrow] = (),
    caption: str = "",
    ties: Sequence[Tie] = (),
) -> Image.Image:
    """Draws boxes, labels, ties and arrows on the image `uint8 [H, W, 3]`, enlarged `SCALE` times,
    with the wrapped caption below.

    Moved objects have an orange frame, references a blue one, and what an object is described by a
    green one, each with the number of the step.
    """
    pixels = np.asarray(observation_rgb, dtype=np.uint8)
    height, width = pixels.shape[:2]
    image = Image.fromarray(pixels).resize(
        (width * SCALE, height * SCALE), Image.Resampling.LANCZOS
    )
    canvas = _Canvas(image)
    for mark in boxes:
        canvas.frame(mark)
    for tie in ties:
        canvas.tie(tie)
    for arrow in arrows:
        canvas.arrow(arrow)
    for mark in boxes:
        canvas.badges(mark)
    for mark in sorted(boxes, key=lambda mark: mark.box[1]):
        canvas.label(mark, [other.box for other in boxes])
    return _with_caption(canvas.image, caption) if caption else canvas.image


def side_by_side(
    images: Sequence[Image.Image | NDArray[np.uint8]], titles: Sequence[str]
) -> Image.Image:
    """Puts images in a row, enlarged to the width of the widest, each below its title.

    Raises `ValueError` if there are no images, or not as many titles.
    """
    pictures = [
        image if isinstance(image, Image.Image) else Image.fromarray(image) for image in images
    ]
    if not pictures or len(pictures) != len(titles):
        raise ValueError(f"{len(pictures)} images but {len(titles)} titles")
    width = max(picture.width for picture in pictures)
    pictures = [
        picture
        if picture.width == width
        else picture.resize(
            (width, round(picture.height * width / picture.width)), Image.Resampling.LANCZOS
        )
        for picture in pictures
    ]
    font = _font(_TITLE_PX)
    lines = [_wrap(title, font, width) for title in titles]
    line_px = round(_TITLE_PX * 1.35)
    top = _MARGIN_PX + line_px * max(len(rows) for rows in lines) + _MARGIN_PX // 2
    total = len(pictures) * (width + _MARGIN_PX) + _MARGIN_PX
    height = top + max(picture.height for picture in pictures) + _MARGIN_PX
    sheet = Image.new("RGB", (total, height), _PAPER_RGB)
    draw = ImageDraw.Draw(sheet)
    for column, (picture, rows) in enumerate(zip(pictures, lines, strict=True)):
        left = _MARGIN_PX + column * (width + _MARGIN_PX)
        for row, text in enumerate(rows):
            draw.text((left, _MARGIN_PX + row * line_px), text, font=font, fill=_INK_RGB)
        sheet.paste(picture, (left, top))
    return sheet


def in_rows(
    images: Sequence[Image.Image | NDArray[np.uint8]], titles: Sequence[str], columns: int
) -> Image.Image:
    """Like `side_by_side`, in rows of at most `columns` images and of about equal length."""
    columns = math.ceil(len(images) / math.ceil(len(images) / columns))
    rows = [
        side_by_side(images[start : start + columns], titles[start : start + columns])
        for start in range(0, len(images), columns)
    ]
    sheet = Image.new("RGB", (rows[0].width, sum(row.height for row in rows)), _PAPER_RGB)
    top = 0
    for row in rows:
        sheet.paste(row, (0, top))
        top += row.height
    return sheet


class _Canvas:
    """An enlarged image for drawing; boxes are fractions of its size."""

    def __init__(self, image: Image.Image) -> None:
        self.image = image.convert("RGB")
        self._draw = ImageDraw.Draw(self.image, "RGBA")
        self._taken: list[Rect] = []

    def frame(self, mark: BoxMark) -> None:
        rect = self._pixels(mark.box)
        if not (mark.moved_in or mark.reference_in or mark.anchor_in):
            self._draw.rectangle(_grown(rect, 2), outline=(*_QUIET_RGB, 170), width=2)
            return
        grow = 3.0
        for color, steps in (
            (MOVED_RGB, mark.moved_in),
            (REFERENCE_RGB, mark.reference_in),
            (ANCHOR_RGB, mark.anchor_in),
        ):
            if steps:
                self._draw.rectangle(_grown(rect, grow + 6), outline=_HALO_RGBA, width=7)
                self._draw.rectangle(_grown(rect, grow + 5), outline=color, width=5)
                grow += 7

    def tie(self, tie: Tie) -> None:
        ends = [
            ((left + right) / 2, (top + bottom) / 2)
            for left, top, right, bottom in map(self._pixels, (tie.start, tie.end))
        ]
        for color, width, dot in ((_HALO_RGBA, 8, 9), (ANCHOR_RGB, 4, 6)):
            self._draw.line(ends, fill=color, width=width)
            x, y = ends[1]
            self._draw.ellipse((x - dot, y - dot, x + dot, y + dot), fill=color)

    def arrow(self, arrow: Arrow) -> None:
        start, end = self._pixels(arrow.start), self._pixels(arrow.end)
        self._dashed(_grown(end, 4))
        x0, y0 = (start[0] + start[2]) / 2, (start[1] + start[3]) / 2
        x1, y1 = (end[0] + end[2]) / 2, (end[1] + end[3]) / 2
        length = math.hypot(x1 - x0, y1 - y0)
        if length < 4:
            return
        # A quadratic curve, arched like the path of the hand.
        middle = ((x0 + x1) / 2, (y0 + y1) / 2 - 0.25 * length)
        curve = []
        for i in range(33):
            t = i / 32
            curve.append(
                tuple(
                    (1 - t) ** 2 * a + 2 * t * (1 - t) * b + t * t * c
                    for a, b, c in ((x0, middle[0], x1), (y0, middle[1], y1))
                )
            )
        heading = math.atan2(y1 - middle[1], x1 - middle[0])
        head = min(32.0, 0.6 * length)
        points = [(x1, y1)]
        for side in (2.7, -2.7):
            points.append(
                (x1 + head * math.cos(heading + side), y1 + head * math.sin(heading + side))
            )
        neck = (x1 - 0.8 * head * math.cos(heading), y1 - 0.8 * head * math.sin(heading))
        shaft = [p for p in curve if math.dist(p, (x1, y1)) > head] + [neck]
        for color, width, rim in ((_HALO_RGBA, 10, 5), (MOVED_RGB, 6, 1)):
            if len(shaft) > 1:
                self._draw.line(shaft, fill=color, width=width, joint="curve")
            self._draw.polygon(points, fill=color, outline=color, width=rim)
        if arrow.step is not None:
            x, y = curve[16]
            self._badge(x, y, arrow.step, MOVED_RGB)

    def badges(self, mark: BoxMark) -> None:
        rect = _grown(self._pixels(mark.box), 6)
        for x, y, color, steps, direction in (
            (rect[0], rect[1], MOVED_RGB, mark.moved_in, 1),
            (rect[2], rect[1], REFERENCE_RGB, mark.reference_in, -1),
            (rect[0], rect[3], ANCHOR_RGB, mark.anchor_in, 1),
        ):
            for i, step in enumerate(steps):
                self._badge(x + direction * i * 1.6 * _BADGE_PX, y, step, color)

    def label(self, mark: BoxMark, others: Sequence[Rect]) -> None:
        """Draws a label at the side of its box where it hides least."""
        if not mark.label:
            return
        font = _font(_LABEL_PX)
        width = font.getlength(mark.label) + 14
        height = _LABEL_PX + 9
        x1, y1, x2, y2 = _grown(self._pixels(mark.box), 8)
        center = (x1 + x2 - width) / 2
        middle = (y1 + y2 - height) / 2
        corners = [
            (center, y2 + 3),
            (center, y1 - height - (22 if mark.moved_in or mark.reference_in else 3)),
            (x2 + 5, middle),
            (x1 - width - 5, middle),
            (x2 + 5, y2 - height),
            (x1 - width - 5, y2 - height),
            (center, y2 + height + 6),
            (center, y1 - 2 * height - 17),
        ]
        taken = self._taken + [self._pixels(other) for other in others]

        def cost(corner: tuple[float, float]) -> float:
            x, y = self._inside(*corner, width, height)
            rect = (x, y, x + width, y + height)
            shift = math.dist((x, y), corner)
            return sum(_overlap(rect, other) for other in taken) + 20 * shift

        x, y = self._inside(*min(corners, key=cost), width, height)
        rect = (x, y, x + width, y + height)
        self._taken.append(rect)
        fill = tuple(round(255 * channel) for channel in mark.rgb)
        light = 0.299 * fill[0] + 0.587 * fill[1] + 0.114 * fill[2] > 120
        self._draw.rounded_rectangle(_grown(rect, 1), 6, fill=_HALO_RGBA)
        self._draw.rounded_rectangle(rect, 5, fill=fill)
        self._draw.text(
            ((rect[0] + rect[2]) / 2, (rect[1] + rect[3]) / 2),
            mark.label,
            font=font,
            fill=_INK_RGB if light else (255, 255, 255),
            anchor="mm",
        )

    def _inside(self, x: float, y: float, width: float, height: float) -> tuple[float, float]:
        limit_x, limit_y = self.image.width - width - 3, self.image.height - height - 3
        return min(max(x, 3.0), limit_x), min(max(y, 3.0), limit_y)

    def _badge(self, x: float, y: float, number: int, color: tuple[int, int, int]) -> None:
        radius = _BADGE_PX * 0.78
        x, y = self._inside(x - radius, y - radius, 2 * radius, 2 * radius)
        rect = (x, y, x + 2 * radius, y + 2 * radius)
        self._draw.ellipse(_grown(rect, 2), fill=_HALO_RGBA)
        self._draw.ellipse(rect, fill=color)
        self._draw.text(
            (x + radius, y + radius), str(number), font=_font(_BADGE_PX), fill="white", anchor="mm"
        )
        self._taken.append(rect)

    def _dashed(self, rect: Rect, dash: float = 12.0) -> None:
        x1, y1, x2, y2 = rect
        for color, width in ((_HALO_RGBA, 8), (MOVED_RGB, 4)):
            for start, end in (
                ((x1, y1), (x2, y1)),
                ((x2, y1), (x2, y2)),
                ((x2, y2), (x1, y2)),
                ((x1, y2), (x1, y1)),
            ):
                length = math.dist(start, end)
                count = max(1, round(length / dash / 2))
                for i in range(count):
                    low, high = i / count, (i + 0.6) / count
                    self._draw.line(
                        [
                            (
                                start[0] + t * (end[0] - start[0]),
                                start[1] + t * (end[1] - start[1]),
                            )
                            for t in (low, high)
                        ],
                        fill=color,
                        width=width,
                    )

    def _pixels(self, box: Rect) -> Rect:
        x1, y1, x2, y2 = (float(value) for value in box)
        width, height = self.image.size
        return (x1 * width, y1 * height, x2 * width, y2 * height)


def _with_caption(image: Image.Image, caption: str) -> Image.Image:
    font = _font(_CAPTION_PX)
    lines = _wrap(caption, font, image.width - 2 * _MARGIN_PX)
    line_px = round(_CAPTION_PX * 1.4)
    strip = _MARGIN_PX * 2 + line_px * len(lines)
    sheet = Image.new("RGB", (image.width, image.height + strip), _PAPER_RGB)
    sheet.paste(image, (0, 0))
    draw = ImageDraw.Draw(sheet)
    for row, text in enumerate(lines):
        top = image.height + _MARGIN_PX + row * line_px
        draw.text((_MARGIN_PX, top), text, font=font, fill=_INK_RGB)
    return sheet


def _wrap(text: str, font: Font, width_px: float) -> list[str]:
    """Wraps text to lines of `width_px`; breaks words that are too long."""
    lines: list[str] = []
    for paragraph in text.split("\n"):
        line = ""
        for word in paragraph.split():
            while font.getlength(word) > width_px and len(word) > 1:
                fit = next(
                    n
                    for n in range(len(word) - 1, 0, -1)
                    if n == 1 or font.getlength(word[:n]) <= width_px
                )
                if line:
                    lines.append(line)
                    line = ""
                lines.append(word[:fit])
                word = word[fit:]
            longer = f"{line} {word}" if line else word
            if font.getlength(longer) <= width_px:
                line = longer
            else:
                lines.append(line)
                line = word
        lines.append(line)
    return lines


@lru_cache(maxsize=8)
def _font(size_px: int) -> Font:
    return ImageFont.load_default(size_px)


def _grown(rect: Rect, margin: float) -> Rect:
    return (rect[0] - margin, rect[1] - margin, rect[2] + margin, rect[3] + margin)


def _overlap(a: Rect, b: Rect) -> float:
    width = min(a[2], b[2]) - max(a[0], b[0])
    height = min(a[3], b[3]) - max(a[1], b[1])
    return width * height if width > 0 and height > 0 else 0.0
