"""A recording on disk: what is written reads back as what was seen, and truth.json says all there is to know about it."""

import json
import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.oracles.triangles import block
from viewgain.camera import Intrinsics, Sensor, sensor
from viewgain.errors import ConfigError, ScanError
from viewgain.rigs import Jitter, KeepOut, Rig, Station, Target, poses, ring
from viewgain.scans import Scan, read_scan
from viewgain.scenes import FLOOR, Scene, standing_box, wall
from viewgain.simulate import FORMATS, Effects, RangeError, Recording, capture, record, single_threads, truth
from viewgain.simulate._recording import station_poses

SMALL = replace(sensor("pico_flexx"), intrinsics=Intrinsics.from_field_of_view(40, 30, *np.deg2rad([62.0, 45.0])))
BOX = standing_box(np.array([0.35, 0.25, 0.3]), yaw=0.4)
MESH = block(np.array([0.5, -0.2, 0.0]), np.array([0.7, 0.1, 0.25]))
SCENE = Scene((BOX,), (MESH,), (FLOOR, wall(2.0, 1.5)), (0.6, 0.3, 0.5, 0.8))
TARGET = Target(BOX.box_to_camera, BOX.extents)
SKYWARDS = np.array([[1.0, 0, 0, 2.0], [0, 1, 0, 0], [0, 0, 1, 3], [0, 0, 0, 1]])
"""A pose that looks straight up."""
RIG = Rig(
    name="five",
    stations=(
        Station(azimuth=0.3, elevation=0.6, distance=1.0),
        Station(azimuth=1.5),  # elevation and distance are the recording's
        Station(azimuth=2.0, elevation=0.6, distance=0.35),
        Station(camera_to_world=SKYWARDS),
        Station(azimuth=4.0, elevation=0.5, distance=1.1),
    ),
    jitter=Jitter(distance=(-0.05, 0.05), azimuth=(-0.1, 0.1)),
    keep_out=(KeepOut(axis=np.array([np.cos(1.5), np.sin(1.5), 0.7]), half_angle=0.4),),
)
"""Two stations that see the scene, one kept out, one too near, one that sees nothing."""
OPEN = replace(RIG, keep_out=())


def recording(**changes: object) -> Recording:
    return Recording(**({"scene": SCENE, "target": TARGET, "sensor": SMALL, "rig": RIG, "seed": 7} | changes))  # type: ignore[arg-type]


def truth_of(folder: Path) -> dict[str, object]:
    return dict(json.loads((folder / "truth.json").read_text()))


def contents(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in sorted(folder.iterdir())}


def test_there_is_a_file_per_station_capture_and_format(tmp_path: Path) -> None:
    shots = record(recording(captures=2, formats=FORMATS), tmp_path / "new" / "folder")
    names = [f"view{station:02d}_{number:03d}" for station in (0, 4) for number in (0, 1)]
    endings = ("png", "json", "npz", "ply")  # a PNG has its camera beside it
    found = {path.name for path in (tmp_path / "new" / "folder").iterdir()}
    assert found == {f"{name}.{ending}" for name in names for ending in endings} | {"truth.json"}
    assert [(shot.station, shot.capture) for shot in shots] == [(s, c) for s in range(5) for c in range(2)]
    assert [shot.name for shot in shots if shot.name] == names


def test_by_station_each_has_a_folder_of_its_name(tmp_path: Path) -> None:
    rig = replace(RIG, stations=(replace(RIG.stations[0], name="left"), *RIG.stations[1:]))
    shots = record(recording(rig=rig, formats=("npz",), by_station=True), tmp_path)
    assert [shot.name for shot in shots if shot.name] == ["left/view00_000", "view04/view04_000"]
    assert [path.name for path in (tmp_path / "left").iterdir()] == ["view00_000.npz"]
    flat = record(recording(rig=rig, formats=("npz",)), tmp_path / "flat")
    assert (tmp_path / "left" / "view00_000.npz").read_bytes() == (tmp_path / "flat" / f"{flat[0].name}.npz").read_bytes()
    (tmp_path / "truth.json").unlink()
    with pytest.raises(ConfigError, match="holds a recording already"):
        record(recording(rig=rig, formats=("npz",), by_station=True), tmp_path)


