"""The measured episodes, and each worker's unmeasured first one, which loads renderer, model and
planner."""

from __future__ import annotations

from dataclasses import dataclass, replace

from nsrm_harness import domain as domains
from nsrm_harness.common.errors import HarnessError
from nsrm_harness.domain import Domain
from nsrm_harness.evaluation.manipulation_trials import trial
from nsrm_harness.evaluation.manipulation_trials.episode import EpisodeResult
from nsrm_harness.evaluation.manipulation_trials.rows import ROWS, TrialRow

WARM_UP = 1_000_000
"""The index of a worker's first episode, which no measured episode has."""

_is_warm = False


class SpeedError(HarnessError):
    """Workers that do not start, or episodes that do not end the same each time."""


@dataclass(frozen=True)
class SpeedEpisode:
    """One episode of the trials."""

    row: TrialRow
    seed: int
    index: int
    domain: Domain

    def carry_out(self) -> EpisodeResult:
        """Runs it, with the same result in any process."""
        return trial.run(self.row, self.seed, self.index, domain=self.domain)


def mixed(count: int, seed: int) -> list[SpeedEpisode]:
    """The first episodes of the trials, from all rows in turn."""
    domain = domains.load()
    return [SpeedEpisode(ROWS[n % len(ROWS)], seed, n // len(ROWS), domain) for n in range(count)]


def warm_up(episode: SpeedEpisode) -> bool:
    """Runs a similar episode if this process has not run one yet; returns whether it did."""
    global _is_warm
    if _is_warm:
        return False
    replace(episode, row=ROWS[0], index=WARM_UP).carry_out()
    _is_warm = True
    return True
