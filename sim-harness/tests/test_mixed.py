"""Programs that mix all kinds of descriptions."""

from __future__ import annotations

import numpy as np
import pytest

from nsrm_harness import domain as domains
from nsrm_harness.data.mixed import ON, MixedPrograms
from nsrm_harness.domain.everyday import PRONOUN, with_everyday
from nsrm_harness.domain.program import Step
from nsrm_harness.evaluation import language
from nsrm_harness.evaluation.language import MIXED_STEPS, say_mixed

DOMAIN = with_everyday(domains.load(domains.FOUR_SIDES))


def test_programs_mix_all_kinds_of_descriptions() -> None:
    programs = MixedPrograms(DOMAIN, np.random.default_rng(2))
    kinds = set[str]()
    for _ in range(200):
        said, meant = programs.draw(3)
        assert len(said) == len(meant) == 3
        for before, spoken, plain in zip((None, *meant[:-1]), said, meant, strict=True):
            kinds |= kinds_of(spoken)
            if PRONOUN in (*spoken.object, *spoken.reference):
                assert before is not None
                assert not before.object_relations and before.object_which is None
                argument = "object" if PRONOUN in spoken.object else "reference"
                assert getattr(plain, argument) == before.object
            else:
                assert spoken == plain
            relations = [each.name for each in plain.reference_relations]
            assert plain.action == ON or ON not in relations
    assert kinds == {"plain", "relation", "bare relation", "extreme", "pronoun"}


def kinds_of(step: Step) -> set[str]:
    """The kinds of descriptions of a step."""
    kinds = set[str]()
    for concepts, relations, which in (
        (step.object, step.object_relations, step.object_which),
        (step.reference, step.reference_relations, step.reference_which),
    ):
        if PRONOUN in concepts:
            kinds.add("pronoun")
        elif relations:
            kinds.add("relation" if concepts else "bare relation")
        else:
            kinds.add("plain" if which is None else "extreme")
    return kinds


def test_the_actions_are_the_domains() -> None:
    programs = MixedPrograms(with_everyday(domains.load()), np.random.default_rng(2))
    assert {step.action for step in programs.draw(30)[0]} == {"MoveOn", "MoveRight", "MoveLeft"}


def test_mixed_programs_are_said_in_each_number_of_steps(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(language, "MIXED_COUNT", 40)
    sets = say_mixed(DOMAIN, 0)
    assert list(sets) == ["mixed; 1 step", *(f"mixed; {n} steps" for n in MIXED_STEPS[1:])]
    for steps, sentences in zip(MIXED_STEPS, sets.values(), strict=True):
        assert 36 <= len(sentences) <= 40
        assert all(program is not None and len(program) == steps for _, program in sentences)
