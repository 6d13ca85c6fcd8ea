"""Teaches a trained model everyday wording, from many sentences about demonstrations.

Perception and actions stay as they are: with them, the final scene shows what a sentence means
(`explain`), and the parser is trained on that. From near misses, sentences after which nothing was
done, and from two steps that are read as one, it learns which words are not acceptable where they
stand, and of commands in an impossible order of time the splitter learns to leave them whole; the
core refuses both.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jax import Array
from tqdm import tqdm

from nsrm_harness.common.json_text import json_text
from nsrm_harness.data.file import Demonstrations
from nsrm_harness.data.told import Told, read_told
from nsrm_harness.domain import Domain
from nsrm_harness.domain.dictionary import with_dictionary
from nsrm_harness.domain.everyday import with_everyday
from nsrm_harness.domain.patterns import is_reserved
from nsrm_harness.domain.tokens import Tokenizer
from nsrm_harness.geometry.camera import Camera
from nsrm_harness.learning import calibrate, curves
from nsrm_harness.learning.checkpoint import Checkpoints, TrainingProgress
from nsrm_harness.learning.config import StageConfig, TrainingConfig
from nsrm_harness.learning.counting import with_later_words
from nsrm_harness.learning.dataset import (
    GROUPS_PER_STEP,
    TrainingSet,
    told,
    training_set,
)
from nsrm_harness.learning.explain import explain, relations_of
from nsrm_harness.learning.export import ModelFile
from nsrm_harness.learning.first_ends import first_ends
from nsrm_harness.learning.model import (
    GROUP_TOKEN,
    Acceptability,
    Dimensions,
    Language,
    Model,
    without_relations,
)
from nsrm_harness.learning.splits import end_log_probability
from nsrm_harness.learning.stages import FURTHER, PARSER, SPLITTER, Stage, TrainingError
from nsrm_harness.learning.structures import MOST_GROUPS, explaining_log_probability
from nsrm_harness.learning.train import Fit

NAME = "wording"
MOST_TOKENS = 32
"""Steps with more tokens are left out."""
AHEAD = 8
"""Number of tokens of the next step that the splitter sees in training; it looks two ahead."""
CERTAIN = 1e-6
"""Subtracted from the log probability that all words are acceptable: no loss is infinite."""
ODDS = 2.0
"""Log odds of each word's acceptability before the lesson, and that a group has no relation."""
ALONE = 0.4
"""Share of steps that are shown to the splitter without the next one."""


@dataclass(frozen=True)
class WordingConfig:
    """Everything that the lesson depends on, except data and seed."""

    stage: StageConfig = field(
        default_factory=lambda: StageConfig(epochs=14, learning_rate=3e-3, batch=480)
    )
    """A batch has as many steps, near misses and commands in an impossible order."""
    training: TrainingConfig = field(default_factory=TrainingConfig)
    """Its loss and its bound decide which program explains a final scene."""

    def with_epochs(self, epochs: int) -> WordingConfig:
        """The same with another number of epochs."""
        return replace(self, stage=replace(self.stage, epochs=epochs))


class ToldSteps(NamedTuple):
    """Steps of told sentences, and what the final scene shows that they mean."""

    tokens: Array
    """Right-padded with row 0, `[T]`."""
    length: Array
    joined: Array
    """The same tokens with those of the next step behind them, `[T + AHEAD]`."""
    joined_length: Array
    places: Array
    """Index of each group token in the step, `[G]`; 0 behind the last."""
    programs: Array
    """What explains the final scene, `[P]`; see `explain.Explained`."""


class NearMissTokens(NamedTuple):
    """Sentences that mean nothing as one step."""

    tokens: Array
    length: Array


class Unsplit(NamedTuple):
    """Sentences with four descriptions whose steps have no order."""

    tokens: Array
    length: Array


