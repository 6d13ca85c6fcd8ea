"""Judges a chaos run by the lines of its journal alone, and lists the faults.

What must hold, whichever process was killed, and whenever:

* A command that a controller accepted is carried out once, or is stopped, or its controller died;
  then the client was told that it was not done, unless the client was killed as well.
* No command is carried out twice, after it was stopped, or without having been accepted.
* Each sentence ends once: done, with all of its steps carried out, or with a reason.
* If a plan was not carried out and no client reports having heard of it, its client was killed, or
  was told that the planner or a reply was lost.
* A death or hang is detected within half a second. No node exits on its own.
* At the end a sentence is carried out again, every process exits cleanly, and nothing is left
  behind.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

import numpy as np

from nsrm_harness.evaluation.process_trials.journal import JournalError, Line

NOTICED_NS = 500_000_000
"""Within this time a death or hang must be detected."""

PLANNER_LOST, REPLY_LOST = "planner_lost", "reply_lost"
"""Kinds of errors of a client that may never have heard of a plan that was made."""
CONTROLLER_LOST = "controller_lost"
"""The reason that a planner gives when its controller is lost."""

Command = tuple[int, int]
"""Plan and command number."""


@dataclass
class _Ask:
    """A sentence, from its request to its end."""

    begun_ns: int
    events: list[Line] = field(default_factory=list)
    ends: list[Line] = field(default_factory=list)

    @property
    def plan(self) -> int | None:
        """The plan made for it, if its client has heard of one."""
        return next((event["plan"] for event in self.events if event.get("plan")), None)

    @property
    def why(self) -> str | None:
        """Why it was not done, as far as its client knows: the planner's last reason, or the kind
        of the error after which nothing more is heard."""
        if self.code != 2:
            return None
        whys = (event.get("reason") or _kind_of_error(event) for event in reversed(self.events))
        return next((why for why in whys if why), None)

    @property
    def code(self) -> int | None:
        """Exit code of its process; None if it was killed."""
        return self.ends[-1]["code"] if self.ends else None


def _kind_of_error(event: Line) -> str | None:
    return event["error"].get("kind") if "error" in event else None


@dataclass(frozen=True)
class ChaosVerdict:
    """The verdict on a journal.

    * `faults`: violations of what must hold; empty if there is none
    * `counts`: how often each event happened
    * `noticed_ms`: milliseconds until each death or hang was detected
    * `told_ms`: milliseconds until clients were told of a death
    """

    faults: tuple[str, ...]
    counts: Mapping[str, int]
    noticed_ms: tuple[float, ...]
    told_ms: tuple[float, ...]

    def text(self) -> str:
        """The verdict as text for people."""
        lines = [f"{count:>8} {what}" for what, count in self.counts.items()]
        for what, times in (
            ("death or hang detected", self.noticed_ms),
            ("client told of it", self.told_ms),
        ):
            if times:
                p50, p99 = np.percentile(times, [50, 99])
                most = max(times)
                lines.append(f"{what} after {p50:.0f} ms (p50), {p99:.0f} (p99), {most:.0f} (most)")
        lines += [f"FAULT: {fault}" for fault in self.faults] or ["no fault"]
        return "\n".join(lines)


def judge(lines: Iterable[Line]) -> ChaosVerdict:
    """Judges the lines of a journal, given in the order of time."""
    lines = list(lines)
    of = {what: [line for line in lines if line["what"] == what] for what in _KINDS}
    if unknown := {line["what"] for line in lines} - set(_KINDS):
        raise JournalError(f"the journal has lines of unknown kinds: {sorted(unknown)}")
    asks = _asks(lines)
    killed_clients = sum(line["node"] == "client" for line in of["kill"])
    noticed = [line["after_ns"] - line["kept_ns"] for line in of["noticed"]]
    faults = [
        *_of_commands(of, asks, killed_clients),
        *_of_asks(asks, of, killed_clients),
        *(
            f"loss of the {line['node']} was detected only after {after_ns / 1e6:.0f} ms"
            for line, after_ns in zip(of["noticed"], noticed, strict=True)
            if after_ns > NOTICED_NS
        ),
        *_of_the_end(of),
    ]
    codes = Counter(ask.code for ask in asks.values())
    counts = {
        "kills": len(of["kill"]),
        "hangs": len(of["hang"]),
        "sentences asked": len(asks),
        "done": codes[0],
        "ended with a reason": codes[2],
        "killed while asking": codes[None],
        "commands accepted": len(of["accepted"]),
        "carried out": len(of["moved"]),
        "stopped": len(of["stopped"]),
        "came too late": len(of[TOO_LATE]),
        "nodes that exited on their own": len(_early_ends(of)),
    }
    times = tuple(after_ns / 1e6 for after_ns in noticed)
    return ChaosVerdict(tuple(faults), counts, times, tuple(_told_ms(of, asks)))


TOO_LATE = "came too late"
"""The kind of line for a command that reached the controller too late."""
_KINDS = (
    "started",
    "kill",
    "hang",
    "goes on",
    "noticed",
    "ended",
    "ask",
    "said",
    "answered",
    "accepted",
    "moved",
    "stopped",
    TOO_LATE,
    "recovered",
    "left",
)


def _asks(lines: Iterable[Line]) -> dict[int, _Ask]:
    asks: dict[int, _Ask] = {}
    for line in lines:
        match line["what"]:
            case "ask":
                asks[line["ask"]] = _Ask(line["t"])
            case "said":
                asks[line["ask"]].events.append({**line["event"], "t": line["t"]})
            case "answered":
                asks[line["ask"]].ends.append(line)
            case _:
                pass
    return asks


def _command(line: Line) -> Command:
    return line["plan"], line["command"]


def _of_commands(
    of: Mapping[str, list[Line]], asks: Mapping[int, _Ask], killed_clients: int
) -> Iterable[str]:
    accepted = {_command(line): line for line in of["accepted"]}
    moved = Counter(_command(line) for line in of["moved"])
    stopped = {_command(line) for line in of["stopped"]}
    late = {_command(line) for line in of[TOO_LATE]}
    if len(accepted) != len(of["accepted"]):
        yield "a command was accepted twice"
    for command, times in moved.items():
        if times > 1:
            yield f"command {command} was carried out {times} times"
        if command not in accepted:
            yield f"command {command} was carried out but not accepted"
        if command in stopped:
            yield f"command {command} was stopped and carried out"
    for command in late & set(accepted):
        yield f"command {command} came too late but was accepted"
    dead = {line["process"] for line in of["kill"]}
    by_plan = {ask.plan: ask for ask in asks.values() if ask.plan is not None}
    unclaimed = set()
    for command, line in accepted.items():
        if command in moved or command in stopped:
            continue
        if line["pid"] not in dead:
            yield f"command {command} was accepted, but its live controller did nothing"
        ask = by_plan.get(command[0])
        if ask is None:
            unclaimed.add(command[0])
        elif ask.code == 0:
            yield f"command {command} was not carried out, but its sentence was reported done"
    lost = sum(ask.why in (PLANNER_LOST, REPLY_LOST) for ask in asks.values() if ask.ends)
    if len(unclaimed) > killed_clients + lost:
        yield f"{len(unclaimed)} plans were not carried out, and no client was told"


def _of_asks(
    asks: Mapping[int, _Ask], of: Mapping[str, list[Line]], killed_clients: int
) -> Iterable[str]:
    moves = Counter(line["plan"] for line in of["moved"])
    if sum(ask.code is None for ask in asks.values()) > killed_clients:
        yield "more clients were ended by a signal than were killed"
    for number, ask in asks.items():
        if len(ask.ends) != 1:
            yield f"sentence {number} has {len(ask.ends)} ends"
            continue
        numbers = [event["number"] for event in ask.events if "number" in event]
        if numbers != list(range(1, len(numbers) + 1)):
            yield f"sentence {number}: replies {numbers}"
        kinds = [event.get("event") for event in ask.events]
        message = ask.ends[0]["message"]
        if ask.code == 0:
            planned = [event for event in ask.events if event.get("event") == "planned"]
            steps = len(planned[0]["steps"]) if planned else 0
            reached = {event["step"] for event in ask.events if event.get("event") == "reached"}
            if not steps or kinds[-1] != "done" or reached != set(range(steps)):
                yield f"sentence {number} was reported done after {kinds}"
            if moves[ask.plan] < steps:
                done = f"{moves[ask.plan]} of {steps} steps"
                yield f"sentence {number} was reported done after {done}"
        elif ask.code == 2:
            reasons = [event for event in ask.events if "reason" in event or "error" in event]
            if not message or not reasons:
                yield f"sentence {number} ended without a reason"
        elif ask.code is not None:
            yield f"sentence {number} ended with code {ask.code}: {message}"


def _early_ends(of: Mapping[str, list[Line]]) -> list[Line]:
    last_ask = max((line["t"] for line in of["ask"]), default=0)
    return [line for line in of["ended"] if line["t"] < last_ask]


def _of_the_end(of: Mapping[str, list[Line]]) -> Iterable[str]:
    if not of["recovered"] or not of["recovered"][-1]["done"]:
        yield "no sentence was carried out at the end"
    early = _early_ends(of)
    for line in early:
        yield f"the {line['node']} exited on its own with code {line['code']}"
    late = [line for line in of["ended"] if line not in early]
    if not late:
        yield "no node was stopped at the end"
    for line in late:
        if line["code"] != 0:
            yield f"the {line['node']} was told to exit and ended with code {line['code']}"
    if not of["left"]:
        yield "there was no check for what was left behind"
    for line in of["left"]:
        if line["names"]:
            yield f"left behind: {line['names']}"


def _told_ms(of: Mapping[str, list[Line]], asks: Mapping[int, _Ask]) -> Iterable[float]:
    """Times from the death of a planner or controller to the end of the sentence under way."""
    whys = {"planner": PLANNER_LOST, "controller": CONTROLLER_LOST}
    for line in of["kill"]:
        why = whys.get(line["node"])
        for ask in asks.values():
            if why is None or not ask.ends or ask.why != why:
                continue
            begun = [event["t"] for event in ask.events if event.get("event") == "commanded"]
            if begun and begun[-1] < line["t"] < ask.ends[0]["t"]:
                yield (ask.ends[0]["t"] - line["t"]) / 1e6
                break
