"""Runs a study from scratch to figures: data, models, baselines, metrics. Finished parts are kept.

Everything is in one folder, which belongs to one study: figures of different studies are never
mixed. The folder records every commit at which something in it was made, for the report.
"""

from __future__ import annotations

import hashlib
import json
import subprocess
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import get_args

import nsrm
from tqdm import tqdm

from nsrm_harness.common.errors import HarnessError
from nsrm_harness.common.json_text import json_text
from nsrm_harness.common.workers import LocalProcesses, Workers
from nsrm_harness.data.calibration import make_calibration
from nsrm_harness.data.generate import Settings, ShardProgress, generate
from nsrm_harness.domain import Domain
from nsrm_harness.evaluation.observed import Boxes
from nsrm_harness.evaluation.refusals.measure import RefusalReport, measure
from nsrm_harness.learning.run_training import Files
from nsrm_harness.paper.tables import detections
from nsrm_harness.paper.tables.detections import DetectorRow, Sighting, detect_all
from nsrm_harness.paper.tables.judging import Contender, Judging, judge_all
from nsrm_harness.paper.tables.processes import ProcessTask, run_all
from nsrm_harness.paper.tables.results import ResultRow, write_json
from nsrm_harness.paper.tables.study import FAMILIES, Family, Study
from nsrm_harness.paper.tables.times import PartTime, ReportTimes
from nsrm_harness.paper.tables.trainings import Training, packed, train, train_elsewhere, unpack

REFUSAL_SETS = ("validation", "test")
TRAININGS = "models and baselines"
FIRST_MODELS = "of these, until the models of the full data were done"
"""Name of a part of the training time."""


class StudyError(HarnessError):
    """A folder that belongs to another study."""


@dataclass(frozen=True)
class SeedReport:
    """What one seed's model refuses."""

    seed: int
    report: RefusalReport


@dataclass(frozen=True)
class TablesResult:
    """All results for the report."""

    rows: tuple[ResultRow, ...]
    refusals: tuple[SeedReport, ...]
    """For each model: on validation, where thresholds are chosen, and on test."""
    detections: tuple[DetectorRow, ...]
    commits: tuple[str, ...]
    """The commits at which it was made."""
    model: Path
    """The first seed's model file, which the plots show."""
    episodes: Path
    """The test episodes that the plots show."""
    times: tuple[PartTime, ...]
    processes: int
    """Number of parallel processes."""


