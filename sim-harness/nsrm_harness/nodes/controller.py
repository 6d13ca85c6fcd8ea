"""A robot's controller: each command once, in time, and word of how it went."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import NamedTuple

from nsrm_harness.nodes.messages import MAX_STEPS, Kind, Outcome, SubGoal

UNIT_TOLERANCE = 1e-3
"""How far from 1 the squared length of an orientation may be."""


class Answer(NamedTuple):
    """How a command goes; `objects`: what stands in its way, or is moved out of it."""

    outcome: Outcome
    objects: tuple[int, ...] = ()


Say = Callable[[int, int, Answer], None]
"""Plan, command and how it goes."""
Reject = Callable[[str, str], None]
"""Service and why what came through it is passed over."""
Tell = Callable[[Answer], None]
"""Is told what goes on before the end."""
Mover = Callable[[SubGoal, Tell], Answer]
"""Moves the object of a command to where it says."""


@dataclass(frozen=True)
class _Done:
    plan: int
    command: int
    answer: Answer


def fault(command: SubGoal) -> str | None:
    """Why a command makes no sense, as `SubGoal::read` has it in Rust; None if it does."""
    if command.command == 0:
        return "command 0; commands count from 1"
    if command.kind == Kind.STOP:
        return None
    if command.kind != Kind.MOVE:
        return f"{command.kind} is no kind"
    if command.step >= command.steps or command.steps > MAX_STEPS:
        return f"step {command.step} of {command.steps}"
    if not command.object_id or not command.reference_id:
        return "object 0"
    if command.object_id == command.reference_id:
        return f"object {command.object_id} in relation to itself"
    numbers = (*command.position, *command.orientation, *command.location, command.confidence)
    if not all(math.isfinite(number) for number in numbers):
        return "a number is not finite"
    if abs(sum(part * part for part in command.orientation) - 1.0) > UNIT_TOLERANCE:
        return "the orientation has not length 1"
    if not 0.0 <= command.confidence <= 1.0:
        return f"a confidence of {command.confidence}"
    return None


def stops_first(commands: Iterable[SubGoal]) -> list[SubGoal]:
    """All that wait, in order, but stops before moves: a controller that was held up must
    not begin with what is no longer wanted."""
    return sorted(commands, key=lambda command: command.kind != Kind.STOP)


class Controller:
    """Carries out each command once, and none after its time; one that comes again gets the
    same answer again.

    * `mover`: moves an object to its sub-goal
    * `reject`: is told why a command makes no sense, or that it comes too late
    * `clock`: the time, nanoseconds
    """

    def __init__(self, mover: Mover, say: Say, reject: Reject, clock: Callable[[], int]) -> None:
        self._mover, self._say, self._reject, self._clock = mover, say, reject, clock
        self._last = _Done(0, 0, Answer(Outcome.IMPOSSIBLE))
        self._current: tuple[int, int] | None = None

    def is_stopped_by(self, commands: Iterable[SubGoal]) -> bool:
        """Whether one of these, which have not been obeyed yet, stops what is being done."""
        return any(
            command.kind == Kind.STOP and (command.plan, command.command) == self._current
            for command in commands
        )

    def obey(self, command: SubGoal) -> None:
        """Carries out a command, or says why not."""
        plan, number = command.plan, command.command
        why = fault(command)
        if why is not None:
            # Its numbers do not count: those of commands to come may be smaller.
            self._reject("sub_goal", why)
            if number > 0:
                self._say(plan, number, Answer(Outcome.IMPOSSIBLE))
            return
        if (plan, number) == (self._last.plan, self._last.command):
            # Again: its end is known. A stop that comes after it comes too late.
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
