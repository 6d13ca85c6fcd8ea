"""What the processes of a robot are told by a file: the same one as `nsrm` reads."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

from nsrm_harness.common.errors import HarnessError

# It has no types; its names are looked up when they are used.
iox2: Any = import_module("iceoryx2")
# Errors say what went wrong; the rest is of no use to who reads a command's messages.
iox2.set_log_level(iox2.LogLevel.Fatal)

ROBOT = "robot"
"""The robot's name where none is given."""
HOSTS = ("one", "several")
KEYS = ("robot", "model", "line", "hosts", "limits", "shared_memory")
"""All that may stand in it; `model`, `line` and `limits` are for who plans and who asks."""


class RobotConfigError(HarnessError):
    """A configuration that cannot be read, or makes no sense."""


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
    told: dict[str, Any] = {}
    if path is not None:
        try:
            told = tomllib.loads(path.read_text(encoding="utf-8"))
        except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
            raise RobotConfigError(f"{path}: {error}") from None
    if unknown := sorted(set(told) - set(KEYS)):
        raise RobotConfigError(f"{path}: unknown: {', '.join(unknown)}; known: {', '.join(KEYS)}")
    hosts = told.get("hosts", HOSTS[0])
    if hosts not in HOSTS:
        raise RobotConfigError(f"{path}: hosts = {hosts!r}: it is one of {', '.join(HOSTS)}")
    name = robot or told.get("robot", ROBOT)
    if not isinstance(name, str):
        raise RobotConfigError(f"{path}: robot = {name!r}: a name is a text")
    return RobotConfig(
        robot=name,
        several_hosts=hosts == HOSTS[1],
        shared_memory=_shared_memory(path, told.get("shared_memory", {})),
    )


def _shared_memory(path: Path | None, told: Any) -> Any:
    if not isinstance(told, dict) or set(told) - {"root", "prefix"}:
        raise RobotConfigError(f"{path}: [shared_memory] may have root and prefix")
    if not told:
        return None
    config = iox2.config.default()
    for key, kind, field in (("root", "Path", "root_path"), ("prefix", "FileName", "prefix")):
        if key not in told:
            continue
        try:
            if key == "root" and not Path(told[key]).is_absolute():
                raise RobotConfigError(
                    f"{path}: shared_memory.root = {told[key]!r}: a path from / is needed, for "
                    "processes to meet wherever they are started"
                )
            setattr(config.global_cfg, field, getattr(iox2, kind).new(told[key]))
        except (TypeError, iox2.SemanticStringError):
            raise RobotConfigError(
                f"{path}: shared_memory.{key} = {told[key]!r}: too long, or not a name that "
                "files may have"
            ) from None
    return config
