"""Everyday wording: how it is said, recognised, told and learned."""

from __future__ import annotations

import json
import re
import tomllib
from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import equinox as eqx
import jax
import nsrm
import numpy as np
import pytest
from explained_programs import SMALL_BATCHES, programs_of
from harness_command import run

from nsrm_harness import domain as domains
from nsrm_harness.common.errors import DomainError, EpisodeFileError
from nsrm_harness.data.file import Demonstrations
from nsrm_harness.data.generate import SPLITS, generate
from nsrm_harness.data.ground_truth import GroundTruth
from nsrm_harness.data.near_misses import NearMisses
from nsrm_harness.data.tell import never_shown, tell
from nsrm_harness.data.told import Told, read_told, write_told
from nsrm_harness.domain import GROUP_TOKEN
from nsrm_harness.domain.attachment import Attachments
from nsrm_harness.domain.everyday import EVERYDAY, TABLES, Speaker, with_everyday
from nsrm_harness.domain.program import SUPERLATIVES, Program, Relation, Step, canonical
from nsrm_harness.domain.reader import COUNTING
from nsrm_harness.domain.recogniser import Recogniser, with_values_joined
from nsrm_harness.domain.tokens import Tokenizer
from nsrm_harness.evaluation import language
from nsrm_harness.evaluation.metrics import EvaluationError

TABLETOP = domains.load()
DOMAIN = with_everyday(TABLETOP)
#: That of the built-in model.
FOUR_SIDES = with_everyday(domains.load(domains.FOUR_SIDES))
LISTS = Path(__file__).parent / "language"
PRETRAINED = Path(__file__).parents[2] / "weights-codegen/tabletop/tabletop.safetensors"
SETTINGS = replace(SPLITS["validation"], count=12, seed=6, final_image=False, renderer="pybullet")


