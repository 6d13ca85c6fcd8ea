"""Writes the report's sections on variants (an ablation study) and on disturbed scenes."""

from __future__ import annotations

from statistics import fmean, pstdev

from nsrm_harness.paper.tables.compare import BEFORE, Comparison
from nsrm_harness.paper.tables.lines import HEADINGS, TITLES, cells_of, line_of
from nsrm_harness.paper.tables.results import select, summarize
from nsrm_harness.paper.tables.variants import DISTURBED, EXACT, SAMPLED, VARIED
from nsrm_harness.paper.tables.variants import JUDGED as COMPARED


def comparison_sections(comparison: Comparison) -> list[str]:
    """Headings, tables and text of both sections."""
    models = list(dict.fromkeys(row.model for row in comparison.rows))
    seconds = {
        name: sum(cost.seconds for cost in comparison.costs if cost.variant == name)
        for name in models
    }
    headings = [f"{name}, {split}" for split in COMPARED for name in ("program", "IoU-3D")]
    lines = [line_of("variant", [*headings, "seeds", "minutes"])]
    lines.append("|---|" + "---:|" * (len(headings) + 2))
    for name in models:
        cells, count = [], 0
        for split in COMPARED:
            chosen = select(comparison.rows, split, name, "mask")
            program, _, _, _, volume = cells_of(chosen)
            cells += [program, volume]
            count = len(chosen)
        minutes = f"{seconds[name] / count / 60:.1f}" if seconds[name] else ""
        lines.append(line_of(name, [*cells, str(count), minutes]))
    merged = ", ".join(f"{name} (seed {seed})" for name, seed in comparison.merged)
    return [
        "## What the parts are worth",
        "The same data, with one change in each row; minutes of wall time per seed, beside other "
        "work. Mean over the seeds, with the lowest and highest in brackets.",
        "\n".join(lines),
        *([f"Two actions were learned as one by: {merged}."] if merged else []),
        *_reinforce(comparison),
        "## Disturbed scenes and amounts of data",
        "The scenes are the same at each size. At size 1 the camera is displaced by up to "
        f"{VARIED.camera_m * 1e3:.0f} mm along each axis and rotated by up to "
        f"{VARIED.camera_deg:g}°, light varies by up to {VARIED.light:.0%}, colours by up to "
        f"{VARIED.color:.0%}, and depth has noise of {VARIED.depth_m * 1e3:.0f} mm.",
        "![accuracy against disturbance and data](comparison.png)",
        _disturbed_table(comparison),
    ]


def _reinforce(comparison: Comparison) -> list[str]:
    """Compares the sampled splitter with the exact one, seed by seed."""
    told = []
    for exact, sampled, when in (
        (EXACT, SAMPLED, "At the end"),
        (EXACT + BEFORE, SAMPLED + BEFORE, "Before the last stage, which also trains the splitter"),
    ):
        for split in COMPARED:
            means = [
                summarize(select(comparison.rows, split, name, "mask"), "program")
                for name in (exact, sampled)
            ]
            own = select(comparison.rows, split, sampled, "mask")
            if means[0] is None or means[1] is None:
                continue
            near = sum(abs((row.program or 0.0) - means[0].mean) <= 1.0 for row in own)
            deviations = [
                pstdev(row.program or 0.0 for row in select(comparison.rows, split, name, "mask"))
                for name in (exact, sampled)
            ]
            told.append(
                f"{when}, {TITLES[split]}: {near} of {len(own)} seeds are within 1 point of the "
                f"exact splits' mean; standard deviation over the seeds {deviations[0]:.2f} exact, "
                f"{deviations[1]:.2f} sampled."
            )
    if not told:
        return []
    costs = {
        name: fmean(
            sum(c.seconds for c in comparison.costs if (c.variant, c.seed) == (name, seed))
            for seed in sorted({c.seed for c in comparison.costs if c.variant == name})
        )
        for name in (EXACT, SAMPLED)
    }
    ratio = costs[SAMPLED] / costs[EXACT]
    items = "\n".join(f"- {line}" for line in told)
    return [f"REINFORCE takes {ratio:.2f} times as long.\n\n{items}"]


def _disturbed_table(comparison: Comparison) -> str:
    models = list(dict.fromkeys(row.model for _, rows in comparison.disturbed for row in rows))
    lines = [line_of(DISTURBED, [f"{HEADINGS[0]}, {m} | {HEADINGS[-1]}, {m}" for m in models])]
    lines.append("|---|" + "---:|" * (2 * len(models)))
    for each, rows in comparison.disturbed:
        cells: list[str] = []
        for model in models:
            program, _, _, _, volume = cells_of([row for row in rows if row.model == model])
            cells += [program, volume]
        name = each.kind if each.size == 0.0 else f"{each.kind}, {each.size:g}"
        lines.append(line_of(name, cells))
    return "\n".join(lines)
