"""Processes that are started together and stopped together."""

from __future__ import annotations

import contextlib
import signal
import subprocess
import threading
from collections.abc import Sequence
from types import TracebackType

from nsrm_harness.common.errors import HarnessError

PATIENCE_S = 300.0
"""How long a process may take to be ready, or to end, on a machine with other work, too."""


class ProcessError(HarnessError):
    """A process ended that should not have, or did not when it should."""


class ProcessGroup:
    """A context manager: whoever was started in it has ended behind it."""

    def __init__(self) -> None:
        self._running: list[tuple[str, subprocess.Popen[str], _Lines]] = []

    def __enter__(self) -> ProcessGroup:
        return self

    def start(self, name: str, command: Sequence[str], ready: str) -> str:
        """Starts a process; the line by which it says that it is ready, which has
        `ready` in it. Raises `ProcessError` if it ends before, or takes too long."""
        process = subprocess.Popen(
            command,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            # A Ctrl-C is for who speaks with the robot; these are stopped behind it.
            start_new_session=True,
        )
        lines = _Lines(process, ready)
        self._running.append((name, process, lines))
        line = lines.wait()
        if line is None:
            raise ProcessError(f"{name} did not start:\n{lines.text()}")
        return line

    def run(self, command: Sequence[str]) -> int:
        """Runs a command to its end, which a Ctrl-C is left to; its exit code."""
        process = subprocess.Popen(command)
        while True:
            # It has got the same signal, and has to stop the robot first.
            with contextlib.suppress(KeyboardInterrupt):
                return process.wait()

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        for _, process, _ in reversed(self._running):
            if process.poll() is None:
                process.send_signal(signal.SIGTERM)
        failed = []
        for name, process, lines in self._running:
            try:
                code = process.wait(PATIENCE_S)
            except subprocess.TimeoutExpired:
                process.kill()
                code = process.wait()
            lines.end()
            if code != 0:
                failed.append(f"{name} ended with code {code}:\n{lines.text()}")
        if failed and error is None:
            raise ProcessError("\n".join(failed))


class _Lines:
    """What a process prints, read as it comes so that it never waits for its reader."""

    def __init__(self, process: subprocess.Popen[str], ready: str) -> None:
        self._lines: list[str] = []
        self._ready: str | None = None
        self._decided = threading.Event()
        self._thread = threading.Thread(target=self._read, args=(process, ready), daemon=True)
        self._thread.start()

    def _read(self, process: subprocess.Popen[str], ready: str) -> None:
        assert process.stdout is not None
        with process.stdout as printed:
            for line in printed:
                self._lines.append(line.rstrip("\n"))
                if self._ready is None and ready in line:
                    self._ready = self._lines[-1]
                    self._decided.set()
        self._decided.set()

    def wait(self) -> str | None:
        """The line that was waited for; None if it did not come."""
        self._decided.wait(PATIENCE_S)
        return self._ready

    def end(self) -> None:
        """Waits until all is read that a process that has ended printed."""
        self._thread.join(PATIENCE_S)

    def text(self) -> str:
        """All that was printed so far."""
        return "\n".join(self._lines)