@pytest.fixture(scope="module")
def episodes(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("told") / "validation.h5"
    assert generate(SETTINGS, TABLETOP, path)
    return path


def random_program(rng: np.random.Generator, steps: int) -> Program:
    def description() -> tuple[str, ...]:
        kinds = rng.permutation(len(DOMAIN.attributes))[: int(rng.integers(1, 3))]
        return tuple(str(rng.choice([v.name for v in DOMAIN.attributes[k].values])) for k in kinds)

    actions = [action.name for action in DOMAIN.actions]
    return tuple(Step(str(rng.choice(actions)), description(), description()) for _ in range(steps))


def test_every_sentence_is_recognised_and_names_its_objects() -> None:
    rng = np.random.default_rng(3)
    speaker, tokenizer, recogniser = Speaker(DOMAIN, rng), Tokenizer(DOMAIN), Recogniser.of(DOMAIN)
    used: set[str] = set()
    for _ in range(1500):
        program = random_program(rng, int(rng.integers(1, 9)))
        words = speaker.sentence(program)
        tokens = tokenizer(" ".join(words))
        assert recogniser.program(tokens.words), " ".join(words)
        used.update(words)
        named = [{DOMAIN.concepts[index].name for index in group} for group in tokens.groups]
        pairs = [[set(step.object), set(step.reference)] for step in program]
        assert len(named) == 2 * len(program), " ".join(words)
        for number, pair in enumerate(pairs):
            assert named[2 * number : 2 * number + 2] in (pair, pair[::-1]), " ".join(words)
    for name in ("MoveLeft", *SUPERLATIVES):
        related = Step("MoveOn", ("red",), ("blue",), (Relation(name, ("white",)),))
        for _ in range(300):
            used.update(speaker.sentence((related,)))
    # Each word of the rules is said by some sentence.
    assert DOMAIN.everyday is not None
    rules = {k: rule for k, rule in DOMAIN.everyday.rules.items() if k not in COUNTING}
    said = {word for rule in rules.values() for text in rule for word in text.split()}
    assert {word for word in said if not word.startswith("{")} <= used
    assert {"little", "tiny", "left-hand"} <= used


@pytest.mark.parametrize(
    "sentence",
    [
        "i put the red block on the blue block",
        "the red block placed on the blue block",
        "put the red block on the blue block first put green on white",
        "second , put the red block on the blue block",
        "put the red block next to the blue block",
        "put the red block to the top left of the blue block",
        "put the red block on the blue block and",
    ],
)
def test_what_no_rule_has_is_not_recognised(sentence: str) -> None:
    words = Tokenizer(DOMAIN)(sentence).words
    assert not Recogniser.of(DOMAIN).program(words)


@pytest.mark.parametrize(
    ("sentence", "joined"),
    [
        ("put the big and blue block on red", "put the {} block on {}"),
        ("put a red toy block that is small on blue", "put a {} toy block on {}"),
        ("put small red on the block that's blue", "put {} on the block that's {}"),
        # Two objects: an object has one colour.
        ("put the red and the blue block on white", "put the {} and the {} block on {}"),
        ("put red and blue on white", "put {} and {} on {}"),
        ("put red behind small blue", "put {} behind {}"),
    ],
)
def test_values_that_stand_apart_are_those_of_one_object(sentence: str, joined: str) -> None:
    told = " ".join(with_values_joined(DOMAIN, sentence))
    assert told == joined.replace("{}", GROUP_TOKEN)


def test_an_order_word_begins_only_the_first_step() -> None:
    recogniser, tokenizer = Recogniser.of(DOMAIN), Tokenizer(DOMAIN)
    first = "first put red on blue"
    assert recogniser.program(tokenizer(f"{first} and then green on white").words)
    assert recogniser.step(tokenizer(first).words)
    assert recogniser.step(tokenizer("second , put red on blue").words)
    assert not recogniser.step(tokenizer("and then first put red on blue").words)


def change(edit: Callable[[dict[str, Any]], object], path: Path) -> Path:
    """The everyday wording with a change."""
    words = tomllib.loads(EVERYDAY.read_text(encoding="utf-8"))
    edit(words)
    lines = [
        f"{table} = {json.dumps(words[table]).replace(':', ' =')}"
        for table in (*TABLES, "spelling")
    ]
    for table in ("relations", "rules"):
        lines.append(f"[{table}]")
        for key, value in words[table].items():
            text = json.dumps(value, ensure_ascii=False)
            lines.append(
                f"{key} = {text.replace(': ', ' = ') if isinstance(value, dict) else text}"
            )
    path.write_text("\n".join(lines), encoding="utf-8")
    return path


@pytest.mark.parametrize(
    ("edit", "problem"),
    [
        (lambda w: w["rules"].pop("command"), r"everyday\.rules\.command: is missing"),
        (lambda w: w["rules"]["on"].append("{pushing}"), r"rules\.on: unknown rule {pushing}"),
        (lambda w: w["rules"]["noun"].append("{noun}"), r"rules\.noun: contains itself"),
        (lambda w: w["rules"]["on"].append("{where}"), "contains itself"),
        (lambda w: w["rules"]["ordinal"].pop(), r"rules\.ordinal: expected 8 alternatives"),
        (lambda w: w["rules"].update(moved=["it"]), r"rules\.moved: has a meaning of its own"),
        (lambda w: w["rules"]["do"].append("Put"), "lower-case words or punctuation marks"),
        (lambda w: w["relations"].pop("MoveOn"), r"relations\.MoveOn: is missing"),
        (lambda w: w["relations"]["MoveOn"].update(rule="in"), "expected the name of a rule"),
        (lambda w: w["relations"]["Nearest"].update(rule="on"), r"Nearest\.rule: is no place"),
        (lambda w: w["relations"]["Nearest"].pop("state"), r"Nearest\.state: expected the name"),
        (lambda w: w["relations"]["Farthest"].update(related="in"), r"Farthest\.related: expected"),
        (lambda w: w["spelling"]["heard"].update(red="blue"), r"'red' is a word of the domain"),
        (lambda w: w["spelling"]["heard"].update(rad="rid"), r"heard\.rad: 'rid' is not a word"),
        (lambda w: w["spelling"]["other_words"].append("red"), r"other_words: 'red' is a word of"),
        (lambda w: w["spelling"].update(language="xx"), r"spelling\.language: expected "),
        (lambda w: w["synonyms"].update(huge=["big"]), r"synonyms\.huge: unknown attribute value"),
        (
            lambda w: w["synonyms"].update(small=["put"]),
            "'put' names the concept 'small'",
        ),
        (lambda w: w["extremes"].update(MoveOn=["put"]), "'put' names the extreme MoveOn"),
        (lambda w: w["extremes"].update(MoveOn=["red"]), "extremes.MoveOn: 'red' already names"),
        (lambda w: w["extremes"].update(MoveOn=["top most"]), "expected a single word"),
        (lambda w: w.update(extremes=["topmost"]), "extremes: expected a table"),
        (lambda w: w["pronouns"].update(hers=""), "pronouns.hers: 'hers' is not a word"),
        (lambda w: w.update(pronouns={"its": "one's"}), "pronouns: expected one that stands alone"),
        (lambda w: w["pronouns"].update(it="hers"), "pronouns.it: 'hers' is not a word"),
        (lambda w: w["pronouns"].update(red=""), "pronouns.red: 'red' is not a word"),
        (lambda w: w["several"]["all"].append("red"), "several.all: 'red' already names"),
        (lambda w: w["several"]["between"].append("off-of"), "between: 'off-of' is not a word of"),
        (lambda w: w["several"]["plurals"].update(hers="her"), "plurals.hers: 'her' is not a word"),
        (lambda w: w["several"]["plurals"].update(red="it"), "'red' is a word that describes"),
        (lambda w: w["apart"]["between"].append("And"), "apart.between"),
        (lambda w: w["apart"]["phrases"].append(""), "apart: expected words between values"),
        (lambda w: w["apart"].pop("phrases"), "apart.phrases"),
        (lambda w: w["arrangements"].update(next="hm"), "arrangements: 'hm' is not a word of the"),
        (
            lambda w: w["arrangements"]["steps"]["up"].update(order="pat"),
            "arrangements: 'pat' is not a word of the grammar",
        ),
        (
            lambda w: w["arrangements"]["patterns"][0]["openings"].append("{heap} of"),
            "no rule 'heap'; add it to arrangements.rules",
        ),
        (
            lambda w: w["arrangements"]["patterns"][0]["openings"].append(""),
            "expected words before the list",
        ),
        (
            lambda w: w["arrangements"]["patterns"][0]["closings"].update(across="across"),
            "'across': no steps 'across'",
        ),
        (lambda w: w["arrangements"].pop("between"), "arrangements.between"),
        (lambda w: w["table"].update(order="pat it"), "table: 'pat' is not a word of the grammar"),
        (lambda w: w["table"]["words"].append("red"), r"table\.words: 'red' already names"),
        (lambda w: w["table"]["words"].append("put"), "'put' names the table"),
        (lambda w: w["table"]["down"].append(""), "table: expected words that mean it"),
        (lambda w: w["table"].pop("off"), r"table\.off"),
        (
            lambda w: w["compounds"]["made"][0].update(read="pat"),
            r"compounds\.made\.MoveNextTo: 'pat' is not a word of the grammar",
        ),
        (
            lambda w: w["compounds"]["made"][0].update(all=["MoveRight", "MoveLeft"]),
            "MoveNextTo: expected one of any, all and between",
        ),
        (
            lambda w: w["compounds"]["made"][0].update(name="MoveOn"),
            "MoveOn: the name is that of an action",
        ),
        (
            lambda w: w["compounds"]["made"][0]["said"].append(""),
            "MoveNextTo.said: '' is empty",
        ),
        (
            lambda w: w["compounds"]["made"][0]["said"].append("{heap}"),
            "no rule 'heap'; add it to compounds.rules",
        ),
        (lambda w: w["compounds"]["sides"].append(""), "compounds.sides: expected words"),
        (
            lambda w: w["compounds"]["made"].append({**w["compounds"]["made"][0], "name": "Nigh"}),
            "Nigh.said: 'adjacent to' is empty, or said of MoveNextTo",
        ),
        (
            lambda w: w["ordinals"]["counts"].append(["third"]),
            r"ordinals\.counts: expected one or more words for each number, none of them twice",
        ),
        (lambda w: w["ordinals"]["counts"].append([]), "expected one or more words"),
        (
            lambda w: w["ordinals"]["first"]["MoveLeft"].append("from left"),
            "ordinals: 'from left' is in starts and in first",
        ),
        (lambda w: w["ordinals"]["unless"].append(""), "ordinals: expected words"),
        (
            lambda w: w["ordinals"]["starts"]["MoveOn"].append("from the {head}"),
            "no rule 'head'; add it to ordinals.rules",
        ),
        (lambda w: w["rules"].pop("several"), r"everyday\.rules\.several: is missing"),
    ],
)
def test_faults_in_the_wording_are_named(
    edit: Callable[[dict[str, Any]], object], problem: str, tmp_path: Path
) -> None:
    with pytest.raises(DomainError, match=problem):
        with_everyday(TABLETOP, change(edit, tmp_path / "wording.toml"))


def test_a_domain_has_the_relations_and_words_of_its_actions_alone() -> None:
    wide = with_everyday(domains.load(domains.FOUR_SIDES))
    assert DOMAIN.everyday is not None and wide.everyday is not None
    actions = [action.name for action in DOMAIN.actions]
    assert list(DOMAIN.everyday.relations) == [*actions, *SUPERLATIVES]
    assert [*wide.everyday.relations][3:] == ["MoveFront", "MoveBehind", *SUPERLATIVES]
    assert wide.other_words() - DOMAIN.other_words() == {"front", "back", "behind", "rear"}
    assert domains.from_json(wide.as_json(), "a model") == wide
    pattern = "put the _ block in front of a _ one behind the _ one"
    tokens = [GROUP_TOKEN if word == "_" else word for word in pattern.split()]
    assert Recogniser.of(wide).step(tokens)
    assert not Recogniser.of(DOMAIN).step(tokens)


def test_near_misses_are_of_known_words_and_no_commands() -> None:
    misses = NearMisses(DOMAIN, np.random.default_rng(5))
    tokenizer, recogniser = Tokenizer(DOMAIN), Recogniser.of(DOMAIN)
    drawn = [misses.draw() for _ in range(1000)]
    counts = {2: 0, 3: 0, 4: 0}
    for miss in drawn:
        words = tokenizer(miss.sentence).words
        counts[words.count(GROUP_TOKEN)] += 1
        assert not recogniser.program(words), miss.sentence
        assert miss.is_untimely or not recogniser.step(words), miss.sentence
    assert len({miss.sentence for miss in drawn}) > 950
    assert min(counts.values()) > 50
    assert 20 < sum(miss.is_untimely for miss in drawn) < 200


@pytest.mark.parametrize(
    ("sentence", "is_command"),
    [
        ("put the red block nearest to the blue one on the green one", True),
        ("put the block closest to the blue one on the green one", True),
        ("put the nearest red block to the blue one on the green one", True),
        ("put the red block on the one furthest away from the blue one", True),
        ("put the red block that is the farthest from the blue one left of the green one", True),
        # Nearest to what?
        ("put the nearest red block on the green one", False),
        ("put the red block on the nearest green block", False),
        # No place.
        ("put the red block nearest to the blue one", False),
        ("put the red block farthest from the blue one", False),
        # Not as people say it.
        ("put the red block nearest from the blue one on the green one", False),
        ("put the red block away from the blue one on the green one", False),
        ("put the red block nearest to and left of the blue one on the green one", False),
        ("put the second nearest red block to the blue one on the green one", False),
    ],
)
def test_superlatives_need_an_anchor_and_say_no_place(sentence: str, is_command: bool) -> None:
    words = Tokenizer(DOMAIN)(sentence).words
    assert Recogniser.of(DOMAIN).step(words) == is_command


def test_near_misses_have_superlatives_in_wrong_places() -> None:
    misses = NearMisses(DOMAIN, np.random.default_rng(5))
    drawn = [misses.sentence() for _ in range(1000)]
    wrong = [each for each in drawn if {"nearest", "closest", "farthest"} & {*each.split()}]
    assert 100 < len(wrong) < 500


def test_commands_that_nobody_demonstrates_are_near_misses() -> None:
    domain = with_everyday(domains.load(domains.FOUR_SIDES))
    misses = NearMisses(domain, np.random.default_rng(5), [("MoveLeft", "MoveOn")])
    tokenizer, recogniser = Tokenizer(domain), Recogniser.of(domain)
    drawn = [misses.draw() for _ in range(4000)]
    words = [tokenizer(miss.sentence).words for miss in drawn if not miss.is_untimely]
    commands = [each for each in words if recogniser.step(each)]
    assert 50 < len(commands) < 200
    assert all(each.count(GROUP_TOKEN) in (2, 3) for each in commands)
    assert all({"left", "left-hand"} & {*each} for each in commands)


def test_a_combination_counts_as_never_shown_if_chance_would_have_shown_it() -> None:
    shown = Counter({("MoveOn", "MoveOn"): 60, ("MoveLeft", "MoveLeft"): 60})
    assert never_shown(shown) == [("MoveLeft", "MoveOn"), ("MoveOn", "MoveLeft")]
    assert never_shown(shown | Counter({("MoveOn", "MoveLeft"): 1})) == [("MoveLeft", "MoveOn")]
    # With so few demonstrations, it may be missing by chance.
    assert never_shown(Counter(dict.fromkeys(shown, 10))) == []


@pytest.mark.slow
def test_told_sentences_come_back_from_their_file(episodes: Path, tmp_path: Path) -> None:
    told = tell(DOMAIN, episodes, count=3, near_misses=20, seed=1)
    assert told == tell(DOMAIN, episodes, count=3, near_misses=20, seed=1)
    assert told != tell(DOMAIN, episodes, count=3, near_misses=20, seed=2)
    path = tmp_path / "told.jsonl"
    write_told(path, episodes, told)
    assert read_told(path, episodes) == told
    both = len(told.sentences) + len(told.near_misses) + len(told.untimely)
    assert both == 3 * SETTINGS.count + 20


@pytest.mark.slow
def test_nothing_is_done_after_a_sentence_with_two_readings(episodes: Path) -> None:
    told = tell(DOMAIN, episodes, count=24, near_misses=0, seed=1)
    attachments, tokenizer = Attachments(DOMAIN), Tokenizer(DOMAIN)

    def ambiguous(sentences: list[str]) -> list[bool]:
        return [attachments.is_ambiguous(tokenizer(each).words) for each in sentences]

    assert told.near_misses
    assert all(ambiguous(told.near_misses))
    assert not any(ambiguous(told.sentences))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("", "not a file of sentences"),
        ('{"kind": "other"}', "not a file of sentences"),
        ("put red on blue", "cannot read the sentences"),
        ("[1]", "line 1 is not a JSON object"),
        ("FIRST\n{}", "line 2 has no sentence"),
        ('FIRST\n{"sentence": "a", "episode": 12}', "expected an episode below 12 or null, got 12"),
        ('{"kind": "nsrm sentences", "schema": 3, "episodes": {}}', "are not about the episodes"),
    ],
)
def test_faults_in_a_file_of_sentences_are_named(
    text: str, problem: str, episodes: Path, tmp_path: Path
) -> None:
    path = tmp_path / "told.jsonl"
    write_told(path, episodes, Told([], [], [], [], []))
    path.write_text(text.replace("FIRST", path.read_text(encoding="utf-8").strip()), "utf-8")
    with pytest.raises(EpisodeFileError, match=problem):
        read_told(path, episodes)


