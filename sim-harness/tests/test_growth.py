"""The plot of how the work of a plan grows."""

from __future__ import annotations

from pathlib import Path

import pytest
from harness_command import run

from nsrm_harness.visualization.growth import GrowthError, draw, read

ROOT = Path(__file__).resolve().parents[2]
COUNTED = ROOT / "docs/performance/growth.csv"


def test_no_axis_grows_faster_than_its_size() -> None:
    counts = read(COUNTED)
    assert list(counts) == ["objects", "steps", "tokens", "words", "concepts"]
    for axis, points in counts.items():
        least, first = points[0]
        for size, instructions in points[1:]:
            # A step's words differ: 8 of them may be a few percent longer than the first.
            assert instructions <= 1.07 * first * size / least, (axis, size)


def test_the_command_draws_a_file(tmp_path: Path) -> None:
    out = tmp_path / "new" / "growth.png"
    assert run("growth", COUNTED, "--out", out) == 0
    assert out.read_bytes().startswith(b"\x89PNG")
    draw({"steps": [(1, 10)]}, out)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("axis,size\n", "expected the columns axis,size,instructions: write it with"),
        ("axis,size,instructions\n", "there are no counts in it"),
        ("axis,size,instructions\nsteps,one,2\n", "cannot read the counts: invalid literal"),
    ],
)
def test_what_is_no_count_is_refused(content: str, message: str, tmp_path: Path) -> None:
    path = tmp_path / "growth.csv"
    path.write_text(content, encoding="utf-8")
    with pytest.raises(GrowthError, match=message):
        read(path)
    with pytest.raises(GrowthError, match="cannot read the counts"):
        read(tmp_path / "none.csv")
