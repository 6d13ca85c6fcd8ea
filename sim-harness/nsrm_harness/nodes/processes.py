"""Starts and stops a group of processes together."""

from __future__ import annotations

import contextlib
import signal
import subprocess
import threading
from collections.abc import Sequence
from types import TracebackType

from nsrm_harness.common.errors import HarnessError

PATIENCE_S = 300.0
"""Timeout for a process to be ready, or to exit, also on a busy machine."""


class ProcessError(HarnessError):
    """A process exited unexpectedly, or did not exit when it should."""


class ProcessGroup:
    """A context manager; all processes started in it have exited after it."""

    def __init__(self) -> None:
        self._running: list[tuple[str, subprocess.Popen[str], _Lines]] = []

    def __enter__(self) -> ProcessGroup:
        return self

    def start(self, name: str, command: Sequence[str], ready: str) -> str:
        """Starts a process and waits for a line that contains `ready`; returns that line. Raises
        `ProcessError` if the process exits before, or takes too long."""
        process = subprocess.Popen(
            command,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            # Ctrl-C is for the process that talks to the robot; these are stopped after it.
            start_new_session=True,
        )
        lines = _Lines(process, ready)
        self._running.append((name, process, lines))
        line = lines.wait()
        if line is None:
            raise ProcessError(f"{name} did not start:\n{lines.text()}")
        return line

    def run(self, command: Sequence[str]) -> int:
        """Runs a command, which handles Ctrl-C itself, and returns its exit code."""
        process = subprocess.Popen(command)
        while True:
            # It got the same signal, and must stop the robot first.
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
                failed.append(f"{name} exited with code {code}:\n{lines.text()}")
        if failed and error is None:
            raise ProcessError("\n".join(failed))


class _Lines:
    """The output of a process, read continuously so that the process never blocks on it."""

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
        """Waits for the expected line; None if it did not come."""
        self._decided.wait(PATIENCE_S)
        return self._ready

    def end(self) -> None:
        """Waits until all output of an exited process is read."""
        self._thread.join(PATIENCE_S)

    def text(self) -> str:
        """All output so far."""
        return "\n".join(self._lines)
