"""``viewgain evaluate`` on meshes of one's own: a bad one is named, all are one part, seeds are averaged, coverage is played."""

import json
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.datasets.engines import Inline
from tests.oracles.networks_on_disk import exported, small_settings
from viewgain.cli import _evaluate_coverage, _judging, main
from viewgain.evaluation import RESERVED
from viewgain.inference import _shipped

QUADS = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]


def off_box(path: Path, sides: tuple[float, float, float]) -> None:
    corners = [(sides[0] * (k & 1), sides[1] * (k >> 1 & 1), sides[2] * (k >> 2)) for k in range(8)]
    faces = [each for a, b, c, d in QUADS for each in ((3, a, b, c), (3, a, c, d))]
    lines = ["OFF", "8 12 0", *(" ".join(map(str, row)) for row in [*corners, *faces])]
    path.write_text("\n".join(lines) + "\n")


@pytest.fixture(autouse=True)
def _inline(monkeypatch: pytest.MonkeyPatch) -> None:
    for module in (_judging, _evaluate_coverage):
        monkeypatch.setattr(module, "LocalEngine", lambda workers: Inline())


@pytest.fixture(scope="module")
def meshes(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("meshes")
    for category, name, sides in [("box", "a", (0.1, 0.2, 3)), ("box", "b", (2, 0.3, 0.2)), ("slab", "c", (0.6, 3, 0.05))]:
        (folder / category).mkdir(exist_ok=True)
        off_box(folder / category / f"{name}.off", sides)
    (folder / "slab" / "bad.off").write_text("OFF\n1 1 0\n0 0 0\n")
    return folder


@pytest.fixture(scope="module")
def models(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two seeds of a network with and without view state, one of the camera frame, and one for 33 views."""
    folder = tmp_path_factory.mktemp("models")
    for kind in ("compact", "compact_view"):
        for seed in (0, 1):
            training = {"recipe": kind, "seed": str(seed), "steps": f"{seed} of 9, batch 1"}
            exported(folder / f"{kind}{seed}.onnx", small_settings(kind), seed=seed, training=training)  # type: ignore[arg-type]
    exported(folder / "camera.onnx", small_settings("compact"), frame="camera")
    exported(folder / "views33.onnx", small_settings("compact_view", views=33), rig="pcnbv33")
    return folder


def run(capsys: pytest.CaptureFixture[str], *arguments: object) -> tuple[list[dict[str, Any]], str]:
    assert main(["evaluate", *map(str, arguments)]) == 0
    said = capsys.readouterr()
    return [json.loads(line) for line in said.out.splitlines()], said.err


def test_table1_of_meshes_is_one_part_with_a_two_fold_floor_and_seeds_averaged(
    meshes: Path, models: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    files = [models / f"{kind}{seed}.onnx" for kind in ("compact_view", "compact") for seed in (0, 1)]
    (table,), said = run(capsys, "table1", "--meshes", meshes, "--models", *files, "--json", "--out", tmp_path / "out")
    assert "skipped slab/bad" in said
    assert [each["name"] for each in table["skipped"]] == ["slab/bad"]
    assert (table["split"], table["samples"], table["objects"]) == ("meshes", 48, 3)
    assert "no network may have seen them" in table["title"]
    assert table["constant_chosen"] == "two_fold"
    rows = {row["name"]: row for row in table["rows"]}
    told, untold = "compact_view, mean of 2 seeds", "compact, mean of 2 seeds"
    assert list(rows) == ["compact_view0", "compact_view1", "compact0", "compact1", told, untold, *RESERVED]
    assert rows["compact1"]["within"] == untold
    assert (rows[untold]["seeds"], rows[untold]["within"]) == (2, None)
    members = [rows[f"compact{seed}"]["shares"]["mean"] for seed in (0, 1)]
    assert rows[untold]["shares"]["mean"] == pytest.approx(np.mean(members, axis=0))
    pairs = {(each["first"], each["second"]): each for each in table["differences"]}
    assert list(pairs) == [(told, "constant answer"), (untold, "constant answer"), (untold, told)]
    apart = pairs[untold, told]
    assert apart["shares"]["mean"] == pytest.approx(np.subtract(rows[untold]["shares"]["mean"], rows[told]["shares"]["mean"]))
    if apart["share"] is not None:
        assert apart["share"]["mean"][1] == pytest.approx(rows[untold]["shares"]["mean"][1] / rows[told]["shares"]["mean"][1])
    floor = np.array(rows["constant answer"]["shares"]["mean"])
    closed = (np.array(rows[told]["shares"]["mean"]) - floor) / (1 - floor)
    assert pairs[told, "constant answer"]["closed"]["mean"] == pytest.approx(closed)
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == ["table1.json", "table1.md", "table1.png"]
    assert (tmp_path / "out" / "table1.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.slow
def test_shipped_networks_that_fit_are_taken_each_in_its_frame(
    meshes: Path, models: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for name in ("compact0", "camera", "views33"):
        shutil.copy(models / f"{name}.onnx", tmp_path)
    monkeypatch.setattr(_shipped, "FOLDER", tmp_path)
    both, said = run(capsys, "table1", "--meshes", meshes, "--limit", 1, "--json")
    assert "no shipped network" not in said
    names = [[row["name"] for row in table["rows"] if row["name"] not in RESERVED] for table in both]
    assert ([table["frame"] for table in both], names) == (["object", "camera"], [["compact0"], ["camera"]])
    guesses = [{row["name"]: row["shares"] for row in table["rows"]}["uniform guess"] for table in both]
    assert guesses[0]["mean"] == guesses[1]["mean"]
    (table,), _ = run(capsys, "table1", "--meshes", meshes, "--limit", 1, "--json", "--floors-only")
    assert table["objects"] == both[0]["objects"]
    assert [row["name"] for row in table["rows"]][:2] == ["uniform guess", "random"]


@pytest.mark.slow
def test_coverage_of_meshes_plays_networks_beside_floors(
    meshes: Path, models: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    files = [models / "compact0.onnx", models / "compact_view0.onnx"]
    arguments = ("--meshes", meshes, "--rig", "pcnbv16", "--steps", 4, "--policies", "uniform", "--models", *files)
    (table,), said = run(capsys, "coverage", *arguments, "--json", "--out", tmp_path)
    assert "skipped slab/bad" in said
    assert (table["rig"], table["views"], table["steps"], table["objects"], table["categories"]) == ("pcnbv16", 16, 4, 3, 2)
    for rule in ("union", "published"):
        rows = {row["policy"]: row for row in table["rows"] if row["rule"] == rule}
        assert set(rows) == {"random", "farthest", "oracle", "uniform", "compact0", "compact_view0"}
        assert len({row["coverage"][0] for row in rows.values()}) == 1
        for row in rows.values():
            one, two, three, four = row["coverage"]
            assert one <= two <= three <= four
            assert row["auc"]["mean"][0] == pytest.approx((one + two + three + four / 2) / 4)
    assert {path.name for path in tmp_path.iterdir()} == {"coverage.json", "coverage.md", "coverage.png"}


def test_wrong_input_to_coverage_is_one_line_and_exit_code_2(
    meshes: Path, models: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for arguments, word in [
        (("--meshes", meshes, "--models", models / "compact0.onnx"), "rig pcnbv16, not of pcnbv33"),
        (("--meshes", meshes, "--rig", "pcnbv16", "--models", models / "views33.onnx"), "choose --rig pcnbv33"),
        (("--meshes", meshes, "--steps", 34), "wanted 1 to 33"),
        (("--meshes", meshes, "--policies", "nearest"), "proximity_count"),
        (("--data", tmp_path), "holds no data set"),
        ((), "got no objects"),
    ]:
        assert main(["evaluate", "coverage", *map(str, arguments)]) == 2
        said = [line for line in capsys.readouterr().err.splitlines() if "no shipped" not in line]
        assert len(said) == 1
        assert said[0].startswith("viewgain: error:")
        assert word in said[0]
