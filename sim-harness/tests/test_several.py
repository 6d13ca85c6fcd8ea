"""Several objects that are moved, "all red blocks": said, read, and true of a scene's blocks."""

from __future__ import annotations

import numpy as np
import pytest
from one_step_episodes import truths_of

from nsrm_harness import domain as domains
from nsrm_harness.data.ground_truth import Truth
from nsrm_harness.data.several import MOST_MOVED, has_stack, several_programs, with_several
from nsrm_harness.domain import GROUP_TOKEN
from nsrm_harness.domain.everyday import Speaker, with_everyday
from nsrm_harness.domain.program import ALL, BOTH, Relation, Step
from nsrm_harness.domain.recogniser import Recogniser
from nsrm_harness.domain.tokens import Tokenizer, UnknownWordError

DOMAIN = with_everyday(domains.load(domains.FOUR_SIDES))


@pytest.fixture(scope="module")
def truths(tmp_path_factory: pytest.TempPathFactory) -> list[Truth]:
    path = tmp_path_factory.mktemp("several") / "validation.h5"
    return truths_of(path, count=16, seed=3)


def test_several_objects_are_one_group_and_their_plurals_singulars() -> None:
    tokenizer = Tokenizer(DOMAIN)
    group = GROUP_TOKEN
    for said, read in (
        ("all the red blocks", [group, "block"]),
        ("all of the red blocks", [group, "block"]),
        ("both small ones", [group, "one"]),
        ("every block", [group, "block"]),
        ("all blocks", [group, "block"]),
        ("take all red blocks and put them", ["take", group, "block", "and", "put", "it"]),
        # Another word, too.
        ("all right , put red", ["all", "right", ",", "put", group]),
        ("first of all put", ["first", "of", "all", "put"]),
        # Behind the values, these are words like any other.
        ("all red of the", [group, "of", "the"]),
    ):
        assert list(tokenizer(said).words) == read, said
    for said in ("the red blocks", "all red on the blue blocks", "put them"):
        with pytest.raises(UnknownWordError):
            tokenizer(said)


def test_several_objects_are_said_in_many_ways() -> None:
    rng = np.random.default_rng(2)
    speaker, tokenizer, recogniser = Speaker(DOMAIN, rng), Tokenizer(DOMAIN), Recogniser.of(DOMAIN)
    several = DOMAIN.several
    assert several is not None
    used = set[str]()
    related = Relation("MoveLeft", ("white",))
    for step, groups in (
        (Step("MoveOn", ("red",), ("blue",), object_which=ALL), 2),
        (Step("MoveLeft", (), ("blue",), object_which=ALL), 2),
        (Step("MoveOn", ("small", "red"), ("blue",), object_which=BOTH), 2),
        (Step("MoveOn", ("red",), ("blue",), (related,), object_which=BOTH), 3),
    ):
        for _ in range(150):
            words = speaker.sentence((step,))
            tokens = tokenizer(" ".join(words))
            assert len(tokens.groups) == groups, " ".join(words)
            if not step.object_relations:
                assert recogniser.step(tokens.words), " ".join(words)
            used.update(words)
    assert {*several.all, *several.every, *several.both, *several.between} <= used
    nouns = {plural for plural, singular in several.plurals.items() if singular in used}
    assert len(nouns & used) > 8 and "them" not in used


def fitting(truth: Truth, step: Step) -> list[int]:
    return [
        number
        for number, values in enumerate(truth.attributes, start=1)
        if {*step.object} <= {*values.values()}
    ]


def test_programs_move_all_that_fit_but_the_reference(truths: list[Truth]) -> None:
    rng = np.random.default_rng(1)
    counts = {ALL: 0, BOTH: 0, "refused": 0, "stacks": 0}
    for truth in truths:
        true, untrue = several_programs(DOMAIN, truth, rng, 20)
        is_stacked = any(pose.position[2] > 0.055 for pose in truth.initial_poses)
        assert has_stack(truth) == is_stacked
        counts["stacks"] += is_stacked
        for each in true:
            (step,) = each.program
            others = [number for number in fitting(truth, step) if number != each.reference]
            assert list(each.moved) == others and 1 < len(others) <= MOST_MOVED
            assert step.object_which is not None
            counts[step.object_which] += 1
            assert step.object_which == ALL or len(others) == 2
            values = truth.attributes[each.reference - 1].values()
            assert {*step.reference} <= {*values}
        for each in untrue:
            (step,) = each.program
            others = [number for number in fitting(truth, step) if number != each.reference]
            assert not others or (step.object_which == BOTH and len(others) != 2)
            counts["refused"] += 1
    assert min(counts.values()) > 3, counts


def test_one_step_of_a_program_moves_several_or_has_several_references() -> None:
    rng = np.random.default_rng(4)
    program = (Step("MoveOn", ("red", "small"), ("blue",)), Step("MoveLeft", ("cyan",), ("white",)))
    for _ in range(50):
        true, untrue = with_several(program, rng)
        (at,) = [index for index, step in enumerate(true) if step.object_which is not None]
        assert untrue[at].reference_which == true[at].object_which
        assert {*true[at].object} <= {*program[at].object}
        assert true[1 - at] == untrue[1 - at] == program[1 - at]
        assert all(step.reference_which is None for step in true)
