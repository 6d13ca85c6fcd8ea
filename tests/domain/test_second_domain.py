"""Another domain goes the whole way without a change in Rust: its file, episodes, a few
steps of training, the model file, static arrays, and the planner in `core`."""

from __future__ import annotations

import os
import shutil
import subprocess
from dataclasses import dataclass, replace
from pathlib import Path

import nsrm
import pytest

from nsrm_harness import domain as domains
from nsrm_harness.cli.main import commands
from nsrm_harness.data.calibration import Calibration
from nsrm_harness.data.file import Demonstrations
from nsrm_harness.data.ground_truth import GroundTruth
from nsrm_harness.domain.program import Step, canonical
from nsrm_harness.learning import calibrate
from nsrm_harness.learning.config import StageConfig, TrainingConfig
from nsrm_harness.learning.dataset import training_set
from nsrm_harness.learning.export import (
    ModelFile,
    WorkSpace,
    read_model,
    write_metrics,
    write_model,
)
from nsrm_harness.learning.model import tensors
from nsrm_harness.learning.train import TRAINS, Curriculum, train
from nsrm_harness.simulation.layout import WORK_SPACE

ROOT = Path(__file__).resolve().parents[2]
DOMAIN = ROOT / "sim-harness" / "tests" / "domains" / "workshop.toml"

MAIN_RS = """
mod workshop;

use nsrm_core::Planner;

fn main() {
    let planner = Planner::new(&workshop::WORKSHOP);
    for sentence in std::io::stdin().lines() {
        match planner.parse(&sentence.unwrap()) {
            Ok(parsed) => println!("{}", parsed.program().notation(&workshop::WORKSHOP)),
            Err(refusal) => println!("{}", refusal.kind()),
        }
        println!("--");
    }
}
"""


# What the core finds wrong with the programs of a parser that has hardly been trained. Every
# word is known and every sentence short enough: no other kind may appear.
OF_A_POOR_PARSER = {
    "unsure",
    "incomplete_step",
    "same_reference",
    "too_many_references",
    "too_many_steps",
}


@dataclass(frozen=True)
class Trained:
    """What a short training in the second domain left."""

    model: Path
    test: Path


@pytest.fixture(scope="module")
def trained(tmp_path_factory: pytest.TempPathFactory) -> Trained:
    """Episodes, two passes of each stage, the model file."""
    folder = tmp_path_factory.mktemp("workshop")
    for split, count in (("train", 80), ("validation", 24), ("test", 24)):
        _harness(
            "episodes",
            "--split",
            split,
            "--count",
            str(count),
            out=folder / f"{split}.h5",
        )
    _harness("calibration", "--count", "40", out=folder / "calibration.h5")

    short = {
        name: replace(getattr(TrainingConfig(), name), epochs=2)
        for name in TRAINS
        if isinstance(getattr(TrainingConfig(), name), StageConfig)
    }
    with Demonstrations(folder / "train.h5") as demonstrations:
        domain, data = demonstrations.domain, training_set(demonstrations)
    with Demonstrations(folder / "validation.h5") as demonstrations:
        validation = training_set(demonstrations)
    # So little training explains no final scene.
    config = TrainingConfig(**short, attempts=1, explained=1e9)
    result = train(Curriculum(domain, data, config, seed=0), folder / "run", quiet=True)
    camera = calibrate.fit_camera(Calibration.load(folder / "calibration.h5"))
    model = calibrate.with_camera(result.model, camera)
    thresholds = calibrate.fit_thresholds(model, validation).thresholds
    path = folder / "model.safetensors"
    space = WorkSpace(WORK_SPACE.min, WORK_SPACE.max)
    write_model(path, ModelFile(model, domain, thresholds, space, training={"seed": 0}))
    write_metrics(path, {})
    return Trained(path, folder / "test.h5")


def _harness(*arguments: str, out: Path) -> None:
    full = [*arguments, "--domain", str(DOMAIN), "--out", str(out)]
    commands.main(full, standalone_mode=False)


def test_the_loaded_model_knows_the_second_domain_and_no_other(
    trained: Trained,
) -> None:
    model, domain = nsrm.Model.load(trained.model), domains.load(DOMAIN)
    assert model.info()["domain"] == domain.name
    with Demonstrations(trained.test) as demonstrations:
        image = demonstrations.initial_image(0)
        box = demonstrations.initial_boxes[0][0]
    similarities = model.similarities(model.encode_crop(nsrm.crop(image, box)))
    assert list(similarities) == [value.name for value in domain.concepts]
    with pytest.raises(nsrm.Refused) as refused:
        model.parse("put the red block on the small blue block")
    assert refused.value.kind == "unknown_word"


