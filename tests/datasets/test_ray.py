"""A real Ray cluster of two nodes on this machine, in which a worker is killed in the middle of a build."""

import os
import signal
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from viewgain.cli import main
from viewgain.datasets import Dataset

ray = pytest.importorskip("ray", reason='Ray is not installed (extra "cluster"); the engine is tested only with it')


@pytest.fixture
def cluster() -> Iterator[str]:
    from ray.cluster_utils import Cluster

    nodes = Cluster(initialize_head=True, head_node_args={"num_cpus": 1, "include_dashboard": False})
    nodes.add_node(num_cpus=1)
    yield nodes.address
    ray.shutdown()
    nodes.shutdown()


def kill_one_worker(killed: list[int], stop: threading.Event) -> None:
    """Kill the first process that is seen making a shard."""
    while not stop.is_set() and not killed:
        for process in Path("/proc").glob("[0-9]*"):
            try:
                if (process / "cmdline").read_bytes().startswith(b"ray::make_shard"):
                    os.kill(int(process.name), signal.SIGKILL)
                    killed.append(int(process.name))
                    break
            except OSError:  # it ended while we looked
                continue
        time.sleep(0.005)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")  # Ray's own: files it leaves open, and advice about its environment variables
@pytest.mark.skipif(not Path("/proc").is_dir(), reason="finds the worker to kill in /proc")
def test_a_cluster_that_loses_a_worker_writes_the_same_bytes(cluster: str, tmp_path: Path, boxes: Dataset) -> None:
    killed: list[int] = []
    stop = threading.Event()
    killer = threading.Thread(target=kill_one_worker, args=(killed, stop))
    killer.start()
    try:
        command = ["dataset", "build", "boxes_paper_tiny", "--out", str(tmp_path), "--engine", "ray", "--ray-address", cluster]
        assert main(command) == 0
    finally:
        stop.set()
        killer.join()
    assert len({node["NodeID"] for node in ray.nodes() if node["Alive"]}) == 2
    assert killed
    for name in ("manifest.json", *(f"shards/{entry.name}" for entry in boxes.manifest.shards)):
        assert (tmp_path / name).read_bytes() == (boxes.folder / name).read_bytes()