def test_half_of_the_everyday_sentences_about_one_step_are_told_as_a_later_one(
    episodes: Path, tmp_path: Path
) -> None:
    told = tell(DOMAIN, episodes, count=30, near_misses=0, seed=1)
    with GroundTruth(episodes) as judge:
        steps = [len(judge.truth(number).program) for number in told.episodes]
    assert len(told.later) == len(told.sentences)
    single = [later for later, count in zip(told.later, steps, strict=True) if count == 1]
    assert not any(later for later, count in zip(told.later, steps, strict=True) if count > 1)
    # A third is plain.
    assert 0.25 < np.mean(single) < 0.42
    recogniser, tokenizer = Recogniser.of(DOMAIN), Tokenizer(DOMAIN)
    for sentence, later in zip(told.sentences, told.later, strict=True):
        if later:
            assert recogniser.step(tokenizer(sentence).words), sentence
    path = tmp_path / "told.jsonl"
    write_told(path, episodes, told)
    assert read_told(path, episodes) == told


@pytest.mark.slow
def test_final_scenes_show_what_sentences_mean(
    episodes: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from nsrm_harness.learning.config import TrainingConfig
    from nsrm_harness.learning.dataset import told, training_set
    from nsrm_harness.learning.explain import explain
    from nsrm_harness.learning.export import read_model

    monkeypatch.setattr(*SMALL_BATCHES)
    file = read_model(PRETRAINED)
    # One sentence each: none has relations.
    found = tell(DOMAIN, episodes, count=1, near_misses=0, seed=1)
    with Demonstrations(episodes) as demonstrations:
        camera = demonstrations.camera(0)
        data = told(training_set(demonstrations, True), DOMAIN, found.sentences, found.episodes)
    with GroundTruth(episodes) as judge:
        programs = [judge.truth(number).program for number in found.episodes]
    explained = explain(file.model, data, TrainingConfig(), camera)
    assert len(set(explained.sentence.tolist())) > 0.6 * len(data)
    for (index, steps), number in zip(
        programs_of(explained, data.sentences, FOUR_SIDES), explained.step, strict=True
    ):
        assert canonical([programs[index][number]]) in [canonical([step]) for step in steps]


@pytest.mark.slow
def test_the_end_of_the_first_step_follows_from_how_sentences_begin_and_end() -> None:
    from nsrm_harness.learning.dataset import Sentences
    from nsrm_harness.learning.first_ends import first_ends

    rng = np.random.default_rng(8)
    speaker, tokenizer = Speaker(DOMAIN, rng), Tokenizer(DOMAIN)
    said = [speaker.steps(random_program(rng, 1 + number % 2)) for number in range(6000)]
    tokens = [tokenizer(" ".join(word for step in steps for word in step)) for steps in said]
    found = first_ends(Sentences.of(tokenizer, tokens), np.arange(1, len(said), 2))
    expected = np.array([len(tokenizer.pattern(steps[0])) for steps in said])
    assert (found[::2] == expected[::2]).all(), "a sentence of one step is that step"
    # Some ends are equally good: "… please | put …" and "… | please put …".
    assert (found == expected)[1::2].mean() > 0.85
    behind = [tokens[number].words[found[number]] for number in range(1, len(said), 2)]
    assert sum(word in ("block", "cube", "of", "side") for word in behind) < 0.01 * len(said)


def test_the_mean_of_lessons_leaves_what_none_of_them_changes() -> None:
    from nsrm_harness.learning.model import Dimensions, Model
    from nsrm_harness.learning.wording import between

    def weight(model: Model) -> Any:
        return model.language.embedding.weight

    before = Model(Dimensions.of(DOMAIN), jax.random.key(0))
    taught = [eqx.tree_at(weight, before, weight(before).at[0].add(added)) for added in (1.0, 3.0)]
    assert between([(before, taught[0])], 1.0) is taught[0]
    mean = between([(before, each) for each in taught], 0.25)
    np.testing.assert_allclose(weight(mean)[0], weight(before)[0] + 0.5, rtol=1e-6)
    np.testing.assert_array_equal(weight(mean)[1:], weight(before)[1:])
    for one, other in zip(
        jax.tree.leaves(mean.vision), jax.tree.leaves(before.vision), strict=True
    ):
        np.testing.assert_array_equal(one, other)


@pytest.mark.slow
def test_a_model_is_taught_by_commands_that_can_be_interrupted(
    episodes: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    from nsrm_harness.learning.checkpoint import Checkpoints
    from nsrm_harness.learning.counting import with_later_words
    from nsrm_harness.learning.export import read_model
    from nsrm_harness.learning.wording import Lesson, WordingConfig, teach

    monkeypatch.setattr(*SMALL_BATCHES)
    # Each set is measured; figures need more sentences.
    for name in (name for name in dir(language) if name.endswith("_COUNT")):
        monkeypatch.setattr(language, name, 50)
    assert run("sentences", "--episodes", episodes, "--count", 4, "--near-misses", 300) == 0
    said = re.search(
        r"(\d+) sentences about 12 demonstrations, (\d+) near misses", capsys.readouterr().out
    )
    assert said is not None
    # Those with two readings are near misses.
    sentences, near_misses = map(int, said.groups())
    assert sentences + near_misses == 348 and near_misses >= 300
    files = ("--episodes", episodes, "--validation", episodes, "--test", episodes)
    out = tmp_path / "taught"
    assert run("wording", "--model", PRETRAINED, *files, "--epochs", 2, "--out", out) == 0
    assert "steps explained by their final scenes" in capsys.readouterr().out
    model = nsrm.Model.load(out / "model.safetensors")
    assert {"brick", "belongs", "left-hand", "."} <= set(model.info()["words"])
    assert model.info()["training"]["wording"]["near_misses"] == near_misses
    assert (out / "curves.png").stat().st_size > 1000

    table = tmp_path / "language.csv"
    options = ("--data", episodes, "--relations", episodes, "--near-misses", 50, "--out", table)
    assert run("language", "--model", out / "model.safetensors", *options) == 0
    rows = [line.split(",") for line in table.read_text(encoding="utf-8").splitlines()]
    counts = {row[0]: list(map(int, row[2:])) for row in rows[1:]}
    assert all(sum(row[1:]) == row[0] for row in counts.values())
    assert counts["validation"][0] == SETTINGS.count and counts["near misses"][0] == 50
    assert counts["pronouns of nothing"][0] > 0
    for name in ("relations", "superlatives", "extremes"):
        for where in ("in scenes", "of none or several"):
            assert counts[f"{name} {where}"][0] > 0, name
    told = [row for name, row in counts.items() if "everyday" in name]
    assert sum(row[0] for row in told) == SETTINGS.count

    save = Checkpoints.save

    def interrupted(self: Checkpoints, progress: Any, state: Any) -> None:
        save(self, progress, state)
        if progress.epoch == 1:
            raise KeyboardInterrupt

    lesson = Lesson.read(read_model(PRETRAINED), episodes, episodes.with_suffix(".jsonl"), EVERYDAY)
    config, again = WordingConfig().with_epochs(2), tmp_path / "again"
    with monkeypatch.context() as patched, pytest.raises(KeyboardInterrupt):
        patched.setattr(Checkpoints, "save", interrupted)
        teach(lesson, config, 0, again)
    resumed = teach(lesson, config, 0, again, resume=True)
    words = with_later_words(resumed, lesson.domain).language.embedding.weight
    taught = read_model(out / "model.safetensors").model.language.embedding.weight
    np.testing.assert_array_equal(np.asarray(words), np.asarray(taught))


@pytest.mark.slow
def test_the_built_in_model_takes_no_sentence_of_other_people_for_another(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "language.csv"
    lists = ("--sentences", LISTS / "sentences.tsv", "--sentences", LISTS / "probes.tsv")
    assert run("language", *lists, "--near-misses", 0, "--out", out) == 0
    rows = [line.split(",") for line in out.read_text(encoding="utf-8").splitlines()]
    assert rows[0] == list(language.COLUMNS)
    counts = {row[0]: list(map(int, row[2:])) for row in rows[1:]}
    for name, number, least_right in (("sentences", 82, 70), ("probes", 400, 340)):
        count, right, _, wrong = counts[name]
        assert (count, wrong) == (number, 0) and right >= least_right
    assert counts["sentences; to refuse"] == [61, 0, 61, 0]
    count, right, _, wrong = counts["sentences; to refuse; misspelt"]
    assert count >= 600 and right == 0 and wrong <= 3
    assert f"{out}: 4 rows" in capsys.readouterr().out


def test_a_list_without_its_columns_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "list.tsv"
    path.write_text("sentence\nput red on blue\n", encoding="utf-8")
    with pytest.raises(EvaluationError, match="expected tab-separated columns"):
        language.read_list(path)
