"""Sentences that must be refused: how they are made, counted and drawn."""

from __future__ import annotations

import csv
import json
from itertools import pairwise
from pathlib import Path

import nsrm
import numpy as np
import pytest
from harness_command import run

from nsrm_harness import domain as domains
from nsrm_harness.data.moves import Arrangement
from nsrm_harness.data.programs import Descriptions, sample_blocks, sample_task
from nsrm_harness.domain import Domain
from nsrm_harness.domain.grammar import Grammar
from nsrm_harness.domain.patterns import is_reserved
from nsrm_harness.domain.program import Step
from nsrm_harness.domain.tokens import Tokenizer, UnknownWordError, split
from nsrm_harness.evaluation.refusals import topics
from nsrm_harness.evaluation.refusals.certainty import bins, calibration_error, risk_curve
from nsrm_harness.evaluation.refusals.measure import (
    COLUMNS,
    GOOD,
    RefusalReport,
    SentenceResult,
    report,
)
from nsrm_harness.evaluation.refusals.plot import draw_report
from nsrm_harness.evaluation.refusals.reading import Reading
from nsrm_harness.evaluation.refusals.sentences import (
    SETS,
    Item,
    RefusalSetError,
    make_items,
    set_of,
)
from nsrm_harness.evaluation.refusals.spoiler import (
    KINDS,
    OF_ORDER_WORDS,
    OF_PLAIN_DESCRIPTIONS,
    Situation,
)
from nsrm_harness.simulation.layout import sample_layout

TABLETOP = domains.load()
WORKSHOP = domains.load(Path(__file__).parent / "domains" / "workshop.toml")
PRETRAINED = Path(__file__).parents[2] / "weights-codegen/tabletop/tabletop.safetensors"
COUNT = 12


def make_situations(domain: Domain, count: int = 60) -> list[Situation]:
    """Scenes with programs of one and two steps."""
    situations: list[Situation] = []
    for index in range(4 * count):
        rng = np.random.default_rng([17, index])
        blocks = sample_blocks(rng, domain, 5)
        arrangement = Arrangement.on_table(blocks, sample_layout(rng, blocks))
        task = sample_task(rng, domain, arrangement, 1 + index % 2, Descriptions(1, 2))
        if task is not None:
            attributes = tuple(block.values for block in blocks)
            situations.append(Situation(len(situations), attributes, task.program))
    return situations[:count]


SITUATIONS = make_situations(TABLETOP)
ITEMS = {which: make_items(TABLETOP, SITUATIONS, which, COUNT) for which in SETS}


def of_kind(kind: str) -> list[Item]:
    """Those of both sets."""
    return [item for which in SETS for item in ITEMS[which] if item.kind == kind]


def groups(item: Item) -> list[list[int]]:
    """For each description of a sentence, the blocks that it fits."""
    tokens = Tokenizer(TABLETOP)(item.sentence)
    names = [[TABLETOP.concepts[index].name for index in group] for group in tokens.groups]
    return [SITUATIONS[item.scene].fitting(each) for each in names]


@pytest.mark.parametrize("domain", [TABLETOP, WORKSHOP], ids=["tabletop", "workshop"])
def test_each_kind_has_as_many_different_sentences_as_asked_for(domain: Domain) -> None:
    situations = make_situations(domain)
    items = make_items(domain, situations, "test", COUNT)
    assert items == make_items(domain, situations, "test", COUNT)
    assert items != make_items(domain, situations, "test", COUNT, seed=1)
    reads = Reading(domain)
    # What good sentences are made of, and still say no command.
    misused = {"relation_in_description", "two_relations", "two_values", *OF_ORDER_WORDS}
    good_elsewhere = {"absent_object", "ambiguous", "too_many_steps", "same_object"}
    for kind in KINDS:
        own = [item for item in items if item.kind == kind]
        if kind in OF_ORDER_WORDS and not domain.grammar.order_words:
            assert own == []
            continue
        assert len({tuple(split(item.sentence)) for item in own}) == len(own) == COUNT, kind
        assert all(0 <= item.scene < len(situations) for item in own)
        if kind not in misused | good_elsewhere:
            for item in own:
                assert not reads(item.sentence), (kind, item.sentence)


