"""The rows of the trials' table: how their scenes and sentences are drawn."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nsrm_harness.common.errors import HarnessError
from nsrm_harness.data.moves import Arrangement, Move
from nsrm_harness.data.programs import (
    Descriptions,
    Task,
    sample_blocks,
    sample_task,
    unique_descriptions,
)
from nsrm_harness.domain import Domain
from nsrm_harness.domain.grammar import Grammar
from nsrm_harness.domain.program import Step
from nsrm_harness.simulation.layout import LayoutError, sample_layout

BLOCKS = (4, 8)
MAX_TRIES = 500
NAMED_BY = Descriptions(1, 2)


@dataclass(frozen=True)
class TrialRow:
    """A row: episodes of one kind.

    * `goal`: share of episodes that must succeed
    * `steps`: number of steps of the program
    * `is_stack`: each step puts a block on the one moved before
    * `is_control`: the arm is given the true poses and the true sub-goals
    * `is_disturbed`: a fault is injected, which may cause contacts
    """

    name: str
    title: str
    goal: float
    steps: int
    is_stack: bool = False
    is_control: bool = False
    is_disturbed: bool = False


ROWS = (
    TrialRow("steps_1", "one step", 0.99, 1),
    TrialRow("steps_2", "two steps", 0.98, 2),
    TrialRow("steps_3", "three steps", 0.97, 3),
    TrialRow("steps_5", "five steps", 0.95, 5),
    TrialRow("stack_3", "stacks of three", 0.99, 2, is_stack=True),
    TrialRow("stack_4", "stacks of four", 0.97, 3, is_stack=True),
    TrialRow("control", "three steps, true poses and sub-goals", 0.998, 3, is_control=True),
)


@dataclass(frozen=True)
class Drawn:
    """A scene, a sentence, and its meaning."""

    arrangement: Arrangement
    task: Task
    sentence: str


def draw(row: TrialRow, rng: np.random.Generator, domain: Domain) -> Drawn:
    """Draws one episode of a row."""
    for _ in range(MAX_TRIES):
        blocks = sample_blocks(rng, domain, int(rng.integers(BLOCKS[0], BLOCKS[1] + 1)))
        try:
            arrangement = Arrangement.on_table(blocks, sample_layout(rng, blocks))
        except LayoutError:
            continue
        if row.is_stack:
            task = _stack(rng, domain, arrangement, row.steps)
        else:
            task = sample_task(rng, domain, arrangement, row.steps, NAMED_BY)
        if task is not None:
            return Drawn(arrangement, task, Grammar(domain).sentence(rng, task.program).text)
    raise HarnessError(f"{row.name}: no scene with room for its steps after {MAX_TRIES} tries")


def _stack(
    rng: np.random.Generator, domain: Domain, arrangement: Arrangement, steps: int
) -> Task | None:
    """A task in which each block goes on the one moved before; all descriptions are unique."""
    unique = unique_descriptions(domain, arrangement.blocks, NAMED_BY)
    named = [index for index, kinds in enumerate(unique) if kinds]
    action = next(action for action in domain.actions if action.direction is None)
    if len(named) <= steps:
        return None
    order = [int(index) for index in rng.permutation(named)[: steps + 1]]
    words = [list(unique[index].values()) for index in order]
    said = [choices[int(rng.integers(len(choices)))] for choices in words]
    program, moves = [], []
    for number in range(1, steps + 1):
        move = Move(action, order[number], order[number - 1])
        if not arrangement.allowed(move):
            return None
        program.append(Step(action.name, said[number], said[number - 1]))
        moves.append(move)
        arrangement = arrangement.after(move)
    return Task(tuple(program), tuple(moves))
