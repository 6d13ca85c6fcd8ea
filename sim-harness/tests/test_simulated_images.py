"""Drawings over the camera's images."""

from __future__ import annotations

import numpy as np
import pytest

from nsrm_harness.visualization.pictures import (
    MOVED_RGB,
    REFERENCE_RGB,
    SCALE,
    Arrow,
    BoxMark,
    annotate,
    in_rows,
    side_by_side,
)

GRAY = np.full((120, 160, 3), 128, dtype=np.uint8)


def count(image, color: tuple[int, int, int]) -> int:
    return int(np.all(np.asarray(image) == color, axis=-1).sum())


def test_the_image_is_enlarged_and_left_alone_without_marks():
    image = annotate(GRAY)
    assert image.size == (160 * SCALE, 120 * SCALE)
    assert count(image, (128, 128, 128)) == image.width * image.height


def test_moved_and_reference_stand_out_in_their_colours():
    box = (0.3, 0.3, 0.6, 0.6)
    plain = annotate(GRAY, [BoxMark(box)])
    assert count(plain, MOVED_RGB) == count(plain, REFERENCE_RGB) == 0
    moved = annotate(GRAY, [BoxMark(box, moved_in=(1,))])
    assert count(moved, MOVED_RGB) > 300 and count(moved, REFERENCE_RGB) == 0
    both = annotate(GRAY, [BoxMark(box, moved_in=(1,), reference_in=(2,))])
    assert count(both, MOVED_RGB) > 300 and count(both, REFERENCE_RGB) > 300


def test_labels_have_the_objects_colour_and_stay_inside():
    corners = [(0.0, 0.0, 0.1, 0.1), (0.9, 0.9, 1.0, 1.0), (0.9, 0.0, 1.0, 0.1)]
    for box in corners:
        image = annotate(GRAY, [BoxMark(box, "4 small cyan", (0.0, 1.0, 1.0))])
        assert count(image, (0, 255, 255)) > 1000, box


def test_two_labels_do_not_cover_each_other():
    box = (0.4, 0.5, 0.6, 0.7)
    marks = [BoxMark(box, "1 red", (1.0, 0.0, 0.0)), BoxMark(box, "2 blue", (0.0, 0.0, 1.0))]
    image = annotate(GRAY, marks)
    for mark, color in zip(marks, ((255, 0, 0), (0, 0, 255)), strict=True):
        assert count(image, color) >= 0.95 * count(annotate(GRAY, [mark]), color)


def test_arrows_lead_to_a_dashed_box():
    image = annotate(GRAY, arrows=[Arrow((0.1, 0.4, 0.2, 0.5), (0.7, 0.4, 0.8, 0.5), 1)])
    pixels = np.all(np.asarray(image) == MOVED_RGB, axis=-1)
    assert pixels[:, 160:200].any(), "the shaft crosses the middle"
    assert pixels[80:120, 220:260].sum() > 100, "the box at its end"


def test_a_short_move_has_no_arrow_but_a_box():
    box = (0.4, 0.4, 0.5, 0.5)
    assert count(annotate(GRAY, arrows=[Arrow(box, box)]), MOVED_RGB) > 50


def test_long_captions_are_wrapped_below_the_image():
    short, long = (annotate(GRAY, caption=text) for text in ("go", "put the block " * 20))
    assert short.width == long.width == 160 * SCALE
    assert 120 * SCALE < short.height < long.height
    unbroken = annotate(GRAY, caption="x" * 300)
    dark = np.asarray(unbroken.convert("L"))[120 * SCALE :] < 100
    assert dark.any() and not dark[:, -8:].any(), "a word that is too long is broken"


def test_side_by_side_holds_all_images_and_titles():
    red = np.zeros((50, 100, 3), np.uint8) + np.array([255, 0, 0], np.uint8)
    sheet = side_by_side([red, annotate(GRAY)], ["before", "after"])
    assert sheet.width > 2 * 160 * SCALE and sheet.height > 120 * SCALE
    assert count(sheet, (255, 0, 0)) > 0.95 * 320 * 160, "the smaller is enlarged"
    with pytest.raises(ValueError, match="1 images but 2 titles"):
        side_by_side([red], ["a", "b"])


def test_many_images_go_into_rows_of_about_equal_length():
    red = np.zeros((50, 100, 3), np.uint8) + np.array([255, 0, 0], np.uint8)
    row = side_by_side([red] * 3, ["one"] * 3)
    sheet = in_rows([red] * 5, ["one"] * 5, 4)
    assert sheet.size == (row.width, 2 * row.height)
    assert count(sheet, (255, 0, 0)) == 5 * 50 * 100
    assert in_rows([red] * 3, ["one"] * 3, 4).tobytes() == row.tobytes()