def test_no_sentence_is_in_both_sets() -> None:
    spoken = {which: {tuple(split(item.sentence)) for item in ITEMS[which]} for which in SETS}
    assert not spoken["validation"] & spoken["test"]
    assert set_of("Put the red block.") == set_of("put THE red block") in SETS


def test_scenes_that_do_not_allow_a_kind_are_told() -> None:
    step = Step("MoveOn", ("red",), ("blue",))
    plain = ({"color": "red", "size": "lego"}, {"color": "blue", "size": "small"})
    with pytest.raises(RefusalSetError, match="ambiguous: 0 of 2 sentences found in 1 scenes"):
        make_items(TABLETOP, [Situation(0, plain, (step,))], "test", 2)


def test_one_word_is_unknown_and_a_misspelling_is_one_edit_away() -> None:
    known = {*TABLETOP.lexicon(), *TABLETOP.vocabulary()}
    for kind in ("unknown_word", "misspelt"):
        for item in of_kind(kind):
            (word,) = [word for word in split(item.sentence) if word not in known]
            if kind == "misspelt":
                assert item.meant in known
                assert abs(len(word) - len(item.meant or "")) <= 1
            else:
                assert item.meant is None
            with pytest.raises(UnknownWordError):
                Tokenizer(TABLETOP)(item.sentence)


def test_what_is_left_out_is_missing() -> None:
    count = {item: len(SITUATIONS[item.scene].program) for item in of_kind("incomplete")}
    for item, steps in count.items():
        assert len(groups(item)) < 2 * steps, item.sentence
    relations = {word for action in TABLETOP.actions for p in action.phrases for word in p.split()}
    relations -= {"the", "side"}
    for kind in ("no_action", "no_reference"):
        for item in of_kind(kind):
            if len(SITUATIONS[item.scene].program) == 1:
                assert not relations & set(split(item.sentence)), item.sentence
    for item in of_kind("no_reference"):
        assert len(groups(item)) == 2 * len(SITUATIONS[item.scene].program) - 1


def test_descriptions_are_wrong_in_the_scene_as_their_kind_says() -> None:
    for item in of_kind("absent_object"):
        assert sum(not fitting for fitting in groups(item)) == 1, item.sentence
    for item in of_kind("ambiguous"):
        assert any(len(fitting) > 1 for fitting in groups(item)), item.sentence
    for item in of_kind("same_object"):
        fitting = groups(item)
        pairs = zip(fitting[::2], fitting[1::2], strict=True)
        assert any(left == right and len(left) == 1 for left, right in pairs), item.sentence
    for item in of_kind("too_many_steps"):
        assert len(groups(item)) >= 18
        assert Reading(TABLETOP)(item.sentence)


def test_what_no_program_has_is_said_in_words_of_good_sentences() -> None:
    lexicon, tokenizer = TABLETOP.lexicon(), Tokenizer(TABLETOP)
    phrases = {phrase for action in TABLETOP.actions for phrase in action.phrases}
    for kind in ("relation_in_description", "relation_behind_description"):
        for item in of_kind(kind):
            steps = len(SITUATIONS[item.scene].program)
            described = kind == "relation_behind_description"
            assert len(groups(item)) == 2 * steps + described, item.sentence
            text = f" {' '.join(split(item.sentence))} "
            assert sum(text.count(f" {phrase} ") for phrase in phrases) > steps, item.sentence
    for item in of_kind("two_relations"):
        assert len(groups(item)) == 2 * len(SITUATIONS[item.scene].program), item.sentence
    for item in of_kind("ordinal"):
        words = split(item.sentence)
        assert ("first", True) in {(a, b in lexicon) for a, b in pairwise(words)}, item.sentence
    for item in of_kind("order_of_time"):
        words = split(item.sentence)
        assert "first" in words[1:] and len(SITUATIONS[item.scene].program) > 1, item.sentence
    for item in of_kind("two_values"):
        found = [
            TABLETOP.concepts[index].attribute
            for group in tokenizer(item.sentence).groups
            for index in group
        ]
        steps = len(SITUATIONS[item.scene].program)
        assert len(groups(item)) > 2 * steps or len(found) > len(set(found)), item.sentence


