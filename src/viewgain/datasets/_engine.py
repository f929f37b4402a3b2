"""Engines: whoever runs tasks. Results come back in order of completion; what they hold does not depend on the engine."""

import os
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from multiprocessing import get_context, parent_process
from multiprocessing.connection import wait as wait_for
from threading import Thread
from typing import Protocol, TypeVar

from viewgain.errors import ConfigError
from viewgain.simulate import single_threads

T = TypeVar("T")
R = TypeVar("R")


class Dead:
    """Stands for the result of a task that killed its process twice, the second time with no other task beside it."""


class Engine(Protocol):
    """Runs a function on tasks, somewhere."""

    def run(self, work: Callable[[T], R], tasks: Sequence[T]) -> Iterator[tuple[T, R | Dead]]:
        """Yield each task with its result, as they are done. Exceptions of ``work`` come through."""


class LocalEngine:
    """Processes of this machine, started afresh, one thread each."""

    def __init__(self, workers: int = 1) -> None:
        """Start nothing yet.

        Raises:
            ConfigError: If there is no worker.
        """
        if workers < 1:
            raise ConfigError(f"got {workers} workers, wanted at least 1")
        self._workers = workers

    def run(self, work: Callable[[T], R], tasks: Sequence[T]) -> Iterator[tuple[T, R | Dead]]:
        """Yield each task with its result; a task whose process dies is tried once more, alone."""
        waiting = list(tasks)
        while waiting:
            suspects, waiting = yield from self._together(work, waiting)
            for task in suspects:
                if (yield from self._alone(work, task)):
                    yield task, Dead()

    def _together(
        self, work: Callable[[T], R], tasks: Sequence[T]
    ) -> Generator[tuple[T, R | Dead], None, tuple[list[T], list[T]]]:
        """Run tasks side by side; return those under way and those still waiting when a process died."""
        waiting = list(reversed(tasks))
        with _processes(self._workers) as pool:
            running: dict[Future[R], T] = {}
            try:
                while waiting or running:
                    while waiting and len(running) < 2 * self._workers:  # results are large: no more than can soon be written
                        task = waiting.pop()
                        running[pool.submit(work, task)] = task
                    done, _ = wait(running, return_when=FIRST_COMPLETED)
                    for future in done:
                        result = future.result()
                        yield running.pop(future), result
            except BrokenProcessPool:
                return list(running.values()), waiting[::-1]
            finally:
                for future in running:
                    future.cancel()
        return [], []

    def _alone(self, work: Callable[[T], R], task: T) -> Generator[tuple[T, R | Dead], None, bool]:
        """Run one task in a process of its own; return whether the process died."""
        with _processes(1) as pool:
            try:
                result = pool.submit(work, task).result()
            except BrokenProcessPool:
                return True
        yield task, result
        return False


@contextmanager
def _processes(workers: int) -> Iterator[ProcessPoolExecutor]:
    """Give a pool of fresh processes with one thread each; they are gone when the block ends."""
    with single_threads():
        pool = ProcessPoolExecutor(workers, mp_context=get_context("spawn"), initializer=_end_with_parent)
        try:
            yield pool
        finally:
            pool.shutdown(wait=True, cancel_futures=True)


def _end_with_parent() -> None:
    """Watch the parent, and end this process with it: after a kill -9 of the parent workers would wait for ever."""
    parent = parent_process()
    if parent is not None:
        Thread(target=lambda: (wait_for([parent.sentinel]), os._exit(1)), daemon=True).start()


def engine(name: str, *, workers: int = 1, address: str | None = None) -> Engine:
    """Return an engine by name.

    Args:
        name: ``local`` or ``ray``.
        workers: Processes of the local engine.
        address: Of the Ray cluster, for instance ``ray://head:10001`` or ``auto``; None starts Ray on this machine.

    Raises:
        ConfigError: If there is no such engine.
        MissingExtraError: If Ray is asked for and not installed.
    """
    if name == "local":
        return LocalEngine(workers)
    if name == "ray":
        from viewgain.datasets._ray import RayEngine

        return RayEngine(address, workers=workers)
    raise ConfigError(f"engine {name!r} is not known; choose local or ray")
