"""A robot's controller: executes each command once and in time, and reports the outcome."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import NamedTuple

from nsrm_harness.nodes.messages import MAX_STEPS, Kind, Outcome, SubGoal

UNIT_TOLERANCE = 1e-3
"""Largest deviation from 1 of an orientation's squared length."""


class Answer(NamedTuple):
    """The outcome of a command; `objects`: obstacles, or objects that are moved aside."""

    outcome: Outcome
    objects: tuple[int, ...] = ()


Say = Callable[[int, int, Answer], None]
"""Takes plan, command and outcome."""
Reject = Callable[[str, str], None]
"""Takes the service and the reason why a message is rejected."""
Tell = Callable[[Answer], None]
"""Takes intermediate outcomes."""
Mover = Callable[[SubGoal, Tell], Answer]
"""Moves the object of a command to its target."""


@dataclass(frozen=True)
class _Done:
    plan: int
    command: int
    answer: Answer


def fault(command: SubGoal) -> str | None:
    """Why a command is invalid, by the rules of `SubGoal::read` in Rust; None if it is valid."""
    if command.command == 0:
        return "command 0; commands are numbered from 1"
    if command.kind == Kind.STOP:
        return None
    if command.kind != Kind.MOVE:
        return f"unknown kind {command.kind}"
    if command.step >= command.steps or command.steps > MAX_STEPS:
        return f"step {command.step} of {command.steps}"
    if not command.object_id or not command.reference_id:
        return "object 0"
    if command.object_id == command.reference_id:
        return f"object {command.object_id} is its own reference"
    numbers = (*command.position, *command.orientation, *command.location, command.confidence)
    if not all(math.isfinite(number) for number in numbers):
        return "a number is not finite"
    if abs(sum(part * part for part in command.orientation) - 1.0) > UNIT_TOLERANCE:
        return "the orientation does not have length 1"
    if not 0.0 <= command.confidence <= 1.0:
        return f"a confidence of {command.confidence}"
    return None


def stops_first(commands: Iterable[SubGoal]) -> list[SubGoal]:
    """All waiting commands in order, but stops before moves: a delayed controller must not start a
    move that is no longer wanted."""
    return sorted(commands, key=lambda command: command.kind != Kind.STOP)


class Controller:
    """Executes each command once, and none after its time; a repeated command gets the same answer.

    * `mover`: moves an object to its sub-goal
    * `reject`: called with the reason if a command is invalid or too late
    * `clock`: the time, nanoseconds
    """

    def __init__(self, mover: Mover, say: Say, reject: Reject, clock: Callable[[], int]) -> None:
        self._mover, self._say, self._reject, self._clock = mover, say, reject, clock
        self._last = _Done(0, 0, Answer(Outcome.IMPOSSIBLE))
        self._current: tuple[int, int] | None = None

    def is_stopped_by(self, commands: Iterable[SubGoal]) -> bool:
        """Whether one of these waiting commands stops the current one."""
        return any(
            command.kind == Kind.STOP and (command.plan, command.command) == self._current
            for command in commands
        )

    def obey(self, command: SubGoal) -> None:
        """Executes a command, or answers why not."""
        plan, number = command.plan, command.command
        why = fault(command)
        if why is not None:
            # Its numbers do not count: later commands may have lower ones.
            self._reject("sub_goal", why)
            if number > 0:
                self._say(plan, number, Answer(Outcome.IMPOSSIBLE))
            return
        if (plan, number) == (self._last.plan, self._last.command):
            # A repeated command, whose end is known. A stop for it is too late.
            self._say(plan, number, self._last.answer)
            return
        if (plan, number) < (self._last.plan, self._last.command):
            self._say(plan, number, Answer(Outcome.IMPOSSIBLE))
            return
        late_ns = self._clock() - command.until_ns
        answer = Answer(Outcome.STOPPED)
        if command.kind == Kind.MOVE and late_ns > 0:
            self._reject("sub_goal", f"{late_ns // 1_000_000} ms after its time")
            answer = Answer(Outcome.TOO_LATE)
        elif command.kind == Kind.MOVE:
            self._say(plan, number, Answer(Outcome.ACCEPTED))
            self._current = plan, number
            answer = self._mover(command, lambda answer: self._say(plan, number, answer))
            self._current = None
        self._last = _Done(plan, number, answer)
        self._say(plan, number, answer)
