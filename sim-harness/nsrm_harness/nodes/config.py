"""Reads the configuration of a robot's processes, the same file as for `nsrm`."""

from __future__ import annotations

from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import AfterValidator

from nsrm_harness.common.errors import HarnessError
from nsrm_harness.common.toml_file import NO_OTHER_KEYS, Text, checked, read_toml

# iceoryx2 has no type information; its names are looked up when they are used.
iox2: Any = import_module("iceoryx2")
# Errors are reported as exceptions; further log messages would only clutter the output.
iox2.set_log_level(iox2.LogLevel.Fatal)

ROBOT = "robot"
"""The default name of a robot."""


class RobotConfigError(HarnessError):
    """A configuration that cannot be read or is invalid."""


def _as_iceoryx2_has_it(kind: str) -> AfterValidator:
    """Validates text by the iceoryx2 type with this name."""

    def check(text: str) -> str:
        try:
            getattr(iox2, kind).new(text)
        except iox2.SemanticStringError:
            raise ValueError(f"too long, or not a valid file name: got {text!r}") from None
        return text

    return AfterValidator(check)


def _absolute(root: str) -> str:
    if not Path(root).is_absolute():
        raise ValueError(
            "an absolute path is needed, so that processes meet wherever they are started; "
            f"got {root!r}"
        )
    return root


@dataclass(frozen=True)
class _SharedMemory:
    """Where iceoryx2 keeps its shared resources, if not in the default location."""

    __pydantic_config__ = NO_OTHER_KEYS

    root: Annotated[Text, AfterValidator(_absolute), _as_iceoryx2_has_it("Path")] | None = None
    """A folder for its files."""
    prefix: Annotated[Text, _as_iceoryx2_has_it("FileName")] | None = None
    """Prefix of names in shared memory."""


@dataclass(frozen=True)
class _File:
    """A configuration file. All keys are optional."""

    __pydantic_config__ = NO_OTHER_KEYS

    robot: Text = ROBOT
    model: Any = None
    """Like `transport` and `limits`, read only by the planner and its clients."""
    transport: Any = None
    hosts: Literal["one", "several"] = "one"
    limits: Any = None
    shared_memory: _SharedMemory = _SharedMemory()


@dataclass(frozen=True)
class RobotConfig:
    """The configuration of a camera and a controller."""

    robot: str = ROBOT
    several_hosts: bool = False
    """Whether a tunnel connects processes on several hosts with synchronised wall clocks."""
    shared_memory: Any = None
    """iceoryx2's configuration; None for the machine's."""


def read_config(path: Path | None, robot: str | None = None) -> RobotConfig:
    """Reads the file, if given; `robot` overrides the file's name. Raises `RobotConfigError`."""
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
