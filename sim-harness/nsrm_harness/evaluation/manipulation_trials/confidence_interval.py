"""Tells failure rates that chance explains from those that it does not."""

from __future__ import annotations

from scipy.stats import binom

CHANCE = 0.001


def is_worse(succeeded: int, episodes: int, goal: float) -> bool:
    """Whether an arm that meets the goal would do this badly with a probability below `CHANCE`.

    * `goal`: share of episodes that must succeed
    """
    return bool(binom.cdf(succeeded, episodes, goal) < CHANCE)
