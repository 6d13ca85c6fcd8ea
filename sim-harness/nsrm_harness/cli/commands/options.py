"""Options, and types of options, that several subcommands share."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import fields
from pathlib import Path

import click
from click.decorators import FC

from nsrm_harness import domain as domains
from nsrm_harness.common.errors import HarnessError
from nsrm_harness.common.workers import LocalProcesses, RayCluster, Workers
from nsrm_harness.data.disturbance import Disturbance


class Span(click.ParamType):
    """``4-6`` or ``5``: a range of numbers."""

    name = "MIN-MAX"

    def convert(
        self, value: object, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[int, int]:
        """The two numbers."""
        match = re.fullmatch(r"(\d+)(?:-(\d+))?", str(value))
        if match is None:
            self.fail(
                f"expected a number, or two with a hyphen between them, got {value!r}", param, ctx
            )
        return int(match[1]), int(match[2] or match[1])


class Values(click.ParamType):
    """``small,green``: names of attribute values."""

    name = "VALUE,VALUE"

    def convert(
        self, value: object, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[str, ...]:
        """The names."""
        return tuple(part.strip() for part in str(value).split(","))


class Sizes(click.ParamType):
    """``camera_m=0.01,depth_m=0.001``: sizes of a disturbance."""

    name = "NAME=SIZE,..."

    def convert(
        self, value: object, param: click.Parameter | None, ctx: click.Context | None
    ) -> Disturbance:
        """The disturbance."""
        known = [field.name for field in fields(Disturbance)]
        sizes: dict[str, float] = {}
        for part in str(value).split(","):
            name, _, size = part.strip().partition("=")
            if name not in known:
                self.fail(f"{name!r}: expected some of {', '.join(known)}", param, ctx)
            try:
                sizes[name] = float(size)
            except ValueError:
                self.fail(f"{name}: expected a number, got {size!r}", param, ctx)
        return Disturbance(**sizes)


domain_option = click.option(
    "--domain",
    "domain_path",
    type=click.Path(path_type=Path),
    default=domains.DEFAULT,
    show_default="the paper's",
    help="Domain file.",
)
seed_option = click.option(
    "--seed", type=click.IntRange(0), default=0, show_default=True, help="Random seed."
)
relations_option = click.option(
    "--relations",
    type=click.Path(path_type=Path),
    multiple=True,
    help="Episode file, best with stacks, about which sentences with relations in descriptions are "
    "said; may be repeated.",
)
lists_option = click.option(
    "--sentences",
    "lists",
    type=click.Path(path_type=Path),
    multiple=True,
    help="List of other people's sentences, tab-separated: columns 'sentence' and 'expected', a "
    "program as JSON or REFUSE; may be repeated.",
)
model_option = click.option(
    "--model",
    "model_path",
    type=click.Path(path_type=Path),
    show_default="the built-in one",
    help="Model file.",
)
arm_option = click.option(
    "--arm/--no-arm",
    "with_arm",
    default=True,
    show_default=True,
    help="Let the arm execute the sub-goals, or place the blocks there without it.",
)
jobs_option = click.option(
    "--jobs",
    type=click.IntRange(1),
    default=os.cpu_count(),
    show_default="one per processor",
    help="Parallel processes.",
)
ray_option = click.option(
    "--ray",
    metavar="ADDRESS",
    help="Use a Ray cluster: 'auto', 'HOST:PORT', or 'local' for one with --jobs workers.",
)
quiet_option = click.option("--quiet", is_flag=True, help="Show no progress bar.")


def negated(ctx: click.Context, param: click.Parameter, value: bool) -> bool:
    """The callback of a flag that turns off what its parameter turns on."""
    return not value


def out_option(default: str, help_text: str) -> Callable[[FC], FC]:
    """Option for the folder of the results."""
    return click.option(
        "--out",
        type=click.Path(path_type=Path, file_okay=False),
        default=Path(default),
        show_default=True,
        help=help_text,
    )


def episodes_options(default: str, help_text: str) -> Callable[[FC], FC]:
    """Options of commands that run episodes: --seed, the workers, and the folder of the results
    (see `out_option`)."""

    def add(command: FC) -> FC:
        for option in (out_option(default, help_text), quiet_option, ray_option, jobs_option):
            command = option(command)
        return seed_option(command)

    return add


def make_folder(path: Path) -> None:
    """Creates the folder of the results. Raises `HarnessError`."""
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise HarnessError(
            f"cannot create the folder {path}: {error.strerror}: use another --out"
        ) from None


@contextmanager
def workers_of(jobs: int, ray: str | None) -> Iterator[Workers]:
    """The workers that `jobs_option` and `ray_option` select."""
    if ray is None:
        yield LocalProcesses(jobs)
        return
    with RayCluster(ray, jobs) as cluster:
        yield cluster
