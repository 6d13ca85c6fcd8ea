"""A whole run: train, fit camera and thresholds, write the model, judge it through the core."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path

import jax

from nsrm_harness import evaluate
from nsrm_harness.episodes.calibration import Calibration
from nsrm_harness.episodes.file import Demonstrations
from nsrm_harness.learn import calibrate, curves
from nsrm_harness.learn.config import TrainingConfig
from nsrm_harness.learn.dataset import training_set
from nsrm_harness.learn.export import ModelFile, WorkSpace, write_metrics, write_model
from nsrm_harness.learn.stages import TrainingError
from nsrm_harness.learn.train import TRAINS, train
from nsrm_harness.world.layout import WORK_SPACE


@dataclass(frozen=True)
class Files:
    """What a run reads; all made by `harness episodes` and `harness calibration`."""

    train: Path
    validation: Path
    test: Path
    calibration: Path

    @classmethod
    def of(cls, folder: Path) -> Files:
        """The files of a folder, under their usual names."""
        names = ("train", "validation", "test", "calibration")
        return cls(*(folder / f"{name}.h5" for name in names))


def run(
    files: Files,
    config: TrainingConfig,
    seed: int,
    out: Path,
    resume: bool = False,
    say: Callable[[str], None] = print,
) -> evaluate.Metrics:
    """Leaves `model.safetensors` and `curves.png` in `out`; returns the metrics on test."""
    import nsrm

    with Demonstrations(files.train) as demonstrations:
        domain, data = demonstrations.domain, training_set(demonstrations)
    with Demonstrations(files.validation) as demonstrations:
        validation = training_set(demonstrations)
    result = train(domain, data, config, seed, out, resume)
    curves.draw_curves(result.progress, out / "curves.png")
    if not result.named:
        raise TrainingError(
            f"seed {seed}: two actions were learned as one (see {out / 'curves.png'}); "
            "train with more episodes or with another --seed"
        )
    camera = calibrate.fit_camera(Calibration.load(files.calibration))
    say(f"camera map: {camera.median_m * 1e3:.2f} mm median, {camera.p95_m * 1e3:.2f} mm p95")
    model = calibrate.with_camera(result.model, camera)
    fit = calibrate.fit_thresholds(model, validation)
    say(
        f"match score {fit.thresholds.match_score:.3f}: between {fit.plateau[0]:.3f} and "
        f"{fit.plateau[1]:.3f} a share of {fit.share:.1%} of the references has one match; "
        f"decision {fit.thresholds.decision:.2f} (lowest on validation "
        f"{fit.lowest_confidence:.4f})"
    )
    path = out / "model.safetensors"
    write_model(
        path,
        ModelFile(
            model,
            domain,
            fit.thresholds,
            WorkSpace(WORK_SPACE.min, WORK_SPACE.max),
            training={
                "seed": seed,
                "attempt": result.progress.attempt,
                "episodes": len(data),
                "data_hash": data.hash(),
                "stages": {name: asdict(getattr(config, name)) for name in TRAINS},
                "jax": jax.__version__,
            },
        ),
    )
    metrics = evaluate.evaluate(nsrm.Model.load(path), files.test)
    write_metrics(path, metrics.as_json())
    say(str(metrics))
    say(f"model: {path}")
    return metrics
