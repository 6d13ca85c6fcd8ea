"""`cargo compare`: the contenders' protocol in Python, and the plot.

The ONNX graphs are compared with the model by `harness onnx` itself: the checks do without ONNX.
"""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
import pytest
from harness_command import run

from nsrm_harness.learning.comparison import protocol
from nsrm_harness.learning.comparison.plot import ComparisonError, draw, read
from nsrm_harness.learning.comparison.protocol import ProtocolError, Work, serve

TABLE = """job,contender,p50_us,p99_us,p9999_us
plan,empty,0.020,0.031,0.200
plan,nsrm,26.500,40.000,70.250
crops,nsrm,60.000,80.000,90.000
"""


def answers(lines: str, monkeypatch: pytest.MonkeyPatch, folder: Path) -> list[str]:
    """What a contender writes whose splitter gives two numbers."""
    written = io.StringIO()
    monkeypatch.setattr(protocol.sys, "argv", ["contender", str(folder)])
    monkeypatch.setattr(protocol.sys, "stdin", io.StringIO(lines))
    monkeypatch.setattr(protocol.sys, "stdout", written)
    work = Work(run=lambda: None, outputs=lambda: {"hazards": np.array([[0.5], [1e-9]])})
    serve("nothing 1", lambda path, job: work)
    return written.getvalue().splitlines()


def test_each_line_is_answered(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    lines = answers("outputs splitter\ntime splitter 3\n", monkeypatch, tmp_path)
    ready, outputs, end, times = lines
    assert (ready, outputs, end) == ("ready nothing 1", "output hazards 0.5 1e-09", "end")
    word, *numbers = times.split()
    assert word == "times" and len(numbers) == 3 and all(int(number) >= 0 for number in numbers)


@pytest.mark.parametrize("line", ["sing", "outputs song", "time splitter 3"])
def test_unknown_lines_are_errors(
    line: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    with pytest.raises(ProtocolError, match="unknown request"):
        answers(line + "\n", monkeypatch, tmp_path)


def test_the_table_is_read_and_drawn(tmp_path: Path) -> None:
    table, plot = tmp_path / "compare.csv", tmp_path / "compare.png"
    table.write_text(TABLE)
    times = read(table)
    assert times == {
        "plan": {"empty": (0.02, 0.031), "nsrm": (26.5, 40.0)},
        "crops": {"nsrm": (60.0, 80.0)},
    }
    draw(times, plot)
    assert plot.read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("job,p50_us\nplan,1\n", "expected the columns"),
        (TABLE.replace("26.500", "fast"), "cannot read the times"),
        (TABLE.splitlines()[0], "no times"),
    ],
)
def test_other_tables_are_refused(text: str, expected: str, tmp_path: Path) -> None:
    path = tmp_path / "compare.csv"
    path.write_text(text)
    with pytest.raises(ComparisonError, match=expected):
        read(path)


def test_a_missing_table_is_bad_input(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run("comparison", tmp_path / "none.csv", "--out", tmp_path / "a.png") == 2
    assert "none.csv: cannot read the times" in capsys.readouterr().err
