"""The plot of what a micro-controller's image consists of."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Literal

import nsrm
import pytest
from harness_command import run

from nsrm_harness.visualization.footprint import (
    CODE,
    OF_VISION,
    PARTS,
    FootprintError,
    parts,
    read,
)

COUNTED = Path(__file__).resolve().parents[2] / "docs/controller/footprint.csv"
HEAD = "target,precision,vision,flash_bytes,ram_bytes,stack_bytes\n"


@pytest.mark.parametrize("precision", ["f32", "int8"])
def test_the_parts_are_the_whole_image(precision: Literal["f32", "int8"]) -> None:
    flash = nsrm.Model.pretrained(precision).info()["flash"]
    rows = [row for row in read(COUNTED) if row.precision == precision]
    (image,) = (row for row in rows if row.target == "cortex-m7" and row.vision)
    (alone,) = (row for row in rows if row.target == "cortex-m7" and not row.vision)
    sizes = parts(flash, image.flash)
    assert list(sizes) == [*PARTS, CODE] and sum(sizes.values()) == image.flash
    assert all(size > 1000 for size in sizes.values())
    header = sum(each["bytes"] for each in flash["arrays"] if each["path"].startswith("header"))
    weights = sum(each["bytes"] for each in flash["arrays"]) - header
    assert sizes[CODE] == image.flash - weights
    # With them, some code is left out.
    assert sum(sizes[name] for name in OF_VISION) < image.flash - alone.flash


def test_the_readme_tells_what_was_counted() -> None:
    readme = " ".join((COUNTED.parents[2] / "README.md").read_text(encoding="utf-8").split())
    with COUNTED.open(encoding="utf-8", newline="") as file:
        rows = [
            row
            for row in csv.DictReader(file)
            if (row["target"], row["vision"]) == ("cortex-m7", "no")
        ]
    told = {
        row["precision"]: (
            f"{int(row['instructions_1']) / 1e6:.1f} million",
            f"{int(row['flash_bytes']) / 1024:.0f} KB",
        )
        for row in rows
    }
    instructions, flash = told["f32"]
    assert f"plans one step with {instructions} instructions and {flash} of flash" in readme
    instructions, flash = told["int8"]
    assert f"or with {instructions} and {flash} if weights have [eight bits]" in readme


def test_the_command_draws_a_file(tmp_path: Path) -> None:
    out = tmp_path / "new" / "footprint.png"
    assert run("footprint", COUNTED, "--out", out) == 0
    assert out.read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("target,vision\n", "no columns flash_bytes, precision, ram_bytes, stack_bytes: write"),
        (HEAD + "cortex-m7,f32,no,1,2,3\n", "no row with vision in it"),
        (HEAD + "cortex-m7,f32,yes,1,2,many\n", "cannot read the counts: invalid literal"),
    ],
)
def test_what_is_no_count_is_refused(content: str, message: str, tmp_path: Path) -> None:
    path = tmp_path / "footprint.csv"
    path.write_text(content, encoding="utf-8")
    with pytest.raises(FootprintError, match=message):
        read(path)
    with pytest.raises(FootprintError, match="cannot read the counts"):
        read(tmp_path / "none.csv")