def told_steps(
    model: Model,
    data: TrainingSet,
    config: TrainingConfig,
    camera: Camera,
    later: Sequence[bool],
    rng: np.random.Generator,
) -> tuple[ToldSteps, list[np.ndarray]]:
    """The steps of the sentences that the final scenes explain, without reserved patterns, and the
    tokens of those sentences that are two steps: as a single one, they are near misses.

    `later`: whether each sentence is told as a later step

    The last step of a sentence gets one of another sentence behind it: commands may have more steps
    than any demonstration.
    """
    found = explain(model, data, config, camera)
    s, second = data.sentences, found.sentence[found.step == 1]
    # Not those of one step that describe four objects.
    ends, double = first_ends(s, second), set(second.tolist())
    rows: list[tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]] = []
    follow: list[np.ndarray] = []
    for index, number, programs in zip(*found, strict=True):
        tokens = s.tokens[index, : s.length[index]]
        middle = int(ends[index]) if int(index) in double else len(tokens)
        first, end = ((0, middle), (middle, len(tokens)))[number]
        step = tokens[first:end]
        places = np.flatnonzero(step == GROUP_TOKEN)
        if (
            len(step) > MOST_TOKENS
            or not GROUPS_PER_STEP <= len(places) <= MOST_GROUPS
            or is_reserved(step.tolist())
        ):
            continue
        rows.append((step, tokens[end : end + AHEAD], places, programs))
        if number > 0 or later[index]:
            follow.append(step[:AHEAD])
    if not rows:
        raise TrainingError("the model's perception and actions explain none of the sentences")
    joined = [
        np.concatenate([step, behind if len(behind) or not follow else _any(rng, follow)])
        for step, behind, *_ in rows
    ]
    tokens, length = _padded([row[0] for row in rows], MOST_TOKENS)
    both, both_length = _padded(joined, MOST_TOKENS + AHEAD)
    places, _ = _padded([row[2] for row in rows], MOST_GROUPS)
    programs = jnp.asarray(np.stack([row[3] for row in rows]))
    steps = ToldSteps(tokens, length, both, both_length, places, programs)
    return steps, [s.tokens[index, : s.length[index]] for index in sorted(double)]


def _any(rng: np.random.Generator, rows: Sequence[np.ndarray]) -> np.ndarray:
    return rows[int(rng.integers(len(rows)))]


def wording_stage(
    config: WordingConfig, steps: ToldSteps, misses: NearMissTokens, unsplit: Unsplit
) -> Stage:
    """Parser and splitter on told steps and near misses."""
    return Stage(NAME, config.stage, (steps, misses, unsplit), (), _loss)


def _loss(model: Model, _: Any, batch: tuple[Any, ...], key: Array, done: Array) -> Array:
    steps, misses, unsplit = batch
    alone = jax.random.bernoulli(key, ALONE, steps.length.shape)
    meaning = jax.vmap(lambda step, alone: _step_loss(model.language, step, alone))
    nothing = jax.vmap(lambda miss: _nothing_loss(model.language, miss))
    whole = jax.vmap(lambda command: _whole_loss(model.language, command))
    return meaning(steps, alone).mean() + nothing(misses).mean() + whole(unsplit).mean()


def _step_loss(language: Language, step: ToldSteps, alone: Array) -> Array:
    """Surprise, in nats, at the meaning of a step, its acceptable words and its end."""
    heard = language.heard(step.tokens, jnp.arange(MOST_TOKENS) < step.length)
    meant = explaining_log_probability(heard, step.places, step.programs)
    length = jnp.where(alone, step.length, step.joined_length)
    end = end_log_probability(language.splitter, step.joined, length)[step.length - 1]
    return -meant - heard.acceptable - end


def _nothing_loss(language: Language, miss: NearMissTokens) -> Array:
    """Surprise, in nats, that not all words are acceptable."""
    heard = language.heard(miss.tokens, jnp.arange(MOST_TOKENS) < miss.length)
    return -jnp.log(-jnp.expm1(heard.acceptable - CERTAIN))


def _whole_loss(language: Language, command: Unsplit) -> Array:
    """Surprise, in nats, if a command is not split."""
    ends = end_log_probability(language.splitter, command.tokens, command.length)
    return -ends[command.length - 1]


def near_misses(
    tokenizer: Tokenizer, found: Told, joined: Sequence[np.ndarray]
) -> tuple[NearMissTokens, Unsplit]:
    """The near misses as arrays, without reserved patterns.

    `joined`: the tokens of two steps that are not one
    """
    untimely = [_rows(tokenizer, sentence) for sentence in found.untimely]
    told = (_rows(tokenizer, sentence) for sentence in found.near_misses)
    misses = [
        tokens
        for tokens in (*untimely, *told, *joined)
        if np.sum(tokens == GROUP_TOKEN) <= MOST_GROUPS
        and len(tokens) <= MOST_TOKENS
        and not is_reserved(tokens.tolist())
    ]
    # The splitter has to pass the second step's beginning.
    width = MOST_TOKENS + AHEAD
    unsplit = [
        tokens[:width] for tokens in untimely if np.sum(tokens == GROUP_TOKEN) > GROUPS_PER_STEP
    ]
    if not (misses and unsplit):
        raise TrainingError("too few near misses: make more with 'harness sentences'")
    return NearMissTokens(*_padded(misses, MOST_TOKENS)), Unsplit(*_padded(unsplit, width))