def test_its_network_has_the_second_domains_dimensions(trained: Trained) -> None:
    shapes = {name: array.shape for name, array in tensors(read_model(trained.model).model).items()}
    assert shapes["vision.concept.weight"] == (8, 16)
    assert shapes["action.simulator.input.weight"] == (64, 12)
    assert shapes["vision.operator.face.hidden.weight"] == (32, 32)


def test_its_sentences_get_a_plan_or_a_typed_refusal(trained: Trained) -> None:
    model, domain = nsrm.Model.load(trained.model), domains.load(DOMAIN)
    names = {value.name for value in domain.concepts}
    actions = {action.name for action in domain.actions}
    with (
        Demonstrations(trained.test) as demonstrations,
        GroundTruth(trained.test) as judge,
    ):
        for index, sentence in enumerate(demonstrations.sentences):
            truth = judge.truth(index)
            try:
                program = model.parse(sentence)
            except nsrm.Refused as refusal:
                assert refusal.kind in OF_A_POOR_PARSER
                continue
            said = {name for step in truth.program for name in (*step.object, *step.reference)}
            for step in program.steps:
                assert step.action in actions
                assert set(step.object) | set(step.reference) <= names & said


def test_its_words_for_extremes_are_parts_of_descriptions(trained: Trained) -> None:
    """To the parser they are what values are: they change nothing else."""
    model, domain = nsrm.Model.load(trained.model), domains.load(DOMAIN)
    assert model.info()["extremes"] == ["uppermost", "foremost", "largest"]
    lexicon = domain.lexicon()
    with Demonstrations(trained.test) as demonstrations:
        sentences = list(demonstrations.sentences)
    for sentence in sentences:
        plain, _ = _parsed(model, sentence)
        words = sentence.split()
        first = next(place for place, word in enumerate(words) if word in lexicon)
        for name, added in domain.extreme_words().items():
            for word in added:
                said = " ".join([*words[:first], word, *words[first:]])
                same, extremes = _parsed(model, said)
                assert same == plain, said
                assert extremes in ([], [name]), said


def _parsed(model: nsrm.Model, sentence: str) -> tuple[str, list[str]]:
    """What a sentence says but for its extremes, or the kind of the refusal; and these."""
    try:
        steps = [
            Step.from_json(
                {name: getattr(step, name) for name in ("action", "object", "reference")}
            )
            for step in model.parse(sentence).steps
        ]
    except nsrm.Refused as refusal:
        return refusal.kind, []
    plain = [replace(step, object_which=None, reference_which=None) for step in steps]
    extremes = [which for step in steps for which in (step.object_which, step.reference_which)]
    return canonical(plain), [which for which in extremes if which is not None]


def test_its_static_arrays_compile_with_core_and_understand_the_same(
    trained: Trained, tmp_path: Path
) -> None:
    crate = tmp_path / "workshop"
    (crate / "src").mkdir(parents=True)
    (crate / "Cargo.toml").write_text(
        '[package]\nname = "workshop"\nversion = "0.0.0"\nedition = "2024"\n[workspace]\n'
        f'[dependencies]\nnsrm-core = {{ path = "{ROOT / "core"}", default-features = false }}\n'
        # As in our workspace, whose dependencies are then built already.
        '[profile.dev]\ndebug = "line-tables-only"\n'
        '[profile.dev.build-override]\ndebug = "line-tables-only"\n',
        encoding="utf-8",
    )
    shutil.copy(ROOT / "Cargo.lock", crate / "Cargo.lock")
    (crate / "src" / "main.rs").write_text(MAIN_RS, encoding="utf-8")
    written = str(crate / "src" / "workshop.rs")
    # With a test of the generator, cargo builds the generator as it does for the other tests.
    _cargo("test", "--quiet", "--locked", "--workspace", "--no-run", "--test=source")
    target = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    generator = str(target / "debug" / "nsrm-codegen")
    _run(generator, str(trained.model), "--out", written, "--name", "WORKSHOP")

    model = nsrm.Model.load(trained.model)
    with Demonstrations(trained.test) as demonstrations:
        sentences = list(demonstrations.sentences)
    expected = []
    for sentence in sentences:
        try:
            expected.append(model.parse(sentence).notation.strip())
        except nsrm.Refused as refusal:
            expected.append(refusal.kind)
    said = _cargo(
        *("run", "--quiet", "--manifest-path", str(crate / "Cargo.toml")),
        *("--target-dir", str(target)),
        feed="\n".join(sentences),
    )
    assert [part.strip() for part in said.split("--\n")[:-1]] == expected


def _cargo(*arguments: str, feed: str = "") -> str:
    return _run("cargo", *arguments, feed=feed)


def _run(*command: str, feed: str = "") -> str:
    ran = subprocess.run(
        command,
        cwd=ROOT,
        input=feed,
        capture_output=True,
        text=True,
        timeout=1200,
        check=False,
    )
    assert ran.returncode == 0, ran.stderr
    return ran.stdout
