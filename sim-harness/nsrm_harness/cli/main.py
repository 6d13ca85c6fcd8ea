"""Defines the command ``harness``.

Subcommands are imported when they are called, so that each needs only what it uses:
``harness look`` works without the training environment.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from importlib import import_module

import click

from nsrm_harness.common.errors import HarnessError

#: The name of each subcommand, which is also its module under `commands`, and its help line. The
#: module has a `click.Command` named `command`.
COMMANDS = {
    "demo": "Plan a sentence in a scene, execute it, and draw the result.",
    "figures": "Reproduce the paper's figures 2 to 5 with the arm.",
    "episodes": "Generate a file of demonstrations.",
    "sentences": "Tell demonstrations in everyday wording.",
    "calibration": "Generate the file to which the camera model is fitted.",
    "look": "Draw an episode: before, after, boxes and sentence.",
    "train": "Train a model on demonstrations.",
    "wording": "Teach a trained model everyday wording.",
    "detect": "Measure the detector, which works without the mask.",
    "evaluate": "Evaluate a model on an episode file with the paper's metrics.",
    "baseline": "Train and measure the paper's baseline, a network without programs.",
    "refusals": "Measure how many of the sentences that must be refused a model refuses.",
    "language": "Measure which sentences a model understands, and which it refuses.",
    "calibrate": "Find the least confidence at which few of the accepted commands are wrong.",
    "miscalibration": "Measure how many camera miscalibrations the core detects.",
    "viewpoints": "Measure plans through other cameras than that of the training.",
    "tables": "Reproduce the paper's tables, from scratch to a report.",
    "publish": "Copy a finished report and its model into the project.",
    "trials": "Measure how often the arm does what a sentence says.",
    "speed": "Measure how fast such trials run, and where their time goes.",
    "robot": "Run all processes of a simulated robot for one sentence.",
    "world": "Run a simulated world as a robot's camera and controller.",
    "chaos": "Kill a robot's processes at random and check that no command is lost.",
    "soak": "Run a robot's processes for hours; measure their resources and speed.",
    "latency": "Measure how fast a robot's processes answer, and why.",
    "convert": "Convert model files of the previous schema.",
    "golden": "Write the golden vectors of a model file.",
    "onnx": "Write a model file as ONNX graphs, for `cargo compare`.",
    "comparison": "Plot the times of `cargo compare`.",
    "growth": "Plot how the work of a plan grows with scene, sentence and domain.",
    "quantised": "Judge a model with its weights as trained and rounded.",
    "footprint": "Plot what a micro-controller's image consists of.",
}


class LazyCommands(click.Group):
    """A group that imports a subcommand when it is called."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """The names, in the order above."""
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Imports a subcommand; None for an unknown name."""
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
    """Runs the command line and exits: 0 done, 2 bad input or refused."""
    try:
        commands.main(arguments, prog_name="harness")
    except HarnessError as error:
        click.echo(f"harness: {error}", err=True)
        sys.exit(2)
