"""The judge of a chaos run: a journal without faults, and that journal with one fault each."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from nsrm_harness.evaluation.process_trials.chaos import judge
from nsrm_harness.evaluation.process_trials.journal import JournalError, read

MS = 1_000_000
Line = dict[str, Any]
Lines = list[Line]

PLANNED = {"event": "planned", "plan": 70, "number": 1, "steps": [{"action": "MoveOn"}]}
COMMANDED = {"event": "commanded", "plan": 70, "number": 2, "step": 0}
REACHED = {"event": "reached", "plan": 70, "number": 3, "step": 0}
DONE = {"event": "done", "plan": 70, "number": 4}


def line(ms: int, what: str, **more: Any) -> Line:
    """A line of a journal; `pid` is that of the controller."""
    return {"t": ms * MS, "what": what, "who": "test", "pid": 5} | more


def journal() -> Lines:
    """A sentence that is done; another whose controller is killed; a third, after it."""
    command = {"plan": 70, "command": 1, "step": 0, "object": 3}
    lost = command | {"plan": 71}
    last = command | {"plan": 72}
    failed = {"event": "failed", "plan": 71, "number": 2, "reason": "controller_lost"}
    message = "nsrm: step 1: the controller was lost, so it is unknown"
    return [
        line(0, "started", node="controller", process=5),
        line(1, "ask", ask=1),
        *(line(2 + i, "said", ask=1, event=e) for i, e in enumerate((PLANNED, COMMANDED))),
        line(4, "accepted", **command),
        line(5, "moved", **command),
        *(line(6 + i, "said", ask=1, event=e) for i, e in enumerate((REACHED, DONE))),
        line(9, "answered", ask=1, code=0, message=""),
        line(10, "ask", ask=2),
        line(11, "said", ask=2, event=PLANNED | {"plan": 71}),
        line(12, "accepted", **lost),
        line(13, "kill", node="controller", process=5),
        line(300, "noticed", node="controller", process=5, how="silence", after_ns=0, kept_ns=0),
        line(301, "said", ask=2, event=failed),
        line(302, "answered", ask=2, code=2, message=message),
        line(303, "started", node="controller", process=6),
        line(400, "ask", ask=3),
        *(
            line(401 + i, "said", ask=3, event=event | {"plan": 72})
            for i, event in enumerate((PLANNED, COMMANDED))
        ),
        line(404, "accepted", **last) | {"pid": 6},
        line(405, "moved", **last) | {"pid": 6},
        *(
            line(406 + i, "said", ask=3, event=event | {"plan": 72})
            for i, event in enumerate((REACHED, DONE))
        ),
        line(409, "answered", ask=3, code=0, message=""),
        line(410, "recovered", done=True),
        line(411, "ended", node="controller", process=6, code=0),
        line(412, "left", names=[]),
    ]


def find(lines: Lines, what: str, number: int = 0) -> Line:
    """The first, or a later, line of a kind."""
    return [line for line in lines if line["what"] == what][number]


def test_a_run_in_which_all_is_well_has_no_fault() -> None:
    verdict = judge(journal())
    assert verdict.faults == ()
    assert verdict.counts["sentences asked"] == 3
    assert (verdict.counts["done"], verdict.counts["ended with a reason"]) == (2, 1)
    assert (verdict.counts["kills"], verdict.counts["carried out"]) == (1, 2)
    assert "no fault" in verdict.text()


def without(what: str, number: int = 0) -> Callable[[Lines], None]:
    """Takes a line away."""
    return lambda lines: lines.remove(find(lines, what, number))


def but(what: str, number: int = 0, **values: Any) -> Callable[[Lines], None]:
    """Sets values in a line."""
    return lambda lines: find(lines, what, number).update(values)


def again(what: str, number: int = 0) -> Callable[[Lines], None]:
    """Writes a line twice."""
    return lambda lines: lines.append(dict(find(lines, what, number)))


def both(*spoils: Callable[[Lines], None]) -> Callable[[Lines], None]:
    """One after the other."""

    def spoil(lines: Lines) -> None:
        for each in spoils:
            each(lines)

    return spoil


@pytest.mark.parametrize(
    ("spoil", "fault"),
    [
        (again("moved"), "carried out 2 times"),
        (again("accepted"), "accepted twice"),
        (without("accepted"), "carried out but not accepted"),
        (lambda lines: lines.append(find(lines, "moved") | {"what": "stopped"}), "was stopped and"),
        (
            lambda lines: lines.append(find(lines, "moved") | {"what": "came too late"}),
            "came too late but was accepted",
        ),
        (without("kill"), "its live controller did nothing"),
        (both(without("moved"), but("accepted", pid=9)), "but its sentence was reported done"),
        (without("moved"), "after 0 of 1 steps"),
        (without("answered", 1), "sentence 2 has 0 ends"),
        (again("answered"), "sentence 1 has 2 ends"),
        (without("said", 2), "sentence 1: replies [1, 2, 4]"),
        (without("said", 3), "was reported done after"),
        (but("answered", 1, message=""), "sentence 2 ended without a reason"),
        (but("answered", 1, code=101), "ended with code 101"),
        (but("answered", 1, code=None), "more clients were ended by a signal"),
        (
            but("noticed", after_ns=501 * MS),
            "loss of the controller was detected only after 501 ms",
        ),
        (but("recovered", done=False), "no sentence was carried out at the end"),
        (but("ended", code=1), "ended with code 1"),
        (without("ended"), "no node was stopped at the end"),
        (but("left", names=["a.data"]), "left behind: ['a.data']"),
        (without("left"), "there was no check"),
        (
            lambda lines: lines.append(line(20, "ended", node="planner", process=7, code=1)),
            "the planner exited on its own with code 1",
        ),
        (
            lambda lines: lines.append(line(20, "ended", node="camera", process=7, code=0)),
            "the camera exited on its own with code 0",
        ),
    ],
)
def test_what_must_not_be_is_told(spoil: Callable[[Lines], None], fault: str) -> None:
    lines = journal()
    spoil(lines)
    faults = judge(sorted(lines, key=lambda line: line["t"])).faults
    assert any(fault in each for each in faults), faults


def test_time_in_which_the_onlooker_did_not_run_is_not_the_nodes() -> None:
    lines = journal()
    but("noticed", after_ns=600 * MS, kept_ns=150 * MS)(lines)
    assert judge(lines).faults == ()


def test_a_plan_of_which_nobody_was_told_must_be_of_one_who_was_killed() -> None:
    lines = journal()
    without("said", 4)(lines)
    lines[:] = [line for line in lines if line.get("ask") != 2]
    assert any("no client was told" in fault for fault in judge(lines).faults)
    lines.append(line(12, "kill", node="client", process=8))
    assert judge(lines).faults == ()


@pytest.mark.parametrize(
    ("event", "excuses"),
    [
        ({"error": {"kind": "planner_lost"}}, True),
        ({"error": {"kind": "reply_lost"}}, True),
        ({"error": {"kind": "no_planner"}}, False),
        # Whatever is said of it.
        ({"error": {"kind": "iceoryx", "message": "reply 1 was lost"}}, False),
        ({"error": {"message": "the planner died or hangs"}}, False),
        ({"event": "failed", "reason": "controller_lost"}, False),
    ],
)
def test_or_of_one_who_was_told_of_a_lost_planner_or_reply(event: Line, excuses: bool) -> None:
    lines = journal()
    # Of its plan it has heard nothing.
    lines.remove(find(lines, "said", 4))
    but("said", 4, event=event)(lines)
    faults = judge(lines).faults
    told = () if excuses else ("1 plans were not carried out, and no client was told",)
    assert faults == told


def test_when_who_asked_was_told_of_a_death_goes_by_the_reason() -> None:
    lines = journal()
    planned, failed = find(lines, "said", 4), find(lines, "said", 5)
    commanded = line(12, "said", ask=2, event=COMMANDED | {"plan": 71})
    lines.insert(lines.index(planned) + 1, commanded)
    but("answered", 1, message="nsrm: in other words")(lines)
    assert judge(lines).told_ms == (289.0,)
    failed["event"] = failed["event"] | {"reason": "no_scene"}
    assert judge(lines).told_ms == ()


def test_what_can_not_be_read_is_told(tmp_path: Path) -> None:
    path = tmp_path / "journal.jsonl"
    with pytest.raises(JournalError, match="No such file"):
        read(path)
    path.write_text(json.dumps(line(1, "ask", ask=1)) + "\n{")
    with pytest.raises(JournalError, match="line 2: invalid JSON"):
        read(path)
    with pytest.raises(JournalError, match="unknown kinds: \\['surprise'\\]"):
        judge([line(1, "surprise")])
