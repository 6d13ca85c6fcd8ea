"""Which code and which model make episodes: those of another are no part of the same table."""

from __future__ import annotations

import hashlib
from pathlib import Path

import nsrm

import nsrm_harness


def digest() -> str:
    """Of this package's sources and domains, and of the core module: the model is built into it."""
    harness, core = (Path(str(each.__file__)).parent for each in (nsrm_harness, nsrm))
    return _of((harness, "*.py"), (harness, "*.toml"), (core, "*.py"), (core, "*.so"))


def _of(*parts: tuple[Path, str]) -> str:
    """Of the names and contents of all files below folders that are called so."""
    whole = hashlib.sha256()
    for folder, pattern in parts:
        for path in sorted(folder.rglob(pattern)):
            content = path.read_bytes()
            name = path.relative_to(folder).as_posix()
            whole.update(f"{name} {len(content)}\n".encode() + content)
    return whole.hexdigest()