def test_by_station_nothing_is_written_that_would_be_read_otherwise() -> None:
    with pytest.raises(ConfigError, match="would count twice"):
        recording(by_station=True, formats=("png", "npz"))
    turned = replace(RIG, stations=(replace(RIG.stations[0], name="west"), *RIG.stations[1:]))
    with pytest.raises(ConfigError, match="alphabetical order"):
        recording(by_station=True, formats=("npz",), rig=turned)


def test_refused_stations_say_why(tmp_path: Path) -> None:
    shots = record(recording(), tmp_path)
    assert [shot.reason for shot in shots] == [None, "kept out", "too near", "fewer than 100 returns", None]
    assert [shot.name is None for shot in shots] == [False, True, True, True, False]
    assert all(np.shape(shot.camera_to_world) == (4, 4) for shot in shots)
    entries = truth_of(tmp_path)["scans"]
    assert entries == [
        {
            "station": shot.station, "capture": shot.capture, "name": shot.name,
            "camera_to_world": shot.camera_to_world, "reason": shot.reason,
        }
        for shot in shots
    ]  # fmt: skip


@pytest.mark.parametrize("ending", FORMATS)
def test_what_is_written_is_what_the_camera_saw(ending: str, tmp_path: Path) -> None:
    """The draws of scan k of station s come from (seed, s, k). A PNG rounds its depth to 0.1 mm, the others to nothing."""
    request = recording(captures=2, formats=(ending,))
    for shot in record(request, tmp_path):
        if shot.name is None:
            continue
        chance = np.random.default_rng([7, 1, shot.station, shot.capture])
        cameras = poses(RIG, TARGET, elevation=np.deg2rad(35), distance=1.2, rng=chance)
        np.testing.assert_allclose(shot.camera_to_world, cameras[shot.station], atol=1e-12)
        expected = capture(SCENE, cameras[shot.station], SMALL, rng=chance)
        scan = read_scan(tmp_path / f"{shot.name}.{ending}")
        assert scan.camera_to_world is not None
        np.testing.assert_allclose(scan.camera_to_world, expected.camera_to_world, atol=1e-9)
        np.testing.assert_array_equal(scan.pixels, expected.pixels)
        np.testing.assert_allclose(scan.points[:, 2], expected.points[:, 2], atol=0.5e-4 + 1e-9 if ending == "png" else 1e-12)
        if ending == "npz":
            np.testing.assert_allclose(scan.amplitude, expected.amplitude)
        if ending != "ply":
            assert scan.intrinsics is not None
            np.testing.assert_allclose(scan.intrinsics.fx, SMALL.intrinsics.fx)


def test_the_truth_is_in_truth_json(tmp_path: Path) -> None:
    error = RangeError(0.01, -0.002)
    request = recording(captures=2, frames=3, error=error, effects=Effects().without("loss"), rig=OPEN)
    shots = record(request, tmp_path)
    content = truth_of(tmp_path)
    assert content == json.loads(json.dumps(truth(request, shots)))
    assert content["schema"] == 1
    assert (content["camera"], content["rig"], content["seed"]) == ("pico_flexx", "five", 7)
    assert (content["frames"], content["perfect"]) == (3, False)
    assert content["range_error"] == {"scale": 0.01, "offset": -0.002}
    assert content["effects"] == {name: name != "loss" for name in Effects.__slots__}
    (box,) = content["boxes"]  # type: ignore[misc]
    np.testing.assert_allclose(box["extents"], [0.35, 0.25, 0.3])
    np.testing.assert_allclose(box["box_to_world"], BOX.box_to_camera)
    np.testing.assert_allclose(box["volume"], 0.35 * 0.25 * 0.3)
    (mesh,) = content["meshes"]  # type: ignore[misc]
    assert mesh["name"] == "block"
    np.testing.assert_allclose([mesh["low"], mesh["extents"]], [[0.5, -0.2, 0.0], [0.2, 0.3, 0.25]])
    floor, side = content["planes"]  # type: ignore[misc]
    np.testing.assert_allclose([*floor["normal"], floor["offset"]], [0, 0, 1, 0])
    np.testing.assert_allclose([*side["normal"], side["offset"]], [-np.cos(2), -np.sin(2), 0, 1.5])
    assert content["reflectivity"] == [0.6, 0.3, 0.5, 0.8]


