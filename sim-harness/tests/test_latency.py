"""What is read from measurements of how fast processes answer."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from nsrm_harness.trials.latency import LatencyError, draw, read, table

ROWS = {
    ("pipe", ""): [(40_000, 90), (50_000, 10)],
    ("event", ""): [(55_000, 100)],
    ("sentence, computation alone", "waiting"): [(100_000, 60), (200_000, 40)],
    ("sentence", "waiting"): [(144_000, 99), (900_000, 1)],
    ("frame, computation alone", "spinning"): [(200_000, 100)],
    ("frame", "spinning"): [(203_000, 100)],
    ("hand-over", "640x480"): [(2_000, 100)],
    ("hand-over", "3840x2160"): [(2_100, 100)],
}


def write(path: Path, rows: dict[tuple[str, str], list[tuple[int, int]]]) -> Path:
    """A file as the program writes it."""
    lines = [
        json.dumps({"what": what, "how": how, "counts_ns": counts})
        for (what, how), counts in rows.items()
    ]
    path.write_text("\n".join(lines))
    return path


def test_quantiles_and_what_lies_between_rows_are_told(tmp_path: Path) -> None:
    rows = read(write(tmp_path / "latency.jsonl", ROWS))
    sentence = rows["sentence", "waiting"]
    assert (sentence.at(0.5), sentence.at(0.99), sentence.at(0.9999)) == (144.0, 144.0, 900.0)
    assert sentence.count == 100
    text = table(rows)
    assert "| sentence to first sub-goal, waiting | 144.0 | 144.0 | 900.0 | 900.0 | 100 |" in text
    assert "waiting: 44.0 µs above the computation alone (p50), 1.10 of a pipe's way" in text
    assert "way there and back, 0.80 of an event's." in text
    assert "spinning: 3.0 µs above the computation alone (p50)." in text
    assert "27 times the pixels: 1.05 of the time" in text
    draw(rows, tmp_path / "latency.png")
    assert (tmp_path / "latency.png").stat().st_size > 10_000


def test_what_was_broken_off_is_told(tmp_path: Path) -> None:
    with pytest.raises(LatencyError, match="No such file"):
        read(tmp_path / "latency.jsonl")
    with pytest.raises(LatencyError, match="rows are missing"):
        read(write(tmp_path / "latency.jsonl", {("frame", "waiting"): [(1, 1)]}))
    (tmp_path / "latency.jsonl").write_text("{")
    with pytest.raises(LatencyError):
        read(tmp_path / "latency.jsonl")
