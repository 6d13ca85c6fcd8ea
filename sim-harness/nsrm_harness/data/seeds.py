"""Random generators: each kind of data has its own stream, each item its own generator.

Streams with different numbers never share a draw, whatever the seed and the index.
"""

from __future__ import annotations

import numpy as np

#: Number of each stream, a part of its generators' seed. Never reuse a number.
STREAMS = {
    "train": 1,
    "validation": 2,
    "test": 3,
    "calibration": 4,
    "demo": 5,
    "multi_attribute": 8,
    "train_restricted": 9,
    "validation_restricted": 10,
    "novel_pairs": 11,
    "objects_10": 12,
    "steps_3": 13,
    "steps_4": 14,
    "steps_5": 15,
    "steps_6": 16,
    "paraphrase": 17,
    "steps_8": 18,
    "disturbed": 19,
    "new_relations": 20,
    "objects_8": 21,
    "refusals_validation": 31,
    "refusals_test": 32,
    "perception": 41,
    "depth_noise": 42,
    "arm_steps_1": 51,
    "arm_steps_2": 52,
    "arm_steps_3": 53,
    "arm_steps_5": 54,
    "arm_stack_3": 55,
    "arm_stack_4": 56,
    "arm_control": 57,
    "figures": 58,
    "arm_disturbed": 59,
    "arm_checks": 60,
    "miscalibration": 71,
    "viewpoints": 72,
    "told": 81,
    "near_misses": 82,
    "misspelt": 83,
    "related": 84,
    "pronouns": 85,
    "mixed": 86,
    "several": 87,
    "arranged": 88,
    "apart": 89,
    "on_table": 90,
    "compounds": 91,
    "ordinals": 92,
    "repairs": 93,
    "sequences": 94,
    "distances": 95,
    "rephrased": 96,
    "shifts": 97,
    "exceptions": 98,
    "wordy": 99,
    "listed": 100,
    "between": 101,
    "perspectives": 102,
}


def generator(seed: int, stream: str, index: int) -> np.random.Generator:
    """The generator for item `index` of a stream; `seed` and `index` are not negative."""
    return np.random.default_rng(np.random.SeedSequence([seed, STREAMS[stream], index]))
