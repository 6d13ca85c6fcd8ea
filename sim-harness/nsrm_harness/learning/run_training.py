"""Runs a training: trains, fits camera and thresholds, writes the model, and evaluates it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path

import jax
import nsrm

from nsrm_harness.data.calibration import Calibration
from nsrm_harness.data.file import Demonstrations
from nsrm_harness.evaluation import metrics as evaluate
from nsrm_harness.learning import calibrate, curves
from nsrm_harness.learning.checkpoint import TrainingProgress
from nsrm_harness.learning.config import TrainingConfig
from nsrm_harness.learning.dataset import training_set
from nsrm_harness.learning.export import ModelFile, WorkSpace, write_metrics, write_model
from nsrm_harness.learning.model import Model
from nsrm_harness.learning.naming import name_actions
from nsrm_harness.learning.stages import TrainingError
from nsrm_harness.learning.train import TRAINS, Callbacks, Curriculum, train
from nsrm_harness.simulation.layout import WORK_SPACE

Fitting = Callable[[], ModelFile]
"""Makes a model file from a model in training."""


@dataclass(frozen=True)
class Files:
    """The input files of a run, made by `harness episodes` and `harness calibration`."""

    train: Path
    validation: Path
    test: Path
    calibration: Path

    @classmethod
    def of(cls, folder: Path) -> Files:
        """The files in a folder, with their usual names."""
        names = ("train", "validation", "test", "calibration")
        return cls(*(folder / f"{name}.h5" for name in names))


@dataclass(frozen=True)
class Fitted:
    """A model with its camera map and thresholds, and details of its training."""

    file: ModelFile
    named: bool
    """Whether each action was learned separately."""
    seconds: dict[str, float]
    """Time spent, by stage."""


def fit(
    files: Files,
    config: TrainingConfig,
    seed: int,
    out: Path,
    resume: bool = False,
    say: Callable[[str], None] = print,
    after_stage: Callable[[str, Fitting], None] = lambda name, fitting: None,
) -> Fitted:
    """Trains, then fits camera and thresholds; leaves `curves.png` and a checkpoint in `out`.

    `after_stage` gets a function that makes a model file from the model after that stage.
    """
    with Demonstrations(files.train) as demonstrations:
        domain, data = demonstrations.domain, training_set(demonstrations)
        training_camera = demonstrations.only_camera()
    with Demonstrations(files.validation) as demonstrations:
        validation = training_set(demonstrations)
    camera = calibrate.fit_camera(Calibration.load(files.calibration))
    say(f"camera map: {camera.median_m * 1e3:.2f} mm median, {camera.p95_m * 1e3:.2f} mm p95")

    def fitted(model: Model, progress: TrainingProgress) -> ModelFile:
        certainty = calibrate.fit_certainty(model, validation)
        say(
            f"certainty of actions: {certainty.before:.4f}, right {certainty.right:.4f}; logits "
            f"scaled by {certainty.scale:.2f}"
        )
        model = calibrate.with_certainty(calibrate.with_camera(model, camera), certainty)
        found = calibrate.fit_thresholds(model, validation)
        say(
            f"match score {found.thresholds.match_score:.3f}: between {found.plateau[0]:.3f} and "
            f"{found.plateau[1]:.3f} a share of {found.share:.1%} of the references has one match; "
            f"decision {found.thresholds.decision:.2f} (lowest on validation "
            f"{found.lowest_confidence:.4f})"
        )
        done = list(TRAINS)[: progress.stage]
        training = {
            "seed": seed,
            "attempt": progress.attempt,
            "episodes": len(data),
            "data_hash": data.hash(),
            "stages": {name: asdict(getattr(config, name)) for name in done},
            "jax": jax.__version__,
        }
        space = WorkSpace(WORK_SPACE.min, WORK_SPACE.max)
        return ModelFile(
            model,
            domain,
            found.thresholds,
            space,
            training_camera=training_camera,
            training=training,
        )

    def stage_done(name: str, model: Model, progress: TrainingProgress) -> None:
        after_stage(name, lambda: fitted(name_actions(model, domain)[0], progress))

    curriculum = Curriculum(domain, data, config, seed)
    result = train(curriculum, out, resume, callbacks=Callbacks(after_stage=stage_done))
    curves.draw_curves(result.progress, out / "curves.png")
    file = fitted(result.model, result.progress)
    return Fitted(file, result.named, result.progress.seconds)


def finish(
    fitted: Fitted, test: Path, out: Path, say: Callable[[str], None] = print
) -> evaluate.Metrics:
    """Writes `model.safetensors` to `out`; returns its metrics on test.

    Raises `TrainingError` if the model learned two actions as one.
    """
    if not fitted.named:
        raise TrainingError(
            f"seed {fitted.file.training['seed']}: two actions were learned as one (see "
            f"{out / 'curves.png'}); train with more episodes or with another --seed"
        )
    path = out / "model.safetensors"
    write_model(path, fitted.file)
    metrics = evaluate.evaluate(nsrm.Model.load(path), test)
    write_metrics(path, metrics.as_json())
    say(str(metrics))
    say(f"model: {path}")
    return metrics
