"""JSON without numbers that JSON does not have."""

from __future__ import annotations

import json

import numpy as np
import pytest

from nsrm_harness.common.json_text import json_text

NAN, INFINITE = float("nan"), float("inf")


def test_what_is_finite_or_absent_is_written_as_ever() -> None:
    content = {"a": [1, 2.5, None, True], "b": {"c": "ß", "d": (np.float64(0.1),)}}
    assert json_text(content) == json.dumps(content)
    options = {"indent": 1, "ensure_ascii": False, "sort_keys": True, "separators": (",", ":")}
    assert json_text(content, **options) == json.dumps(content, **options)


@pytest.mark.parametrize(
    ("content", "where"),
    [
        (NAN, "the content is nan"),
        ({"metrics": {"median": NAN}}, "metrics.median is nan"),
        ([0.0, (1.0, -INFINITE)], r"\[1\]\[1\] is -inf"),
        ({"steps": [{"off": np.float64(INFINITE)}]}, r"steps\[0\].off is inf"),
    ],
)
def test_a_number_that_json_does_not_have_is_refused_with_its_place(
    content: object, where: str
) -> None:
    with pytest.raises(ValueError, match=where):
        json_text(content)
