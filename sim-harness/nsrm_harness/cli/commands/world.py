"""``harness world``: runs a simulated world as a robot's camera and controller."""

from __future__ import annotations

import signal
import threading
from contextlib import closing
from pathlib import Path

import click

from nsrm_harness import domain as domains
from nsrm_harness.cli.commands.options import arm_option, seed_option
from nsrm_harness.common.json_text import json_text
from nsrm_harness.nodes.config import read_config
from nsrm_harness.nodes.simulated_robot import SimulatedRobot
from nsrm_harness.simulation.render import open_renderer


@click.command("world")
@click.option("--robot", help="Name of the robot.  [default: (the file's, or `robot`)]")
@click.option(
    "--config",
    "file",
    type=click.Path(path_type=Path, dir_okay=False),
    help="The robot's configuration (TOML), the same as for `nsrm`.",
)
@seed_option
@arm_option
@click.option("--json", "as_json", is_flag=True, help="Print JSON when ready.")
def command(robot: str | None, file: Path | None, seed: int, with_arm: bool, as_json: bool) -> None:
    """Run the tabletop of a seed as a robot's camera and controller, until SIGINT or SIGTERM.

    The camera publishes frames with the detector's boxes. The controller lets the arm move a block
    from where it is seen to its sub-goal; without the arm, it releases the block above the sub-goal
    and lets it fall.
    """
    config = read_config(file, robot)
    stop = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: stop.set())
    with (
        closing(open_renderer()) as renderer,
        closing(SimulatedRobot(domains.load(), renderer, seed, config, with_arm=with_arm)) as stage,
    ):
        stage.look()
        if as_json:
            ready = {"robot": config.robot, "seed": seed, "sentence": stage.sentence}
            click.echo(json_text({"ready": ready}))
        else:
            click.echo(f"world: robot {config.robot}, seed {seed}; try: {stage.sentence}")
        stage.run(stop)
