"""Runs the program `nsrm-trials`, which puts processes under load and keeps a journal."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import click

JOURNAL = "journal.jsonl"
"""File name of the journal in a trial's folder."""

Decorator = Callable[[Callable[..., Any]], Callable[..., Any]]


def programs_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Options for the paths of the two programs; `cargo chaos` and the like pass them."""
    for name in ("--nsrm-trials", "--nsrm"):
        command = click.option(
            name,
            type=click.Path(path_type=Path, dir_okay=False, exists=True),
            help=f"Path of the program `{name[2:]}`; the cargo alias of this command passes it.",
        )(command)
    return command


def out_option(default: str) -> Decorator:
    """Option for the folder of a trial."""
    return click.option(
        "--out",
        type=click.Path(path_type=Path, file_okay=False),
        default=Path(default),
        show_default=True,
        help="Folder for the journal and the output of the processes.",
    )


def run_trial(
    trial: str, trials: Path | None, nsrm: Path | None, out: Path, options: Sequence[str]
) -> Path:
    """Runs a trial to its end and returns the path of its journal; exits if it fails."""
    if trials is None or nsrm is None:
        raise click.UsageError(f"use `cargo {trial}`, which builds the programs it needs")
    command = [trials, trial, "--nsrm", nsrm, "--out", out, *options]
    done = subprocess.run(command, check=False)
    if done.returncode != 0:
        sys.exit(1)
    return out / JOURNAL