def test_patterns_that_training_hears_are_in_no_set() -> None:
    """Of a command alone the sentence has no more tokens than the step that was looked at."""
    tokenizer, seen = Tokenizer(TABLETOP), 0
    for kind in ("relation_in_description", "two_relations", "ordinal"):
        for item in of_kind(kind):
            if len(SITUATIONS[item.scene].program) == 1:
                assert is_reserved(tokenizer.rows(tokenizer(item.sentence))), item.sentence
                seen += 1
    assert seen > COUNT


def test_actions_that_the_domain_has_are_not_missing() -> None:
    phrases = {phrase for action in WORKSHOP.actions for phrase in action.phrases}
    assert "in front of" in phrases & set(topics.RELATIONS)
    items = make_items(WORKSHOP, make_situations(WORKSHOP), "test", 40)
    spoken = [" ".join(split(item.sentence)) for item in items if item.kind == "missing_action"]
    assert any("behind" in text for text in spoken)
    for text in spoken:
        assert sum(f" {phrase} " in f" {text} " for phrase in topics.RELATIONS) >= 1 or (
            topics.BETWEEN in text
        )


def test_other_subjects_are_many_and_different() -> None:
    sentences = list(topics.other_subjects())
    assert len(topics.SENTENCES) >= 100
    assert len({tuple(split(each)) for each in sentences}) == len(sentences)
    for which in SETS:
        assert sum(set_of(each) == which for each in sentences) >= 1000


@pytest.mark.parametrize("domain", [TABLETOP, WORKSHOP], ids=["tabletop", "workshop"])
def test_good_sentences_are_read(domain: Domain) -> None:
    grammar, reads = Grammar(domain), Reading(domain)
    rng = np.random.default_rng(3)
    for situation in make_situations(domain, 30):
        sentence = grammar.sentence(rng, situation.program).text
        assert reads(sentence), sentence


def test_what_has_the_order_of_a_command_is_read() -> None:
    reads = Reading(TABLETOP)
    for sentence in (
        "put red on blue",
        "on white now set the red please",
        "put the block red on the the blue",
        "put the red small block right of the blue, on the red put the green.",
    ):
        assert reads(sentence), sentence
    for sentence in (
        "put the red block the blue block",
        "put the red block",
        "the red block on the blue block",
        "put the red block on the blue block and",
        "put the red block under the blue block",
        "the red put block on the blue block",
        "",
    ):
        assert not reads(sentence), sentence


def test_the_command_of_a_step_is_said_as_before() -> None:
    """Its parts are apart now; a change of the draws would change every episode file."""
    program = (Step("MoveOn", ("red",), ("small", "blue")), Step("MoveLeft", ("red",), ("lego",)))
    grammar = Grammar(TABLETOP)
    commands = grammar.commands(np.random.default_rng(5), program)
    words = [word for command in commands for word in command.words()]
    sentence = grammar.sentence(np.random.default_rng(5), program).text
    assert split(sentence) == words
    assert (commands[0].connective, commands[1].fields["opening"]) == ("", "")


def test_an_action_that_is_not_there_is_never_another_one() -> None:
    model = nsrm.Model.pretrained()
    for relation in ("under", "inside", "between", "beneath", "close to", "against"):
        with pytest.raises(nsrm.Refused) as refused:
            model.parse(f"put the red block {relation} the blue block")
        assert refused.value.kind == "unknown_word"
    for sentence in (
        "don't put the red block on the blue block",
        "never put the red block on the blue block",
        "put the red block not on the blue block",
    ):
        with pytest.raises(nsrm.Refused):
            model.parse(sentence)