def test_the_pose_in_the_truth_is_the_scans(tmp_path: Path) -> None:
    for shot in record(recording(rig=OPEN), tmp_path):
        if shot.name is not None:
            scan = read_scan(tmp_path / f"{shot.name}.npz")
            np.testing.assert_allclose(scan.camera_to_world, shot.camera_to_world, atol=1e-12)


@pytest.mark.slow  # two processes import everything anew
def test_two_processes_write_the_same_bytes_as_one(tmp_path: Path) -> None:
    request = recording(captures=2, formats=FORMATS)
    one, two = tmp_path / "one", tmp_path / "two"
    assert record(request, one) == record(request, two, workers=2)
    assert contents(one) == contents(two)


def test_a_seed_is_all_there_is_to_chance(tmp_path: Path) -> None:
    for name, seed in (("first", 1), ("again", 1), ("other", 2)):
        record(recording(seed=seed), tmp_path / name)
    assert contents(tmp_path / "first") == contents(tmp_path / "again")
    first, other = contents(tmp_path / "first"), contents(tmp_path / "other")
    assert all(first[name] != other[name] for name in first)


def test_captures_of_a_station_differ_in_pose_and_noise(tmp_path: Path) -> None:
    shots = record(recording(captures=2), tmp_path)
    assert shots[0].camera_to_world != shots[1].camera_to_world
    still = record(recording(captures=2, rig=replace(RIG, jitter=Jitter())), tmp_path / "still")
    assert still[0].camera_to_world == still[1].camera_to_world
    scans = [read_scan(tmp_path / "still" / f"{shot.name}.npz") for shot in still[:2]]
    both = np.intersect1d(scans[0].pixels, scans[1].pixels)
    assert not np.allclose(*(scan.organised().reshape(-1, 3)[both] for scan in scans), atol=1e-6)


def test_a_perfect_recording_has_no_jitter_and_no_noise(tmp_path: Path) -> None:
    request = recording(perfect=True, captures=2)
    shots = record(request, tmp_path)
    exact = poses(RIG, TARGET, elevation=np.deg2rad(35), distance=1.2)
    for shot in shots:
        np.testing.assert_allclose(shot.camera_to_world, exact[shot.station], atol=1e-12)
        if shot.name is not None:
            expected = capture(SCENE, exact[shot.station], SMALL, rng=None)
            np.testing.assert_allclose(read_scan(tmp_path / f"{shot.name}.npz").points, expected.points, atol=1e-12)
    assert truth_of(tmp_path)["perfect"] is True


def test_the_systematic_error_and_the_frames_are_the_scans_too(tmp_path: Path) -> None:
    error = RangeError(0.02, 0.01)
    still = replace(RIG, jitter=Jitter())
    request = recording(effects=Effects.only(), error=error, rig=still)
    scan = read_scan(tmp_path / "error" / f"{record(request, tmp_path / 'error')[0].name}.npz")
    exact = poses(RIG, TARGET, elevation=np.deg2rad(35), distance=1.2)[0]
    expected = capture(SCENE, exact, SMALL, rng=None, error=error)
    np.testing.assert_allclose(scan.points, expected.points, atol=1e-12)
    request = recording(frames=4, effects=Effects.only("noise"), rig=still)
    averaged = read_scan(tmp_path / f"{record(request, tmp_path)[0].name}.npz")
    true = np.linalg.norm(capture(SCENE, exact, SMALL, rng=None).organised(), axis=-1)
    residual = (np.linalg.norm(averaged.organised(), axis=-1) - true) / SMALL.range_sigma(true, np.ones_like(true))
    assert 0.4 < np.nanstd(residual) < 0.8  # a half, a little more for slopes and the darker bodies


def test_stations_that_leave_it_open_get_the_recordings_elevation_and_distance() -> None:
    cameras, _ = station_poses(recording(perfect=True, elevation=0.9, distance=1.4), 1, 0)
    offset = cameras[1][:3, 3] - TARGET.centre
    np.testing.assert_allclose([np.linalg.norm(offset), np.arcsin(offset[2] / np.linalg.norm(offset))], [1.4, 0.9])


