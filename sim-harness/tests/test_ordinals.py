"""What is counted from one side: what is said of it, and which block has the number."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from nsrm_harness import domain as domains
from nsrm_harness.data.ground_truth import Truth
from nsrm_harness.data.ordinals import CountedDescriptions, OrdinalSentences
from nsrm_harness.data.relations import Described
from nsrm_harness.domain.everyday import with_everyday
from nsrm_harness.domain.ordinals import ordinals_of
from nsrm_harness.geometry.pose import Pose

DOMAIN = with_everyday(domains.load(domains.FOUR_SIDES))


def test_a_domain_counts_from_the_extremes_that_it_has() -> None:
    table: dict[str, Any] = {
        "counts": [["first"], ["second", "2nd"]],
        "starts": {"MoveLeft": ["{counting}from left"], "MoveOn": ["from above"]},
        "first": {"MoveLeft": ["far left"], "MoveOn": ["on top"]},
        "articles": ["the"],
        "unless": ["of"],
        "rules": {"counting": ["", "counting "]},
    }
    nouns = ["block", "toy block"]
    assert ordinals_of(table, ["MoveLeft"], nouns, "") == {
        "counts": [["first"], ["second", "2nd"]],
        "starts": {"from left": "MoveLeft", "counting from left": "MoveLeft"},
        "first": {"far left": "MoveLeft"},
        "articles": ["the"],
        "nouns": ["block", "toy"],
        "unless": ["of"],
    }
    assert ordinals_of(table, ["MoveRight"], nouns, "") is None
    narrow = with_everyday(domains.load(domains.DEFAULT))
    assert narrow.ordinals is not None
    assert {*narrow.ordinals.starts.values()} == {"MoveOn", "MoveRight", "MoveLeft"}


def test_what_is_counted_is_named_by_its_number_and_extreme() -> None:
    ranked = DOMAIN.ranked()
    assert len(ranked) == 4 * len(DOMAIN.extremes)
    assert ranked["second leftmost"] == ("MoveLeft", 2)
    assert ranked["fifth largest"] == ("Largest", 5)


def test_sentences_say_all_that_can_be_counted() -> None:
    assert DOMAIN.ordinals is not None
    sentences = OrdinalSentences(DOMAIN, np.random.default_rng(3))
    told = [sentences.draw() for _ in range(1500)]
    named = {
        which
        for _, (step, *_) in told
        for which in (step.object_which, step.reference_which)
        if which is not None
    }
    assert named == {*DOMAIN.ranked()}
    firsts = [program[0] for _, program in told]
    for fits in (
        lambda step: step.object_which is not None and not step.object,
        lambda step: step.object_which is not None and len(step.object) == 2,
        lambda step: step.reference_which is not None,
        lambda step: None not in (step.object_which, step.reference_which),
    ):
        assert sum(fits(step) for step in firsts) > 100
    assert sum(len(program) == 2 for _, program in told) > 300
    text = f" {' | '.join(sentence for sentence, _ in told)} "
    starts = {start for start in DOMAIN.ordinals.starts if f" {start} " in text}
    assert len(starts) > 0.9 * len(DOMAIN.ordinals.starts)
    assert "  " not in text and "{" not in text


def test_near_misses_count_nothing() -> None:
    sentences = OrdinalSentences(DOMAIN, np.random.default_rng(4))
    every = " | ".join(sentences.near_miss() for _ in range(500))
    for text in ("of the", "second and third", "from the middle", "do not", "which is the"):
        assert text in every, text
    assert "  " not in every and "{" not in every


def truth(*blocks: tuple[str, float]) -> Truth:
    """Small blocks of these colours on the table, at these places to the right, metres."""
    return cast(
        "Truth",
        SimpleNamespace(
            attributes=[{"color": color, "size": "small"} for color, _ in blocks],
            initial_poses=[Pose.upright(0.5, y, 0.02, 0.0) for _, y in blocks],
        ),
    )


def test_a_block_has_a_number_if_it_is_clearly_apart_from_its_neighbours() -> None:
    scene = truth(("red", 0.0), ("red", -0.1), ("red", -0.2), ("blue", 0.1), ("blue", 0.105))
    described = CountedDescriptions(DOMAIN, scene)
    for block, concepts, which in (
        (1, ("red",), "second leftmost"),
        (1, ("red",), "second rightmost"),
        (0, ("red", "small"), "third leftmost"),
        (0, (), "third leftmost"),
        (1, (), "second leftmost"),
    ):
        assert Described(concepts, (), which) in described.of(block), which
    # The first is the extreme; and of those at the right nobody can tell.
    assert all(each.which != "first leftmost" for each in described.of(2))
    assert Described(("blue",), (), "second leftmost") not in described.of(4)
    misleading = described.misleading()
    for concepts, which in (
        (("blue",), "second leftmost"),
        (("red",), "fourth leftmost"),
        (("red",), "second largest"),
        ((), "second rightmost"),
    ):
        assert Described(concepts, (), which) in misleading, which
    assert not {*misleading} & {each for block in range(5) for each in described.of(block)}


def test_a_domain_that_counts_nothing_has_no_sentences() -> None:
    with pytest.raises(ValueError, match="counts nothing"):
        OrdinalSentences(domains.load(domains.DEFAULT), np.random.default_rng(0))
