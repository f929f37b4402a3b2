"""The engine that runs on a Ray cluster. Results come back through it, so the nodes need no common folder to write to.

They do need the package, and the folder of meshes or recordings where a recipe reads one. A worker or node that dies has its
tasks started again elsewhere by Ray.
"""

import logging
from collections.abc import Callable, Iterator, Sequence
from typing import Any, TypeVar

from viewgain.datasets._engine import Dead
from viewgain.errors import ConfigError, MissingExtraError, one_line

T = TypeVar("T")
R = TypeVar("R")
_RETRIES = 3
"""How often a task is started again when its worker dies."""


class RayEngine:
    """Tasks on a Ray cluster, one processor core each."""

    def __init__(self, address: str | None = None, *, workers: int = 1) -> None:
        """Connect, unless this process is connected already.

        Args:
            address: Of the cluster: ``auto``, ``host:port`` or ``ray://host:10001``; None starts Ray on this machine alone.
            workers: Processes, where Ray is started here; a cluster uses all its cores.

        Raises:
            MissingExtraError: If Ray is not installed.
            ConfigError: If the cluster cannot be reached.
        """
        try:
            import ray
        except ImportError as error:
            raise MissingExtraError('engine ray needs the extra "cluster": pip install "viewgain[cluster]"') from error
        self._ray: Any = ray
        if not ray.is_initialized():
            local: dict[str, Any] = {} if address else {"num_cpus": workers, "include_dashboard": False}
            try:
                ray.init(address=address, log_to_driver=False, logging_level=logging.ERROR, **local)
            except (ConnectionError, RuntimeError, ValueError, TimeoutError) as error:
                raise ConfigError(f"ray: no cluster at {address!r} ({one_line(error)}); is it running?") from error

    def run(self, work: Callable[[T], R], tasks: Sequence[T]) -> Iterator[tuple[T, R | Dead]]:
        """Yield each task with its result, as they are done."""
        remote = self._ray.remote(num_cpus=1, max_retries=_RETRIES)(work)
        waiting, running = list(reversed(tasks)), dict[Any, T]()
        while waiting or running:
            while waiting and len(running) < self._width():
                task = waiting.pop()
                running[remote.remote(task)] = task
            (done,), _ = self._ray.wait(list(running), num_returns=1)
            yield running.pop(done), self._result(done)

    def _result(self, reference: Any) -> Any:
        """Return a result; :class:`Dead` if its worker died each time."""
        try:
            return self._ray.get(reference)
        except self._ray.exceptions.RayTaskError as error:
            raise error.cause from error
        except (self._ray.exceptions.WorkerCrashedError, self._ray.exceptions.OutOfMemoryError):
            return Dead()

    def _width(self) -> int:
        """Return how many tasks are kept under way: twice the cores of the cluster as it is now."""
        return max(2, 2 * int(self._ray.cluster_resources().get("CPU", 1)))