def test_bins_have_equal_mass_and_their_error_is_the_mean_distance() -> None:
    parts = bins([0.9, 0.5, 0.6, 0.8], [1, 0, 1, 1], [1, 1, 1, 1], 2)
    assert [part.mass for part in parts] == [0.5, 0.5]
    assert [part.confidence for part in parts] == pytest.approx([0.55, 0.85])
    assert [part.right for part in parts] == [0.5, 1.0]
    assert calibration_error(parts) == pytest.approx(0.5 * 0.05 + 0.5 * 0.15)
    (heavy, light) = bins([0.5, 0.9, 1.0], [0, 1, 0], [2, 1, 1], 2)
    assert (heavy.mass, heavy.right, light.right) == (0.5, 0.0, 0.5)
    assert bins([], [], []) == [] and calibration_error([]) == 0.0


def test_risk_by_hand() -> None:
    nan = float("nan")
    curve = risk_curve([0.9, nan, 0.8, 0.8, 0.4], [1, 0, 0, 1, 0], [1, 1, 1, 1, 1])
    assert curve.thresholds.tolist() == [0.9, 0.8, 0.4]
    assert curve.coverage == pytest.approx([0.2, 0.6, 0.8])
    assert curve.risk == pytest.approx([0.0, 1 / 3, 0.5])
    assert curve.at(0.95) == (0.0, 0.0)
    assert curve.at(0.8) == pytest.approx((0.6, 1 / 3))
    assert curve.at(0.0) == pytest.approx((0.8, 0.5))
    weighted = risk_curve([0.9, 0.8], [1, 0], [3, 1])
    assert weighted.risk == pytest.approx([0.0, 0.25])
    assert risk_curve([nan], [0], [1]).at(0.0) == (0.0, 0.0)


def small_report() -> RefusalReport:
    """Three good sentences, one refused; four bad ones, one accepted."""
    outcomes = [
        SentenceResult(GOOD, 0, "a", None, 0.99, "…", True),
        SentenceResult(GOOD, 1, "b", None, 0.9, "…", False),
        SentenceResult(GOOD, 2, "c", "ambiguous"),
        SentenceResult("no_action", 0, "d", "unsure"),
        SentenceResult("no_action", 1, "e", None, 0.95, "…"),
        SentenceResult("misspelt", 1, "f", "unknown_word", suggestion="red"),
        SentenceResult("misspelt", 2, "g", "unknown_word"),
    ]
    return report(outcomes, "test", {"d": None, "e": None, "f": "red", "g": "blue"})


def test_counts_by_hand(tmp_path: Path) -> None:
    counted = small_report()
    kinds = {kind.kind: kind for kind in counted.kinds}
    assert list(kinds) == list(KINDS)
    no_action = kinds["no_action"]
    assert (no_action.count, no_action.refused, no_action.wrongly_accepted) == (2, 1, 1)
    assert no_action.reasons == {"unsure": 1}
    assert [each.sentence for each in no_action.examples] == ["e"]
    assert (counted.good, counted.right, counted.refused) == (3, 1, {"ambiguous": 1})
    assert counted.suggested == 0.5
    # A good sentence weighs 1/3, a bad one 1/4; both halves together 2.
    assert counted.curve.at(0.0) == pytest.approx(
        ((2 / 3 + 1 / 4) / 2, (1 / 3 + 1 / 4) / (2 / 3 + 1 / 4))
    )
    assert "no_action" in str(counted) and "0.9500  e" in str(counted)
    assert json.loads(json.dumps(counted.as_json(), allow_nan=False))["good"]["right"] == 1

    counted.write_csv(tmp_path / "refusals.csv")
    lines = (tmp_path / "refusals.csv").read_text("utf-8").splitlines()
    assert lines[0] == "kind,set,count,refused,wrongly_accepted"
    assert len(lines) == 1 + len(KINDS)
    assert "no_action,test,2,1,1" in lines


