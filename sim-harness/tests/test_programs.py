"""Drawing random scenes and programs."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from nsrm_harness import domain as domains
from nsrm_harness.common.errors import EpisodeSettingsError
from nsrm_harness.data.generate import SPLITS
from nsrm_harness.data.moves import Arrangement
from nsrm_harness.data.programs import (
    SHARES,
    SHARES_OF,
    Descriptions,
    Task,
    sample_blocks,
    sample_task,
    share,
    unique_descriptions,
)
from nsrm_harness.data.seeds import STREAMS, generator
from nsrm_harness.domain.program import Step
from nsrm_harness.simulation.blocks import Block, block_from_attributes
from nsrm_harness.simulation.layout import sample_layout

TABLETOP = domains.load()
WORKSHOP = domains.load(Path(__file__).parent / "domains" / "workshop.toml")


def draw(
    domain: domains.Domain,
    index: int,
    steps: int,
    descriptions: Descriptions,
    shares: tuple[int, ...] | None = None,
    about: tuple[int, ...] = (),
) -> tuple[Arrangement, Task | None]:
    rng = np.random.default_rng([41, index])
    blocks = sample_blocks(rng, domain, 5)
    arrangement = Arrangement.on_table(blocks, sample_layout(rng, blocks))
    task = sample_task(rng, domain, arrangement, steps, descriptions, shares, about=about)
    return arrangement, task


@pytest.mark.parametrize("domain", [TABLETOP, WORKSHOP], ids=["tabletop", "workshop"])
def test_programs_name_one_block_each_and_can_be_carried_out(domain: domains.Domain) -> None:
    drawn = 0
    for index in range(60):
        arrangement, task = draw(domain, index, 1 + index % 3, Descriptions(1, 2))
        if task is None:
            continue
        drawn += 1
        assert len(task.program) == len(task.moves) == 1 + index % 3
        for step, move in zip(task.program, task.moves, strict=True):
            assert arrangement.allowed(move)
            assert step.action == move.action.name
            for words, meant in ((step.object, move.moved), (step.reference, move.reference)):
                fitting = [
                    number
                    for number, block in enumerate(arrangement.blocks)
                    if set(words) <= set(block.values.values())
                ]
                assert fitting == [meant]
                assert 1 <= len(words) <= 2
            arrangement = arrangement.after(move)
    assert drawn > 30


def test_the_first_step_is_about_a_wanted_block_where_it_can_be() -> None:
    drawn, exceptions = 0, 0
    for index in range(60):
        arrangement, task = draw(TABLETOP, index, 1 + index % 2, Descriptions(2, 2), about=(3,))
        if task is None:
            continue
        drawn += 1
        described = unique_descriptions(TABLETOP, arrangement.blocks, Descriptions(2, 2))
        among = [block for block, kinds in enumerate(described) if kinds]
        possible = arrangement.moves(TABLETOP, among)
        can_be = any(3 in (move.moved, move.reference) for move in possible)
        assert (3 in (task.moves[0].moved, task.moves[0].reference)) == can_be
        exceptions += not can_be
    assert drawn > 30
    assert exceptions > 0, "no scene in which it cannot be"


def test_a_block_is_moved_twice_only_where_nothing_else_can_be() -> None:
    again = 0
    for index in range(40):
        _, task = draw(TABLETOP, index, 2, Descriptions(1, 2))
        if task is not None:
            again += task.moves[0].moved == task.moves[1].moved
    assert again <= 1


@pytest.mark.parametrize("size", [1, 2])
def test_descriptions_have_the_number_of_values_asked_for(size: int) -> None:
    for index in range(20):
        _, task = draw(TABLETOP, index, 1, Descriptions(size, size))
        if task is not None:
            step = task.program[0]
            assert len(step.object) == len(step.reference) == size


def test_one_step_programs_are_shared_between_no_two_splits() -> None:
    shares = [set(own) for own in SHARES_OF.values()]
    assert sorted(number for own in shares for number in own) == list(range(SHARES))
    for name, own in SHARES_OF.items():
        for index in range(15):
            _, task = draw(TABLETOP, index, 1, Descriptions(1, 2), own)
            assert task is None or share(task.program) in own, name


def test_shares_do_not_depend_on_the_order_of_filters_and_are_about_equal() -> None:
    counts = Counter[int]()
    for action in TABLETOP.actions:
        for color in TABLETOP.attribute("color").values:
            for other in TABLETOP.attribute("color").values:
                step = Step(action.name, (color.name, "small"), (other.name,))
                turned = Step(action.name, ("small", color.name), (other.name,))
                assert share((step,)) == share((turned,))
                counts[share((step,))] += 1
    assert set(counts) == set(range(SHARES))
    assert max(counts.values()) < 2 * min(counts.values()), counts


def test_shares_stay_what_they_were() -> None:
    """A change here would mix test programs into files made before."""
    programs = [(Step(action.name, ("red",), ("blue",)),) for action in TABLETOP.actions]
    assert [share(program) for program in programs] == [1, 1, 4]


def test_unique_descriptions_of_a_scene() -> None:
    def block(color: str, size: str) -> Block:
        return block_from_attributes(TABLETOP, {"color": color, "size": size})

    blocks = [block("red", "small"), block("red", "lego"), block("blue", "small")]
    assert unique_descriptions(TABLETOP, blocks, Descriptions(1, 2)) == [
        {("color", "size"): ("red", "small")},
        {("size",): ("lego",), ("color", "size"): ("red", "lego")},
        {("color",): ("blue",), ("color", "size"): ("blue", "small")},
    ]


def test_excluded_combinations_do_not_occur() -> None:
    pair = frozenset({"small", "green"})
    rng = np.random.default_rng(8)
    seen = Counter[bool]()
    for _ in range(100):
        for block in sample_blocks(rng, TABLETOP, 5, [pair]):
            values = set(block.values.values())
            assert not pair <= values
            seen[bool(pair & values)] += 1
    assert seen[True] > 100, "each alone still occurs"
    with pytest.raises(EpisodeSettingsError, match="excluded"):
        sample_blocks(rng, TABLETOP, 5, [frozenset({"small"}), frozenset({"lego"})])


def test_streams_and_indices_have_their_own_draws() -> None:
    assert len(set(STREAMS.values())) == len(STREAMS)
    assert STREAMS.keys() >= SPLITS.keys()
    draws = {
        tuple(generator(seed, stream, index).integers(2**60, size=3))
        for seed in (0, 1)
        for stream in STREAMS
        for index in (0, 1)
    }
    assert len(draws) == 4 * len(STREAMS)
