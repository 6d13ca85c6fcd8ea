"""What the processes of a robot are told by a file: the same one as `nsrm` reads."""

from __future__ import annotations

from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import AfterValidator

from nsrm_harness.common.errors import HarnessError
from nsrm_harness.common.toml_file import NO_OTHER_KEYS, Text, checked, read_toml

# It has no types; its names are looked up when they are used.
iox2: Any = import_module("iceoryx2")
# Errors say what went wrong; the rest is of no use to who reads a command's messages.
iox2.set_log_level(iox2.LogLevel.Fatal)

ROBOT = "robot"
"""The robot's name where none is given."""


class RobotConfigError(HarnessError):
    """A configuration that cannot be read, or makes no sense."""


def _as_iceoryx2_has_it(kind: str) -> AfterValidator:
    """A check by iceoryx2's own type of that name."""

    def check(text: str) -> str:
        try:
            getattr(iox2, kind).new(text)
        except iox2.SemanticStringError:
            raise ValueError(f"too long, or not a name that files may have: got {text!r}") from None
        return text

    return AfterValidator(check)


def _absolute(root: str) -> str:
    if not Path(root).is_absolute():
        raise ValueError(
            "a path from / is needed, for processes to meet wherever they are started; "
            f"got {root!r}"
        )
    return root


@dataclass(frozen=True)
class _SharedMemory:
    """Where iceoryx2 keeps what processes share, if not at its usual place."""

    __pydantic_config__ = NO_OTHER_KEYS

    root: Annotated[Text, AfterValidator(_absolute), _as_iceoryx2_has_it("Path")] | None = None
    """A folder for its files."""
    prefix: Annotated[Text, _as_iceoryx2_has_it("FileName")] | None = None
    """What names in shared memory begin with."""


@dataclass(frozen=True)
class _File:
    """A configuration file. Everything may be left out."""

    __pydantic_config__ = NO_OTHER_KEYS

    robot: Text = ROBOT
    model: Any = None
    """As `line` and `limits`: for those who plan and ask, which read them."""
    line: Any = None
    hosts: Literal["one", "several"] = "one"
    limits: Any = None
    shared_memory: _SharedMemory = _SharedMemory()


@dataclass(frozen=True)
class RobotConfig:
    """What a camera and a controller go by."""

    robot: str = ROBOT
    several_hosts: bool = False
    """Whether a tunnel connects processes on several hosts, whose wall clocks agree."""
    shared_memory: Any = None
    """iceoryx2's configuration; none: that of the machine."""


def read_config(path: Path | None, robot: str | None = None) -> RobotConfig:
    """From the file, if there is one; a name that is given comes before the file's. Raises
    `RobotConfigError`."""
    told = {} if path is None else read_toml(path, RobotConfigError, "configuration")
    file = checked(_File, told, str(path), RobotConfigError)
    return RobotConfig(
        robot=robot or file.robot,
        several_hosts=file.hosts == "several",
        shared_memory=_iceoryx2_config(file.shared_memory),
    )


def _iceoryx2_config(told: _SharedMemory) -> Any:
    if told == _SharedMemory():
        return None
    config = iox2.config.default()
    if told.root is not None:
        config.global_cfg.root_path = iox2.Path.new(told.root)
    if told.prefix is not None:
        config.global_cfg.prefix = iox2.FileName.new(told.prefix)
    return config