def _rows(tokenizer: Tokenizer, sentence: str) -> np.ndarray:
    return np.array(tokenizer.rows(tokenizer(sentence)), np.int32)


def _padded(rows: Sequence[np.ndarray], width: int) -> tuple[Array, Array]:
    """The rows, right-padded with row 0, and their lengths."""
    padded = np.zeros((len(rows), width), np.int32)
    for padding, row in zip(padded, rows, strict=True):
        padding[: len(row)] = row
    return jnp.asarray(padded), jnp.asarray([len(row) for row in rows])


@dataclass(frozen=True)
class Lesson:
    """What the lesson is made from: a trained model and told demonstrations."""

    base: ModelFile
    domain: Domain
    """That of the model, with everyday wording."""
    data: TrainingSet
    camera: Camera
    """That of the first demonstration; all have the same."""
    told: Told
    """The sentences about them, and near misses."""

    @classmethod
    def read(cls, base: ModelFile, episodes: Path, sentences: Path, wording: Path) -> Lesson:
        """Reads the demonstrations and the sentences about them."""
        domain = with_dictionary(with_everyday(base.domain, wording))
        found = read_told(sentences, episodes)
        with Demonstrations(episodes) as demonstrations:
            shown, camera = training_set(demonstrations), demonstrations.camera(0)
        data = told(shown, domain, found.sentences, found.episodes)
        return cls(base, domain, data, camera, found)

    def untaught(self, seed: int) -> Model:
        """The model with random embeddings for the words that are new to it, and before its first
        lesson with an acceptability and a relation decoder that know nothing. Later lessons keep
        both, and may add relations."""
        fresh = Model(Dimensions.of(self.domain), jax.random.key(seed))
        base, row = self.base.model, {word: n for n, word in enumerate(self.domain.vocabulary())}
        known = jnp.array([row[word] for word in self.base.domain.vocabulary()])

        def embeddings(model: Model) -> tuple[Array, Array]:
            language = model.language
            return language.embedding.weight, language.splitter.embedding.weight

        grown = [
            new.at[known].set(old)
            for new, old in zip(embeddings(fresh), embeddings(base), strict=True)
        ]
        judge, relations = base.language.acceptability, base.language.relation_decoder
        if NAME not in self.base.training:
            judge = Acceptability(jax.random.key(seed), ODDS)
            relations = without_relations(relations_of(base), ODDS)
        else:
            relations = _ready(relations)
        return eqx.tree_at(
            lambda model: (
                *embeddings(model),
                model.language.acceptability,
                model.language.relation_decoder,
            ),
            base,
            (*grown, judge, relations),
        )


def _ready(relations: eqx.nn.Linear) -> eqx.nn.Linear:
    """The relation decoder, in which those relations that no lesson has taught are as before the
    first lesson."""
    assert relations.bias is not None, "layers have a bias"
    untaught = ~jnp.any(relations.weight != 0.0, axis=1)
    bias = jnp.where(untaught, -ODDS, relations.bias)
    return eqx.tree_at(lambda layer: layer.bias, relations, bias)


