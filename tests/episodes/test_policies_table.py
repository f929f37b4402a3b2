"""The table of the coverage benchmark: means, what is paired, and the share of the gap, by hand."""

import numpy as np

from benchmarks.coverage_policies import _chosen, _policies, table
from tests.episodes.test_coverage import line_world
from viewgain.gain import VOLUMETRIC
from viewgain.meshes import MeshFolder


def test_the_gap_closed_is_that_of_the_means() -> None:
    """Flat curves at c have an AUC of 0.95 c with ten views."""
    flat = np.ones((4, 10))
    rows = table({"oracle": 0.8 * flat, "random": 0.4 * flat, "half way": 0.6 * flat, "worse": 0.3 * flat}).splitlines()[2:]
    cells = [[cell.strip() for cell in row.strip("|").split("|")] for row in rows]
    assert [row[0] for row in cells] == ["worse", "random", "half way", "oracle"]
    assert [row[1] for row in cells] == ["0.2850", "0.3800", "0.5700", "0.7600"]
    assert [row[3] for row in cells] == ["-0.0950", "+0.0000", "+0.1900", "+0.3800"]
    assert [row[5] for row in cells] == ["-25%", "0%", "50%", "100%"]
    assert cells[2][7] == "0.600 0.600 0.600 0.600 0.600"


def test_every_volumetric_metric_plays_in_both_settings() -> None:
    names = set(_policies(line_world()))
    assert names == {"uniform", "farthest", "oracle"} | {name + label for name in VOLUMETRIC for label in ("", " (returns only)")}


def test_objects_are_dealt_category_by_category(tmp_path) -> None:  # type: ignore[no-untyped-def]
    for category, count in (("a", 1), ("b", 3), ("c", 2)):
        (tmp_path / category).mkdir()
        for k in range(count):
            (tmp_path / category / f"{k}.off").write_text("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n")
    dealt = [(entry.category, entry.name) for entry in _chosen(MeshFolder.open(tmp_path), 6)]
    assert sorted(category for category, _ in dealt[:3]) == ["a", "b", "c"]
    assert sorted(category for category, _ in dealt[3:5]) == ["b", "c"]
    assert len(set(dealt)) == 6
    assert dealt == [(entry.category, entry.name) for entry in _chosen(MeshFolder.open(tmp_path), 6)]
