"""The command ``harness``.

Subcommands are imported when called, so that each needs only what it uses:
``harness look`` works without the training environment.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from importlib import import_module

import click

from nsrm_harness.common.errors import HarnessError

#: Name of each subcommand, its module under `commands`, and its line of help. The
#: module holds a `click.Command` named `command`.
COMMANDS = {
    "demo": "Plan a sentence in a scene and draw what comes of it.",
    "figures": "The paper's figures 2 to 5: its sentences, carried out by the arm.",
    "episodes": "Make a file of demonstrations.",
    "calibration": "Make the file from which the camera model is fitted.",
    "look": "Draw an episode: before, after, boxes and sentence.",
    "train": "Learn a model from demonstrations.",
    "detect": "Measure the detector, which needs no mask.",
    "evaluate": "The paper's metrics of a model on an episode file.",
    "baseline": "Train and measure the paper's baseline, a network without programs.",
    "refusals": "How much of what must be refused a model refuses.",
    "miscalibration": "How much of a wrong calibration the core finds, and what of right ones.",
    "tables": "The paper's tables, from nothing to a report.",
    "publish": "A finished report and its model into the project.",
    "trials": "How often the arm does what a sentence says.",
    "speed": "How fast such trials run, and where their time goes.",
    "robot": "All processes of a robot in a simulated world, for one sentence.",
    "world": "A simulated world as a robot's camera and controller.",
    "chaos": "Kill a robot's processes at random and see what becomes of its commands.",
    "soak": "A robot's processes at work for hours: what they hold, how fast they are.",
    "latency": "How fast a robot's processes answer, and what that is made of.",
    "convert": "Model files of the schema before this one, for this one.",
    "golden": "Write the golden vectors of a model file.",
}


class LazyCommands(click.Group):
    """A group that imports a subcommand when it is called."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """The names, as listed above."""
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """The subcommand, imported now; None for an unknown name."""
        if cmd_name not in COMMANDS:
            return None
        return import_module(f"nsrm_harness.cli.commands.{cmd_name}").command

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Lists the subcommands without importing any."""
        with formatter.section("Commands"):
            formatter.write_dl(list(COMMANDS.items()))


@click.command(cls=LazyCommands, context_settings={"help_option_names": ["-h", "--help"]})
def commands() -> None:
    """World, data, learning and evaluation around the NSRM library."""


def main(arguments: Sequence[str] | None = None) -> None:
    """Runs the command line; ends the process: 0 done, 2 bad input or refused."""
    try:
        commands.main(arguments, prog_name="harness")
    except HarnessError as error:
        click.echo(f"harness: {error}", err=True)
        sys.exit(2)