@pytest.mark.parametrize("old", ["view00_000.npz", "truth.json"])
def test_a_folder_with_a_recording_is_left_alone_and_other_files_do_not_matter(old: str, tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("mine")
    record(recording(), tmp_path)
    assert (tmp_path / "notes.txt").read_text() == "mine"
    (tmp_path / "again").mkdir()
    (tmp_path / "again" / old).write_text("old")
    with pytest.raises(ConfigError, match="holds a recording already"):
        record(recording(), tmp_path / "again")
    assert [path.name for path in (tmp_path / "again").iterdir()] == [old]


def test_a_perfect_camera_says_so_in_its_truth_and_takes_no_error(tmp_path: Path) -> None:
    record(recording(perfect=True), tmp_path)
    told = json.loads((tmp_path / "truth.json").read_text())
    assert told["perfect"] is True
    assert not any(told["effects"].values())
    assert told["range_error"] == {"scale": 0.0, "offset": 0.0}
    with pytest.raises(ConfigError, match="systematic"):
        recording(perfect=True, error=RangeError(0.01, 0.0))


def test_a_camera_behind_a_wall_or_inside_a_box_takes_no_scan(tmp_path: Path) -> None:
    """ring2 stands at azimuths 0 and 180: a wall before the first, a box around the second."""
    around = standing_box(np.array([0.3, 0.3, 1.5]), at=(-1.0, 0.0))
    scene = Scene((BOX, around), planes=(FLOOR, wall(0.0, 0.5)))
    shots = record(recording(scene=scene, rig=ring(2), perfect=True), tmp_path)
    assert [shot.reason for shot in shots] == ["behind a wall", "inside a box"]


@pytest.mark.parametrize("workers", [1, 2])
def test_a_folder_that_cannot_be_made_is_one_line(workers: int, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    for folder in (tmp_path / "file", tmp_path / "file" / "below"):
        with pytest.raises(ScanError) as raised:
            record(recording(), folder, workers=workers)
        assert "\n" not in str(raised.value)
        assert str(folder) in str(raised.value)


def test_a_disk_that_fills_up_is_one_line_and_there_is_no_truth(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The last scan has no room; the ones before it are whole and stay."""
    replaced = os.replace

    def full(source: Path, to: Path) -> None:
        if "view04" in str(to):
            raise OSError(28, "No space left on device")
        replaced(source, to)

    monkeypatch.setattr(os, "replace", full)
    with pytest.raises(ScanError, match=r"view04_000.*No space left") as raised:
        record(recording(), tmp_path)
    assert "\n" not in str(raised.value)
    assert not (tmp_path / "truth.json").exists()
    assert len(read_scan(tmp_path / "view00_000.npz").points) > 100


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"captures": 0}, "0 captures"),
        ({"frames": 0}, "0 frames"),
        ({"formats": ()}, "png, npz, ply"),
        ({"formats": ("png", "exr")}, "exr"),
    ],
)
def test_recordings_that_make_no_sense_are_refused(changes: dict[str, object], message: str) -> None:
    with pytest.raises(ConfigError, match=message):
        recording(**changes)


def test_threads_are_single_only_inside_and_also_after_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("OMP_NUM_THREADS", "5")
    monkeypatch.delenv("MKL_NUM_THREADS", raising=False)
    with single_threads():
        assert os.environ["OMP_NUM_THREADS"] == os.environ["MKL_NUM_THREADS"] == "1"
    assert os.environ["OMP_NUM_THREADS"] == "5"
    with pytest.raises(ValueError, match="inside"), single_threads():
        raise ValueError("inside")
    assert os.environ["OMP_NUM_THREADS"] == "5"
    assert "MKL_NUM_THREADS" not in os.environ


def long_range(farthest: float) -> Sensor:
    return replace(SMALL, range_max=farthest, weakest=0.0)


@pytest.mark.parametrize("farthest", [7.2, 20.0])
def test_a_camera_of_long_range_is_written_as_a_depth_image(farthest: float, tmp_path: Path) -> None:
    scene = Scene((BOX,), planes=(FLOOR, wall(np.pi + 0.3, farthest - 1.5)))
    rig = Rig(name="one", stations=(Station(azimuth=0.3, elevation=0.1, distance=1.0),))
    (shot,) = record(recording(scene=scene, rig=rig, sensor=long_range(farthest), perfect=True, formats=("png",)), tmp_path)
    scan: Scan = read_scan(tmp_path / f"{shot.name}.png")
    assert scan.points[:, 2].max() > farthest - 2