def test_the_picture_shows_both_diagrams(tmp_path: Path) -> None:
    from PIL import Image

    draw_report(small_report(), tmp_path / "refusals.png")
    with Image.open(tmp_path / "refusals.png") as image:
        assert image.width > 900
        assert len(image.convert("RGB").getcolors(1 << 24) or []) > 20


@pytest.fixture(scope="module")
def episodes(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A few episodes of the split `test`."""
    path = tmp_path_factory.mktemp("episodes") / "few.h5"
    make = ("--split", "test", "--count", "12", "--jobs", "1", "--renderer", "pybullet")
    assert run("episodes", *make, "--out", path) == 0
    return path


@pytest.mark.slow
def test_the_command_counts_what_the_core_refuses(
    episodes: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    capsys.readouterr()
    options = ("--data", episodes, "--count", "3", "--out", tmp_path)
    assert run("refusals", *options, "--json") == 0
    told = json.loads(capsys.readouterr().out)
    assert told["good"]["count"] == 12
    with (tmp_path / "refusals.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert tuple(rows[0]) == COLUMNS
    for row in rows:
        assert row["set"] == "test"
        # The built-in model understands relations in descriptions.
        count = 0 if row["kind"] in OF_PLAIN_DESCRIPTIONS else 3
        assert int(row["refused"]) + int(row["wrongly_accepted"]) == int(row["count"]) == count
        if row["kind"] in {"unknown_word", "misspelt", "negation", "no_reference"}:
            assert row["wrongly_accepted"] == "0"
    assert (tmp_path / "refusals.png").exists()

    assert run("refusals", *options, "--set", "validation") == 2
    assert "has the split 'test', but the set 'validation'" in capsys.readouterr().err
    assert run("refusals", *options, "--model", tmp_path / "none.safetensors") == 2
    assert "cannot read" in capsys.readouterr().err


@pytest.mark.slow
def test_the_least_confidence_is_found_counted_and_written(
    episodes: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    capsys.readouterr()
    model, written = tmp_path / "model.safetensors", tmp_path / "calibrated.safetensors"
    model.write_bytes(nsrm.with_confidence(PRETRAINED.read_bytes(), 1.0))
    options = ("--validation", episodes, "--also", episodes, "--count", "2", "--model", model)
    options = (*options, "--out", tmp_path, "--json")
    # Of 12 accepted plans, none wrong, at least half are right; not all but a thousandth.
    assert run("calibrate", *options) == 2
    error = capsys.readouterr().err
    assert "accepted plans are too few for this limit" in error and str(episodes) in error
    assert run("calibrate", *options, "--risk", "0.5", "--write", written) == 0
    told = json.loads(capsys.readouterr().out)
    # Refused by the calibration before, and judged all the same.
    assert told["thresholds"][0]["accepted"] >= 11
    names = ["test", "test, near misses"]
    assert [row["set"] for row in told["sets"]] == names * 2
    for row in told["sets"]:
        assert row["wrong"] <= row["accepted"] <= row["sentences"]
    found = nsrm.Model.load(written).info()["thresholds"]["confidence"]
    assert found == pytest.approx(told["confidence"])
    with (tmp_path / "calibration.csv").open(encoding="utf-8") as file:
        assert [row["set"] for row in csv.DictReader(file)] == names * 2
    assert (tmp_path / "calibration.png").exists()
    assert run("calibrate", *options[:-3], "--model", tmp_path / "none.safetensors") == 2
    assert "none.safetensors" in capsys.readouterr().err
    assert run("calibrate", "--validation", episodes, "--write", written) == 2
    assert "--write needs --model" in capsys.readouterr().err
