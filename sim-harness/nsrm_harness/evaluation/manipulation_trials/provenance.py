"""Identifies the code and model that produce episodes, so that one table never mixes two."""

from __future__ import annotations

import hashlib
from pathlib import Path

import nsrm

import nsrm_harness


def digest() -> str:
    """Hash of the harness's sources and domains, and of the core module with its model."""
    harness, core = (Path(str(each.__file__)).parent for each in (nsrm_harness, nsrm))
    return _of((harness, "*.py"), (harness, "*.toml"), (core, "*.py"), (core, "*.so"))


def _of(*parts: tuple[Path, str]) -> str:
    """Hash of the names and contents of all matching files below these folders."""
    whole = hashlib.sha256()
    for folder, pattern in parts:
        for path in sorted(folder.rglob(pattern)):
            content = path.read_bytes()
            name = path.relative_to(folder).as_posix()
            whole.update(f"{name} {len(content)}\n".encode() + content)
    return whole.hexdigest()