class Tables:
    """Runs one study in one folder."""

    def __init__(
        self,
        study: Study,
        domain: Domain,
        folder: Path,
        workers: Workers,
    ) -> None:
        """Raises `StudyError` if the folder belongs to another study."""
        self.study, self._domain, self.folder = study, domain, folder
        self.workers = workers
        self._commits = self._claim()
        self._times = ReportTimes(folder / "times.json")

    def make(self) -> TablesResult:
        """Makes everything; a further call resumes an interrupted run."""
        with self._times.of("data"):
            for split in self.study.splits():
                self.make_episodes(split, self.study.settings(split))
            self._make_calibration()
        with self._times.of(TRAININGS):
            self._train()
        with self._times.of("judging"):
            rows = [row for rows in self.judge(self._judgings(), "judging") for row in rows]
        with self._times.of("refusals"):
            refusals = tuple(
                SeedReport(seed, self._refusals(name, seed))
                for name in REFUSAL_SETS
                for seed in self.study.seeds
            )
        with self._times.of("detector"):
            seen = detect_all(self._sightings(), self.folder / "figures", self.workers.count)
        return TablesResult(
            rows=tuple(rows),
            refusals=refusals,
            detections=seen,
            commits=self._commits,
            model=self.model(FAMILIES[0], self.study.seeds[0]),
            episodes=self.data("test"),
            times=self._times.all(),
            processes=self.workers.count,
        )

    def model(self, family: Family, seed: int) -> Path:
        """The model file of a family and a seed."""
        return self._run_of("nsrm", family, seed) / "model.safetensors"

    def _claim(self) -> tuple[str, ...]:
        content = {
            "study": json.loads(json_text(asdict(self.study))),
            "domain": json.loads(self._domain.as_json()),
        }
        note = self.folder / "study.json"
        commits: list[str] = []
        if note.exists():
            found = json.loads(note.read_text(encoding="utf-8"))
            commits = found["commits"]
            for what, own in content.items():
                if found[what] != own:
                    raise StudyError(
                        f"{note}: the folder belongs to another {what}: use another --out, or "
                        "remove the folder to start from scratch"
                    )
        commits = list(dict.fromkeys([*commits, commit()]))
        self.folder.mkdir(parents=True, exist_ok=True)
        write_json(note, content | {"commits": commits})
        return tuple(commits)

    def data(self, name: str) -> Path:
        """Path of a file of episodes."""
        return self.folder / "data" / f"{name}.h5"

    @property
    def runs(self) -> Path:
        """Where each training has a folder."""
        return self.folder / "runs"

    def _run_of(self, kind: str, family: Family, seed: int) -> Path:
        return self.runs / f"{kind}-{family.name}-{seed}"

    def files(self, family: Family) -> Files:
        """The files that a family's trainings read."""
        return Files(
            train=self.data(family.train),
            validation=self.data(family.validation),
            test=self.data("test" if "test" in family.judged else family.judged[0]),
            calibration=self.data("calibration"),
        )

    def make_episodes(self, name: str, settings: Settings) -> None:
        """Makes a file of episodes, unless it exists."""
        with tqdm(total=settings.count, unit="episode", desc=f"{name:>22}") as bar:

            def report(progress: ShardProgress) -> None:
                bar.update(progress.done - bar.n)

            generate(settings, self._domain, self.data(name), self.workers, report)

    def _make_calibration(self) -> None:
        path, scenes = self.data("calibration"), self.study.calibration_scenes
        if path.exists():
            return
        with tqdm(total=scenes, unit="scene", desc=f"{'calibration':>22}") as bar:
            make_calibration(
                self._domain, path, scenes=scenes, seed=self.study.data_seed, report=bar.update
            )

    def _train(self) -> None:
        """Trains what is not trained yet."""
        missing = [training for training in self._trainings() if not training.is_done]
        with self._times.of(FIRST_MODELS) as end:
            waited = {self._run_of("nsrm", FAMILIES[0], seed) for seed in self.study.seeds}
            waited &= {training.out for training in missing}

            def done(*folders: Path) -> None:
                waited.difference_update(folders)
                if not waited:
                    end()

            done()
            if isinstance(self.workers, LocalProcesses):
                tasks = [ProcessTask(t.out.name, train, (t,), t.out / "log.txt") for t in missing]
                run_all(tasks, self.workers.count, TRAININGS, lambda task: done(task.log.parent))
                return
            sent = ((training.out, packed(training)) for training in missing)
            with tqdm(total=len(missing), desc=f"{TRAININGS:>22}") as bar:
                for out, made in self.workers.each(train_elsewhere, sent):
                    unpack(made, out)
                    bar.update()
                    done(out)

    def _trainings(self) -> list[Training]:
        """All trainings: the first family's models first, except that a baseline comes second, so
        that what XLA compiles for the first model serves the others."""
        trainings = [
            Training(self.files(family), config, seed, self._run_of(kind, family, seed))
            for family in FAMILIES
            for kind, config in (("nsrm", self.study.config), ("baseline", self.study.baseline))
            for seed in self.study.seeds
        ]
        count = len(self.study.seeds)
        first, *models = trainings[:count]
        baseline, *others = trainings[count:]
        return [first, baseline, *models, *others]

    def judge(self, judgings: Sequence[Judging], title: str) -> list[list[ResultRow]]:
        """The rows of each task, computed on this machine unless cached."""
        return judge_all(judgings, self.folder / "figures", self.workers.count, title)

    def models(self, family: Family) -> tuple[Contender, ...]:
        """A family's models, of all seeds."""
        return tuple(Contender("nsrm", seed, self.model(family, seed)) for seed in self.study.seeds)

    def _judgings(self) -> list[Judging]:
        """The tasks for all tables, in the order of their rows."""
        judgings = []
        for family in FAMILIES:
            models, baselines = self.models(family), self._baselines(family)
            for split in family.judged:
                data = self.data(split)
                judgings += [Judging(split, data, models, boxes) for boxes in get_args(Boxes)]
                judgings.append(Judging(split, data, baselines, None))
        return judgings

    def _sightings(self) -> list[Sighting]:
        """The sets of scenes for measuring the detector."""
        seed, few = self.study.data_seed, self.study.settings("test").count // 10
        files = [(name, self.data(name), detections.SCENES) for name in detections.SPLITS]
        return [
            Sighting(name, noise, data, self._domain, count, seed)
            for name, data, count in [*files, (detections.AFTER, None, few)]
            for noise in detections.NOISES_MM
        ]

    def _baselines(self, family: Family) -> tuple[Contender, ...]:
        runs = [(seed, self._run_of("baseline", family, seed)) for seed in self.study.seeds]
        return tuple(
            Contender("baseline", seed, run / "baseline.safetensors") for seed, run in runs
        )

    def _refusals(self, which: str, seed: int) -> RefusalReport:
        model = nsrm.Model.load(self.model(FAMILIES[0], seed))
        return measure(model, self.data(which), which, self.study.refusals)


def commit() -> str:
    """The state of the project: its commit, with a hash of uncommitted changes."""
    here = Path(__file__).resolve().parent
    try:
        name = _git(here, "rev-parse", "--short=12", "HEAD").strip()
        changes = _git(here, "diff", "HEAD")
    except (OSError, subprocess.CalledProcessError):
        return "unknown"
    if not changes:
        return name
    return f"{name} with changes {hashlib.sha256(changes.encode()).hexdigest()[:8]}"


def _git(where: Path, *arguments: str) -> str:
    return subprocess.run(
        ["git", *arguments], cwd=where, capture_output=True, text=True, check=True
    ).stdout
