"""``harness robot``: all processes of a robot in a simulated world, for one sentence."""

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
    help="The command `nsrm`; `cargo robot` builds and names it.",
)
@click.option(
    "--config",
    type=click.Path(path_type=Path, dir_okay=False, exists=True),
    help="The robot's configuration (TOML), for all of its processes.",
)
@click.option("--open-loop", is_flag=True, help="Don't look after each step, as in the paper.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON, a line for each event.")
def command(
    sentence: str | None,
    seed: int,
    with_arm: bool,
    nsrm: Path,
    config: Path | None,
    open_loop: bool,
    as_json: bool,
) -> None:
    """Have SENTENCE carried out in the scene of a seed; without one, one that fits.

    Starts world, perception and planner as processes of a robot of their own, says the
    sentence, follows what becomes of it, and stops them. Ctrl-C stops the robot first.
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