def teach(
    lesson: Lesson,
    config: WordingConfig,
    seed: int,
    folder: Path,
    resume: bool = False,
    say: Callable[[str], None] = print,
) -> Model:
    """Trains the language part; `KeyboardInterrupt` leaves a checkpoint in `folder`."""
    model = lesson.untaught(seed)
    run = json_text([asdict(config), seed, lesson.data.hash(), lesson.domain.as_json()])
    checkpoints = Checkpoints(folder, run)
    progress = (checkpoints.progress() if resume else None) or TrainingProgress()
    rng = np.random.default_rng(seed)
    later = lesson.told.later
    steps, joined = told_steps(model, lesson.data, config.training, lesson.camera, later, rng)
    misses, unsplit = near_misses(Tokenizer(lesson.domain), lesson.told, joined)
    say(
        f"{len(lesson.data)} sentences, {len(steps.length)} steps explained by their final scenes, "
        f"{len(misses.length)} near misses, {len(unsplit.length)} in an impossible order"
    )
    fit = Fit(wording_stage(config, steps, misses, unsplit), PARSER + FURTHER + SPLITTER, seed, 0)
    state = fit.start(model)
    if progress.epoch > 0:
        state = checkpoints.state(state)
    began = time.monotonic() - progress.seconds.get(NAME, 0.0)
    epochs = config.stage.epochs
    with tqdm(total=epochs, initial=progress.epoch, desc=NAME) as bar:
        while progress.epoch < epochs:
            state, loss = fit.epoch(state, progress.epoch)
            if not np.isfinite(loss):
                raise TrainingError(f"{NAME}: the loss is not finite: {loss}")
            progress.epoch += 1
            progress.seconds[NAME] = time.monotonic() - began
            progress.losses.setdefault(NAME, []).append(loss)
            bar.set_postfix(loss=f"{loss:.5f}", refresh=False)
            bar.update()
            checkpoints.save(progress, state)
    curves.draw_curves(progress, folder / "curves.png")
    return state.model


def between(lessons: Sequence[tuple[Model, Model]], share: float) -> Model:
    """The weights between those before and behind lessons, the mean of several: a lesson about
    something new costs less of what was known before if it is not followed all the way, and what it
    costs differs from seed to seed.

    `lessons`: the model before and behind each
    """
    _, behind = lessons[0]
    if share == 1.0 and len(lessons) == 1:
        return behind  # Not rounded again.

    def mixed(*weights: Array) -> Array:
        first = weights[0]
        pairs = zip(weights[::2], weights[1::2], strict=True)
        # What no lesson touches stays the same, bit by bit.
        steps = jnp.stack([old - first + share * (new - old) for old, new in pairs])
        return first + steps.mean(axis=0)

    trees = [eqx.filter(model, eqx.is_inexact_array) for lesson in lessons for model in lesson]
    return eqx.combine(jax.tree.map(mixed, *trees), behind)


def plain_actions(
    model: Model, validation: Lesson, config: WordingConfig
) -> tuple[np.ndarray, np.ndarray]:
    """Logits of the actions of told steps without relations, and the actions that explain them."""
    rng = np.random.default_rng(0)
    told = validation.told.later
    steps, _ = told_steps(model, validation.data, config.training, validation.camera, told, rng)
    actions = model.language.action_decoder.weight.shape[0]
    programs = np.asarray(steps.programs)
    # The first two structures are the plain ones.
    is_plain = (programs >= 0) & (programs < 2 * actions)
    plain = np.zeros((len(programs), actions), int)
    row, _ = np.nonzero(is_plain)
    plain[row, programs[is_plain] % actions] = 1
    chosen = np.flatnonzero(plain.sum(axis=1) == 1)

    @eqx.filter_jit
    def logits(model: Model, tokens: Array, length: Array) -> Array:
        def one(tokens: Array, length: Array) -> Array:
            return model.language.parse(tokens, jnp.arange(MOST_TOKENS) < length).action

        return jax.vmap(one)(tokens, length)

    found = logits(model, steps.tokens[chosen], steps.length[chosen])
    return np.asarray(found), plain[chosen].argmax(axis=1)


def fitted(
    lesson: Lesson,
    model: Model,
    validation: Lesson,
    config: WordingConfig,
    record: Mapping[str, Any],
) -> ModelFile:
    """The model file, which also counts steps that no demonstration has, with the certainty of
    actions fitted to told validation demonstrations.

    `record`: how it was taught, beside the lesson and its configuration
    """
    model = with_later_words(model, lesson.domain)
    certainty = calibrate.certainty_of(*plain_actions(model, validation, config))
    model = calibrate.with_certainty(model, certainty)
    training = {
        **lesson.base.training,
        NAME: {
            **record,
            "sentences": len(lesson.data),
            "near_misses": len(lesson.told.near_misses) + len(lesson.told.untimely),
            "data_hash": lesson.data.hash(),
            "stage": asdict(config.stage),
        },
    }
    return replace(lesson.base, model=model, domain=lesson.domain, training=training, metrics={})
