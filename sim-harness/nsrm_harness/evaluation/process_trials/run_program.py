"""Runs the program `nsrm-trials`, which makes processes work and writes down what happens."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import click

JOURNAL = "journal.jsonl"
"""Name of what is written down, in the folder of a trial."""

Decorator = Callable[[Callable[..., Any]], Callable[..., Any]]


def programs_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Where the two programs are; `cargo chaos` and its like build and name them."""
    for name in ("--nsrm-trials", "--nsrm"):
        command = click.option(
            name,
            type=click.Path(path_type=Path, dir_okay=False, exists=True),
            help=f"The program `{name[2:]}`, as cargo's alias of this command names it.",
        )(command)
    return command


def out_option(default: str) -> Decorator:
    """The folder of a trial."""
    return click.option(
        "--out",
        type=click.Path(path_type=Path, file_okay=False),
        default=Path(default),
        show_default=True,
        help="Folder for the journal and what the processes print.",
    )


def run_trial(
    trial: str, trials: Path | None, nsrm: Path | None, out: Path, options: Sequence[str]
) -> Path:
    """Runs a trial to its end and gives its journal; ends this process if it fails."""
    if trials is None or nsrm is None:
        raise click.UsageError(f"use `cargo {trial}`, which builds and names the programs")
    command = [trials, trial, "--nsrm", nsrm, "--out", out, *options]
    done = subprocess.run(command, check=False)
    if done.returncode != 0:
        sys.exit(1)
    return out / JOURNAL
