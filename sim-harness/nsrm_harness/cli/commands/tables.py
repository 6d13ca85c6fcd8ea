"""``harness tables``: reproduces the paper's tables, from scratch to a report."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from nsrm_harness.cli.commands.options import domain_option, jobs_option, ray_option, workers_of


@click.command("tables")
@click.option("--quick", is_flag=True, help="One seed on a fifth of the data.")
@click.option(
    "--variants",
    "with_variants",
    is_flag=True,
    help="Also train and judge the variants; takes much longer.",
)
@domain_option
@click.option(
    "--out",
    type=click.Path(path_type=Path),
    show_default="runs/tables, with --quick runs/tables-quick",
    help="Folder for data, models, figures and the report.",
)
@click.option(
    "--data-seed",
    type=click.IntRange(0),
    default=1,
    show_default=True,
    help="Seed of all episodes.",
)
@jobs_option
@ray_option
def command(
    quick: bool,
    with_variants: bool,
    domain_path: Path,
    out: Path | None,
    data_seed: int,
    jobs: int,
    ray: str | None,
) -> None:
    """Make data, models and baselines, judge them on all splits, and write OUT/report/.

    After Ctrl-C, the same command resumes.
    """
    from nsrm_harness import domain as domains

    domain = domains.load(domain_path)
    folder = out or Path("runs") / ("tables-quick" if quick else "tables")
    try:
        # A cluster on this machine is forked, which must happen before JAX starts threads.
        with workers_of(jobs, ray) as workers:
            from nsrm_harness.paper.tables.compare import compare
            from nsrm_harness.paper.tables.run_tables import Tables
            from nsrm_harness.paper.tables.study import full_study, quick_study
            from nsrm_harness.paper.tables.tables_report import REPORT, write_report
            from nsrm_harness.paper.tables.variants import disturbed_sets, variants

            study = quick_study(data_seed) if quick else full_study(data_seed)
            tables = Tables(study, domain, folder, workers)
            outcome, comparison = tables.make(), None
            if with_variants:
                comparison = compare(tables, variants(study), disturbed_sets(study))
    except KeyboardInterrupt:
        click.echo(f"{folder}: interrupted; run the same command to resume", err=True)
        sys.exit(130)
    write_report(outcome, study, domain, folder / "report", comparison)
    click.echo(f"report: {folder / 'report' / REPORT}")
