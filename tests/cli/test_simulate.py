"""``viewgain simulate`` as a user types it: what it writes, that ``measure`` reads it, and wrong input in one line."""

import json
from pathlib import Path

import numpy as np
import pytest

from tests.oracles.shapes import box_mesh
from viewgain.cli import main
from viewgain.scans import read_scan
from viewgain.scenes import standing_box

CAMERA = """
name = "small"
kind = "tof"
[image]
width = 112
height = 86
horizontal_deg = 62.0
vertical_deg = 45.0
[range]
min = 0.1
max = 4.0
"""


@pytest.fixture(scope="module")
def camera(tmp_path_factory: pytest.TempPathFactory) -> str:
    path = tmp_path_factory.mktemp("camera") / "small.toml"
    path.write_text(CAMERA)
    return str(path)


def files(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in sorted(folder.iterdir())}


def test_a_box_from_the_papers_positions_goes_straight_into_measure(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    command = "simulate --scene box --dims 0.4 0.3 0.2 --camera pico_flexx --rig paper4 --without multipath --out"
    assert main([*command.split(), str(tmp_path)]) == 0
    assert "4 of 4 scans written" in capsys.readouterr().out
    truth = json.loads((tmp_path / "truth.json").read_text())
    assert truth["boxes"][0]["extents"] == [0.4, 0.3, 0.2]
    for shot in truth["scans"]:
        for ending in ("png", "npz"):
            assert main(["measure", str(tmp_path / f"{shot['name']}.{ending}"), "--camera", "pico_flexx", "--json"]) == 0
            result = json.loads(capsys.readouterr().out)
            np.testing.assert_allclose(result["boxes"][0]["volume_m3"], 0.024, rtol=0.1)


@pytest.mark.parametrize(
    "scene", ["--scene random", "--scene object --category mug --size 0.3", "--scene box --systematic --frames 3 --yaw 20"]
)
def test_every_kind_of_scene_is_the_same_files_for_one_process_and_two(scene: str, tmp_path: Path, camera: str) -> None:
    command = ["simulate", *scene.split(), "--rig", "ring2", "--camera", camera, "--seed", "3", "--formats", "png", "npz", "ply"]
    assert main([*command, "--out", str(tmp_path / "one")]) == 0
    assert main([*command, "--out", str(tmp_path / "two"), "--workers", "2"]) == 0
    one, two = files(tmp_path / "one"), files(tmp_path / "two")
    assert len(one) in (4 + 1, 2 * 4 + 1)  # a wall may stand before a station
    assert one == two
    assert main([*command[:-4], "--seed", "4", "--out", str(tmp_path / "other")]) == 0
    assert one["view00_000.png"] != files(tmp_path / "other")["view00_000.png"]


def test_a_mesh_file_stands_on_the_floor_at_the_size_asked_for(tmp_path: Path, camera: str) -> None:
    mesh = box_mesh(standing_box(np.array([2.0, 1.0, 1.0])))
    lines = [f"v {x} {y} {z}" for x, y, z in mesh.vertices] + [f"f {a} {b} {c}" for a, b, c in mesh.faces + 1]
    (tmp_path / "crate.obj").write_text("\n".join(lines) + "\n")
    command = [
        "simulate",
        "--scene",
        "mesh",
        "--mesh",
        str(tmp_path / "crate.obj"),
        "--size",
        "0.6",
        "--camera",
        camera,
        "--perfect",
    ]
    assert main([*command, "--rig", "ring2", "--out", str(tmp_path / "out")]) == 0
    truth = json.loads((tmp_path / "out" / "truth.json").read_text())
    assert np.linalg.norm(truth["meshes"][0]["extents"]) == pytest.approx(0.6)
    scan = read_scan(tmp_path / "out" / "view00_000.npz")
    assert scan.camera_to_world is not None
    world = scan.points @ scan.camera_to_world[:3, :3].T + scan.camera_to_world[:3, 3]
    assert world[:, 2].min() == pytest.approx(0, abs=1e-9)
    assert world[:, 2].max() == pytest.approx(truth["meshes"][0]["extents"][2], abs=1e-6)


def test_stations_that_cannot_be_reached_are_said_and_listed(
    tmp_path: Path, camera: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["simulate", "--rig", "pcnbv33", "--camera", camera, "--out", str(tmp_path)]) == 0
    assert "too low" in capsys.readouterr().out
    shots = json.loads((tmp_path / "truth.json").read_text())["scans"]
    assert len(shots) == 33
    assert {shot["reason"] for shot in shots} >= {None, "too low"}
    assert all((shot["name"] is None) == (shot["reason"] is not None) for shot in shots)


@pytest.mark.parametrize(
    ("wrong", "says"),
    [
        ("--camera kinect_v9", "kinect_v9"),
        ("--rig ring0", "ring0"),
        ("--dims 0.4 -0.3 0.2", "three positive lengths"),
        ("--dims 0.4 nan 0.2", "three positive lengths"),
        ("--scene mesh", "--mesh FILE"),
        ("--scene mesh --mesh nowhere.ply", "nowhere.ply"),
        ("--scene object --category unicorn", "unicorn"),
        ("--without gravity", "gravity"),
        ("--reflectivity 0", "reflectivity"),
        ("--captures 0", "captures"),
        ("--size 0 --scene object", "positive"),
        ("--seed -1", "seed"),
        ("--distance nan", "distance"),
        ("--distance 1e200", "distance"),
        ("--elevation inf", "elevation"),
        ("--yaw inf", "yaw"),
        ("--mesh crate.obj", "--scene mesh"),
        ("--workers 0", "workers"),
        ("--perfect --systematic", "systematic"),
    ],
)
def test_wrong_input_ends_in_one_line_and_exit_code_2(
    wrong: str, says: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["simulate", "--out", str(tmp_path / "out"), *wrong.split()]) == 2
    printed = capsys.readouterr()
    assert says in printed.err
    assert len(printed.err.strip().splitlines()) == 1
    assert not (tmp_path / "out").exists()


def test_a_second_recording_does_not_mix_with_a_first(tmp_path: Path, camera: str, capsys: pytest.CaptureFixture[str]) -> None:
    command = ["simulate", "--rig", "ring2", "--camera", camera, "--out", str(tmp_path)]
    assert main(command) == 0
    before = files(tmp_path)
    assert main([*command, "--seed", "1"]) == 2
    assert "holds a recording" in capsys.readouterr().err
    assert files(tmp_path) == before


def test_the_scene_and_the_scans_draw_from_streams_of_their_own(tmp_path: Path, camera: str) -> None:
    """The first numbers of seed 0: those that drew the box are not those that jitter the camera or make its noise."""
    assert main(["simulate", "--scene", "random", "--rig", "irregular4", "--camera", camera, "--out", str(tmp_path)]) == 0
    truth = json.loads((tmp_path / "truth.json").read_text())
    for station in range(4):
        drawn = np.random.default_rng([0, 1, station, 0]).random(3)
        assert not np.allclose(0.1 + 0.5 * drawn, truth["boxes"][0]["extents"])
    np.testing.assert_allclose(0.1 + 0.5 * np.random.default_rng([0, 2]).random(3), truth["boxes"][0]["extents"])


def test_a_folder_that_cannot_be_written_is_one_line(tmp_path: Path, camera: str, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "file").write_text("in the way")
    assert main(["simulate", "--camera", camera, "--out", str(tmp_path / "file" / "below")]) == 2
    assert len(capsys.readouterr().err.strip().splitlines()) == 1


def test_a_camera_that_sees_nothing_anywhere_exits_with_3(tmp_path: Path, camera: str) -> None:
    far = Path(camera).read_text().replace("max = 4.0", "max = 0.2")
    (tmp_path / "short.toml").write_text(far)
    assert main(["simulate", "--rig", "ring2", "--camera", str(tmp_path / "short.toml"), "--out", str(tmp_path / "out")]) == 3
