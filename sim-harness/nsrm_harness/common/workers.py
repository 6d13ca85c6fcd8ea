"""Runs functions in parallel, in local processes or on a Ray cluster.

A function gets all of its input as arguments and returns all of its output, so that it does not
matter where it runs.
"""

from __future__ import annotations

import logging
import multiprocessing
import os
import signal
import socket
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from pathlib import Path
from typing import Any, Protocol, TypeVar

import nsrm_harness
from nsrm_harness.common.errors import HarnessError
from nsrm_harness.common.orphans import end_with_parent

T = TypeVar("T")
K = TypeVar("K")
SECONDS_TO_ANSWER = 10.0
PACKAGE = Path(nsrm_harness.__file__).resolve().parent
"""What a cluster's machines are sent."""


class WorkersError(HarnessError):
    """Workers that cannot be started."""


class Workers(Protocol):
    """Something that runs functions in parallel."""

    @property
    def count(self) -> int:
        """Number of functions that run at a time."""
        ...

    def each(
        self, function: Callable[..., T], tasks: Iterable[tuple[K, tuple[Any, ...]]]
    ) -> Iterator[tuple[K, T]]:
        """Yields each key with `function(*arguments)`, in the order in which they finish.

        No more tasks are handed out than can run. If the caller stops early, or on Ctrl-C, running
        tasks may be lost.
        """
        ...


class LocalProcesses:
    """Processes on this machine."""

    def __init__(self, count: int) -> None:
        self.count = count

    def each(
        self, function: Callable[..., T], tasks: Iterable[tuple[K, tuple[Any, ...]]]
    ) -> Iterator[tuple[K, T]]:
        """See `Workers`."""
        waiting = iter(tasks)
        running: dict[Future[T], K] = {}
        # "spawn": a forked child would share the parent's OpenGL and PyBullet state.
        with ProcessPoolExecutor(
            self.count,
            mp_context=multiprocessing.get_context("spawn"),
            initializer=_begin,
        ) as pool:
            while True:
                while len(running) < self.count and (task := next(waiting, None)) is not None:
                    key, arguments = task
                    running[pool.submit(function, *arguments)] = key
                if not running:
                    return
                finished, _ = wait(running, return_when=FIRST_COMPLETED)
                for future in finished:
                    yield running.pop(future), future.result()


def _begin() -> None:
    # Ctrl-C reaches all processes of the terminal; only the parent decides what it stops.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    end_with_parent()


class RayCluster:
    """A Ray cluster with one task per processor. A context manager.

    Its machines need Ray and the packages in `requirements/`; this package is sent to them.
    """

    def __init__(self, address: str, processors: int | None = None) -> None:
        """`address`: as for `ray.init`: "auto", "host:port", or "local" for a cluster with
        `processors` that is started here and stopped with this object.

        Raises `WorkersError`.
        """
        # Otherwise Ray reports its usage, and prints how to turn that off.
        os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")
        try:
            import ray
        except ImportError as error:
            raise WorkersError(
                "Ray is not installed: pip install --require-hashes -r "
                "sim-harness/requirements/dev.txt, on every machine of the cluster"
            ) from error
        self._ray: Any = ray
        own: dict[str, Any] = {}
        if address == "local":
            own = {"num_cpus": processors, "include_dashboard": False}
        elif address != "auto":
            _check_answers(address)
        try:
            ray.init(
                address=address,
                runtime_env={"py_modules": [str(PACKAGE)]},
                log_to_driver=False,
                logging_level=logging.ERROR,
                **own,
            )
        # Ray passes on any exception of its parts.
        except Exception as error:
            raise WorkersError(f"no Ray cluster at {address!r}: {error}") from error
        self.count = max(int(ray.cluster_resources().get("CPU", 1)), 1)

    def __enter__(self) -> RayCluster:
        return self

    def __exit__(self, *_: object) -> None:
        self._ray.shutdown()

    def each(
        self, function: Callable[..., T], tasks: Iterable[tuple[K, tuple[Any, ...]]]
    ) -> Iterator[tuple[K, T]]:
        """See `Workers`."""
        remote = self._ray.remote(num_cpus=1)(function)
        waiting = iter(tasks)
        running: dict[Any, K] = {}
        while True:
            while len(running) < self.count and (task := next(waiting, None)) is not None:
                key, arguments = task
                running[remote.remote(*arguments)] = key
            if not running:
                return
            finished, _ = self._ray.wait(list(running))
            for reference in finished:
                try:
                    result = self._ray.get(reference)
                except self._ray.exceptions.RayTaskError as error:
                    # The function's own error, as if it had been raised here.
                    raise error.cause from error
                yield running.pop(reference), result


def _check_answers(address: str) -> None:
    """Raises `WorkersError` if nothing listens there: Ray itself would wait for minutes."""
    host, _, port = address.removeprefix("ray://").rpartition(":")
    try:
        socket.create_connection((host, int(port)), SECONDS_TO_ANSWER).close()
    except (OSError, ValueError) as error:
        raise WorkersError(f"no Ray cluster at {address!r}: {error}") from error
