"""Trains and judges the variants, and judges models on disturbed scenes."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import nsrm
import numpy as np

from nsrm_harness.common.json_text import json_text
from nsrm_harness.common.whole_file import write_whole
from nsrm_harness.data.file import Demonstrations
from nsrm_harness.domain.tokens import Tokenizer
from nsrm_harness.evaluation.metrics import Metrics, PlainStep, evaluate, judge_plans
from nsrm_harness.learning import decode, reference
from nsrm_harness.learning.dataset import training_set
from nsrm_harness.learning.export import ModelFile, write_model
from nsrm_harness.learning.run_training import Files, fit
from nsrm_harness.paper.tables import variants
from nsrm_harness.paper.tables.judging import Contender, Judging
from nsrm_harness.paper.tables.processes import ProcessTask, run_all
from nsrm_harness.paper.tables.results import ResultRow
from nsrm_harness.paper.tables.run_tables import Tables
from nsrm_harness.paper.tables.study import FAMILIES
from nsrm_harness.paper.tables.trainings import keep_compiled
from nsrm_harness.paper.tables.variants import BEFORE_LAST, DisturbedSet, Variant

JUDGED_FILE = "judged.json"
"""File with the figures and times of a variant's finished training, in its folder."""
BEFORE = ", before the last stage"
"""Suffix of a variant's name in the rows of its model before the last stage."""


@dataclass(frozen=True)
class Cost:
    """How long a stage of a variant's training took."""

    variant: str
    seed: int
    stage: str
    seconds: float


@dataclass(frozen=True)
class Comparison:
    """Results on variants and disturbed scenes for the report."""

    rows: tuple[ResultRow, ...]
    """Results of variants; `model` is the name of the variant."""
    costs: tuple[Cost, ...]
    merged: tuple[tuple[str, int], ...]
    """Variants and seeds that learned two actions as the same one."""
    disturbed: tuple[tuple[DisturbedSet, tuple[ResultRow, ...]], ...]


def compare(
    tables: Tables, wanted: Sequence[Variant], disturbed: Sequence[DisturbedSet]
) -> Comparison:
    """Makes all comparisons in the folder of the tables, whose models must exist. A further call
    resumes an interrupted run. Variants are trained on this machine."""
    for name, settings in variants.training_sets(tables.study).items():
        if any(variant.train == name for variant in wanted):
            tables.make_episodes(name, settings)
    for each in disturbed:
        tables.make_episodes(each.name, each.settings)
    runs = [
        (variant, seed, tables.runs / f"variant-{variant.folder}-{seed}")
        for variant in wanted
        for seed in variant.seeds
    ]
    tests = {split: tables.data(split) for split in variants.JUDGED}
    tasks = []
    for variant, seed, out in runs:
        if not (out / JUDGED_FILE).exists():
            files = replace(tables.files(FAMILIES[0]), train=tables.data(variant.train))
            arguments = (variant, files, seed, out, tests)
            tasks.append(ProcessTask(out.name, train_and_judge, arguments, out / "log.txt"))
    run_all(tasks, tables.workers.count, "variants")
    contenders = _contenders(tables, runs)
    judgings = [
        Judging(each.name, tables.data(each.name), contenders, "mask") for each in disturbed
    ]
    judged = tables.judge(judgings, "disturbed scenes")
    found = [json.loads((out / JUDGED_FILE).read_text(encoding="utf-8")) for *_, out in runs]
    return Comparison(
        rows=tuple(ResultRow(**row) for one in found for row in one["rows"]),
        costs=tuple(
            Cost(variant.name, seed, stage, seconds)
            for (variant, seed, _), one in zip(runs, found, strict=True)
            for stage, seconds in one["seconds"].items()
        ),
        merged=tuple(
            (variant.name, seed)
            for (variant, seed, _), one in zip(runs, found, strict=True)
            if not one["named"]
        ),
        disturbed=tuple((each, tuple(rows)) for each, rows in zip(disturbed, judged, strict=True)),
    )


def train_and_judge(
    variant: Variant, files: Files, seed: int, out: Path, tests: dict[str, Path]
) -> None:
    """Trains a variant, resuming if interrupted, and judges it on the files of `tests`."""
    keep_compiled(out)
    before = out / "before-last.safetensors"

    def after_stage(name: str, fitting: Callable[[], ModelFile]) -> None:
        if name == BEFORE_LAST and variant.before_last:
            write_model(before, fitting())

    fitted = fit(files, variant.config, seed, out, resume=True, after_stage=after_stage)
    rows = _judge(variant.name, fitted.file, out / "model.safetensors", seed, tests)
    if variant.before_last:
        for split, path in tests.items():
            metrics = evaluate(nsrm.Model.load(before), path)
            rows.append(ResultRow.of(split, variant.name + BEFORE, seed, "mask", metrics))
    content: dict[str, Any] = {
        "rows": [asdict(row) for row in rows],
        "seconds": fitted.seconds,
        "named": fitted.named,
    }
    write_whole(out / JUDGED_FILE, json_text(content, indent=1).encode())


def _judge(
    name: str, file: ModelFile, path: Path, seed: int, tests: dict[str, Path]
) -> list[ResultRow]:
    """Judges a model through the core, if the core supports it."""
    if not file.model.action.simulator.residual:
        return [
            ResultRow.of(split, name, seed, "mask", judge_without_core(file, test))
            for split, test in tests.items()
        ]
    write_model(path, file)
    model = nsrm.Model.load(path)
    return [
        ResultRow.of(split, name, seed, "mask", evaluate(model, test))
        for split, test in tests.items()
    ]


def judge_without_core(file: ModelFile, path: Path) -> Metrics:
    """The same metrics for a model that the core does not support. Only a step without descriptions
    is refused."""
    with Demonstrations(path) as demonstrations:
        data = training_set(demonstrations)
        sentences = list(demonstrations.sentences)
        cameras = [demonstrations.camera(index) for index in range(len(demonstrations))]
    model, domain, tokenizer = file.model, file.domain, Tokenizer(file.domain)
    seen = decode.see_all(model, data)

    def named(concepts: Sequence[int]) -> tuple[str, ...]:
        return tuple(domain.concepts[number].name for number in concepts)

    plans: list[list[PlainStep]] = []
    for index, sentence in enumerate(sentences):
        steps, present = reference.parse(model, tokenizer, sentence), data.present[index]
        if not all(step.groups for step in steps):
            plans.append([])
            continue
        before, similarities = data.before[index][present], seen[index][present]
        planned = reference.plan(model, steps, before, similarities, cameras[index])
        plans.append(
            [
                PlainStep(
                    made.object + 1,
                    made.reference + 1,
                    made.location,
                    made.position,
                    domain.actions[made.action].name,
                    named(step.groups[int(np.argmax(step.object_logits))]),
                    named(step.groups[int(np.argmax(step.reference_logits))]),
                )
                for step, made in zip(steps, planned, strict=True)
            ]
        )
    return judge_plans(path, plans)


def _contenders(tables: Tables, runs: Sequence[tuple[Variant, int, Path]]) -> tuple[Contender, ...]:
    """The models to judge on disturbed scenes: the study's, and those trained on varied data."""
    return (
        *tables.models(FAMILIES[0]),
        *(
            Contender(variant.name, seed, out / "model.safetensors")
            for variant, seed, out in runs
            if variant.train == variants.TRAIN_VARIED
        ),
    )
