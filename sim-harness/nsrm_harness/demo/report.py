"""Reports a demonstration as text and as JSON."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import zip_longest
from typing import Any

import nsrm

from nsrm_harness.visualization.demo_listener import StepResult


def as_text(plan: nsrm.Plan, names: Mapping[int, str], outcomes: Sequence[StepResult]) -> str:
    """Program, groundings, sub-goals, explanations and outcomes, one per line."""
    lines = [*map(str, plan.program.corrections), "program"]
    lines += [f"  {line}" for line in plan.program.notation.splitlines()]
    for number, (step, outcome) in enumerate(zip_longest(plan.steps, outcomes), start=1):
        x, y, z = step.position
        orientation = ", ".join(f"{value:g}" for value in step.orientation)
        lines += [
            f"step {number}, confidence {step.confidence:.3f}",
            f"  moves      object {step.object_id}, seen as {names[step.object_id]}"
            f" (score {step.object_score:.3f})",
            f"  refers to  object {step.reference_id}, seen as {names[step.reference_id]}"
            f" (score {step.reference_score:.3f})",
            f"  sub-goal   position ({x:.4f}, {y:.4f}, {z:.4f}) m, quaternion ({orientation})",
            f"  because    {step.explanation}",
            f"  outcome    {outcome or 'not started'}",
        ]
    return "\n".join(lines)


def as_json(plan: nsrm.Plan, outcomes: Sequence[StepResult]) -> dict[str, Any]:
    """The plan as in `nsrm plan --json`, with the outcome of each step."""
    return {
        "program": plan.program.notation,
        "corrections": [
            {"word": each.word, "read_as": each.read_as} for each in plan.program.corrections
        ],
        "steps": [
            {
                "action": step.action,
                "object": step.object,
                "reference": step.reference,
                "object_id": step.object_id,
                "reference_id": step.reference_id,
                "object_anchor_ids": step.object_anchor_ids,
                "reference_anchor_ids": step.reference_anchor_ids,
                "confidence": step.confidence,
                "sub_goal": {
                    "position": [float(value) for value in step.position],
                    "orientation": [float(value) for value in step.orientation],
                },
                "location": [float(value) for value in step.location],
                "explanation": step.explanation,
                "outcome": None if outcome is None else outcome.as_json(),
            }
            for step, outcome in zip_longest(plan.steps, outcomes)
        ],
    }
