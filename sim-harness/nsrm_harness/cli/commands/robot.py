"""``harness robot``: runs all processes of a simulated robot for one sentence."""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path

import click

from nsrm_harness.cli.commands.options import arm_option, seed_option
from nsrm_harness.nodes.processes import ProcessGroup


@click.command("robot")
@click.argument("sentence", required=False)
@seed_option
@arm_option
@click.option(
    "--nsrm",
    type=click.Path(path_type=Path, dir_okay=False, exists=True),
    required=True,
    help="Path of the command `nsrm`; `cargo robot` builds and passes it.",
)
@click.option(
    "--config",
    type=click.Path(path_type=Path, dir_okay=False, exists=True),
    help="Configuration (TOML) for all of the robot's processes.",
)
@click.option("--open-loop", is_flag=True, help="Do not observe after each step, as in the paper.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON, one line per event.")
def command(
    sentence: str | None,
    seed: int,
    with_arm: bool,
    nsrm: Path,
    config: Path | None,
    open_loop: bool,
    as_json: bool,
) -> None:
    """Execute SENTENCE in the scene of a seed; by default a sentence that fits.

    Starts world, perception and planner as the processes of a separate robot, sends the sentence,
    reports its progress, and stops them. Ctrl-C stops the robot first.

    Exit code 2 if it was refused or not done.
    """
    place = ["--robot", f"demo-{os.getpid()}"]
    place += ["--config", str(config)] if config else []
    with ProcessGroup() as processes:
        arm = "--arm" if with_arm else "--no-arm"
        world = [sys.executable, "-m", "nsrm_harness.cli", "world"]
        world += [*place, "--seed", str(seed), arm, "--json"]
        ready = json.loads(processes.start("world", world, '"ready"'))["ready"]
        processes.start("perception", [str(nsrm), "perceive", *place], "perceiving")
        processes.start("planner", [str(nsrm), "serve", *place], "planning")
        said = sentence or ready["sentence"]
        if not as_json:
            click.echo(f'sentence  "{said}"\nscene     seed {seed}; boxes from the detector')
        options = ["--open-loop"] * open_loop + ["--json"] * as_json
        code = processes.run([str(nsrm), "say", *place, *options, "--", said])
    sys.exit(code)
