"""Reading the journal of a soak test."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from nsrm_harness.evaluation.process_trials.journal import JournalError
from nsrm_harness.evaluation.process_trials.soak import draw, read_soak

SECOND = 1_000_000_000


def journal(
    rss_kib: float = 0.0, handles: float = 0.0, size: float = 0.0, said_ms: float = 0.0
) -> list[dict[str, Any]]:
    """Forty minutes, a sample and a sentence each; quantities grow by so much a minute."""
    lines = []
    for minute in range(40):
        t = minute * 60 * SECOND
        held = {"rss_kib": 8000 + rss_kib * minute, "handles": 60 + handles * minute, "threads": 1}
        lines += [
            {
                "t": t,
                "what": "sample",
                "nodes": {"planner": held},
                "shared": {"files": 200, "bytes": 1e8 + size * minute},
                "scenes": {"latency_ns": 2_000_000},
            },
            {"t": t + SECOND, "what": "ask", "ask": minute},
            {
                "t": t + 1.5 * SECOND + said_ms * minute * SECOND / 1000,
                "what": "answered",
                "ask": minute,
                "code": 2 * (minute == 3),
            },
        ]
    return lines


def test_what_stays_is_no_fault_and_is_told(tmp_path: Path) -> None:
    soak = read_soak(journal())
    assert soak.faults() == []
    assert soak.sentences == (39, 1)
    text = soak.text()
    assert "0.65 hours, 39 sentences done, 1 refused." in text
    assert "| planner: resident memory, KiB | 8000 | 8000 |" in text
    assert "| a sentence, p50 of a minute, ms | 500 | 500 |" in text
    draw(soak, tmp_path / "soak.png")
    assert (tmp_path / "soak.png").stat().st_size > 10_000


def test_the_rest_at_the_end_goes_with_the_last_whole_minute() -> None:
    soak = read_soak(journal())
    # Of 39 minutes one has no sentence that was done.
    assert len(soak.minutes) == len(soak.said_ms) == 38
    assert soak.minutes[0] == pytest.approx(1 / 60)
    assert soak.minutes[-1] == pytest.approx(soak.hours[-1]) == pytest.approx(39 / 60)


@pytest.mark.parametrize(
    ("growth", "fault"),
    [
        ({"rss_kib": 50.0}, "planner: rss_kib has grown from 8"),
        ({"handles": 1.0}, "planner: handles has grown from"),
        ({"size": 1e6}, "shared memory: bytes has grown from"),
        ({"said_ms": 300.0}, "a sentence, p50: "),
    ],
)
def test_what_grows_is_a_fault(growth: dict[str, float], fault: str) -> None:
    (found,) = read_soak(journal(**growth)).faults()
    assert found.startswith(fault)


def test_a_little_is_none() -> None:
    assert read_soak(journal(rss_kib=5.0)).faults() == []
    assert read_soak(journal(said_ms=15.0)).faults() == []


def test_a_run_without_a_sentence_that_was_done_has_no_times_to_judge(tmp_path: Path) -> None:
    lines = [line for line in journal() if line["what"] == "sample"]
    soak = read_soak(lines)
    assert soak.faults() == []
    assert "| a sentence, p50 of a minute, ms | - | - |" in soak.text()
    draw(soak, tmp_path / "soak.png")
    assert (tmp_path / "soak.png").stat().st_size > 10_000


def test_too_short_a_run_is_refused() -> None:
    with pytest.raises(JournalError, match="7 samples; 8 are needed"):
        read_soak(journal()[:21])
