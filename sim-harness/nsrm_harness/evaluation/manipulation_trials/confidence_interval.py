"""What can't be by chance."""

from __future__ import annotations

from scipy.stats import binom

CHANCE = 0.001


def is_worse(succeeded: int, episodes: int, goal: float) -> bool:
    """Whether an arm that reaches its goal would do so badly less than once in `1 / CHANCE`
    times.

    * `goal`: the share that is to succeed
    """
    return bool(binom.cdf(succeeded, episodes, goal) < CHANCE)
