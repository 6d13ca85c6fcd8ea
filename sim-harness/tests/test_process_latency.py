"""Reading and printing the latencies of processes."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from nsrm_harness.evaluation.process_trials.latency import LatencyError, draw, read, table

ROWS = {
    ("sentence, computation alone", "waiting"): 60 * [100_000] + 40 * [200_000],
    ("sentence, overhead", "waiting"): 30 * [-10_000] + 70 * [44_000],
    ("sentence", "waiting"): 99 * [144_000] + [900_000],
    ("frame, computation alone", "spinning"): 100 * [200_000],
    ("frame, overhead", "spinning"): 100 * [3_000],
    ("frame", "spinning"): 100 * [203_000],
    ("pipe", ""): 90 * [40_000] + 10 * [50_000],
    ("hand-over", "640x480"): 100 * [2_000],
    ("hand-over", "3840x2160"): 100 * [2_100],
    ("event", ""): 100 * [42_000],
}


def write(path: Path, rows: dict[tuple[str, str], list[int]]) -> Path:
    """A file as the program writes it."""
    lines = [
        json.dumps({"what": what, "how": how, "times_ns": times})
        for (what, how), times in rows.items()
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
    assert "| frame to scene, overhead, spinning | 3.0 | 3.0 | 3.0 | 3.0 | 100 |" in text
    assert "waiting: 44.0 µs above the computation alone (p50), 1.10 of a pipe's round trip" in text
    assert "spinning: 3.0 µs above the computation alone (p50)." in text
    assert "to a waiting process: 1.05 of a pipe's round trip." in text
    assert "27 times the pixels: 1.05 of the time" in text
    draw(rows, tmp_path / "latency.png")
    assert (tmp_path / "latency.png").stat().st_size > 10_000


def test_what_was_broken_off_is_told(tmp_path: Path) -> None:
    with pytest.raises(LatencyError, match="No such file"):
        read(tmp_path / "latency.jsonl")
    with pytest.raises(LatencyError, match="rows are missing"):
        read(write(tmp_path / "latency.jsonl", {("frame", "waiting"): [1]}))
    (tmp_path / "latency.jsonl").write_text("{")
    with pytest.raises(LatencyError):
        read(tmp_path / "latency.jsonl")
