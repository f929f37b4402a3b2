"""Rigs: the presets, where their stations stand, and the files that people write."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from viewgain.errors import ConfigError
from viewgain.geometry import inverse, look_at, pose, require_rigid, rotation_from_rotvec, transform
from viewgain.plan import RIGS, Rig, Station, place, rig
from viewgain.simulate import orbit_pose

TARGET = np.array([0.3, -0.2, 0.25])
"""World."""


def placed(stations: Rig, camera: np.ndarray, **options: float) -> np.ndarray:
    """The stations' poses in the world, for a camera (world, floor z = 0) that looks roughly at the target."""
    world_to_camera = inverse(camera)
    return np.asarray(camera @ place(stations, transform(world_to_camera, TARGET), world_to_camera, camera, **options))


def seen_from(world_pose: np.ndarray) -> tuple[float, float, float]:
    """Azimuth, elevation (degrees) and distance of a camera as seen from the target."""
    offset = world_pose[:3, 3] - TARGET
    distance = float(np.linalg.norm(offset))
    return float(np.rad2deg(np.arctan2(offset[1], offset[0]))), float(np.rad2deg(np.arcsin(offset[2] / distance))), distance


@pytest.mark.parametrize(("name", "count"), [("ring8", 8), ("paper4", 4), ("pcnbv33", 33)])
def test_presets_have_their_number_of_stations_and_know_their_name(name: str, count: int) -> None:
    assert rig(name) is RIGS[name]
    assert len(rig(name).stations) == count
    assert rig(name).name == name
    assert rig(rig(name)) is rig(name)


def test_there_are_no_other_presets_untested() -> None:
    assert set(RIGS) == {"ring8", "paper4", "pcnbv33"}


@given(
    st.floats(-180, 180),
    st.floats(5, 80),
    st.floats(0.5, 2),
    st.floats(-30, 30),
    st.floats(-10, 10),
    st.sampled_from(sorted(RIGS)),
)
def test_every_station_is_a_camera_that_looks_at_the_target_upright(
    azimuth: float, elevation: float, distance: float, roll: float, aside: float, name: str
) -> None:
    camera = orbit_pose(TARGET, *np.deg2rad([azimuth, elevation]), distance, float(np.deg2rad(roll)))
    camera = camera @ pose(rotation_from_rotvec(np.deg2rad([aside, -aside, 0])), np.zeros(3))  # not quite aimed
    for station in placed(rig(name), camera):
        require_rigid(station, "station")
        seen = transform(inverse(station), TARGET)
        np.testing.assert_allclose(seen[:2], 0, atol=1e-9)
        assert seen[2] > 0.1
        if seen_from(station)[1] < 89:
            np.testing.assert_allclose(station[2, 0], 0, atol=1e-9, err_msg="level")
            assert station[2, 1] < 0


@given(st.floats(-180, 180), st.floats(11, 80), st.floats(0.5, 2))
def test_the_ring_keeps_height_and_distance_and_starts_where_the_camera_is(
    azimuth: float, elevation: float, distance: float
) -> None:
    camera = orbit_pose(TARGET, *np.deg2rad([azimuth, elevation]), distance)
    stations = placed(rig("ring8"), camera)
    np.testing.assert_allclose(stations[0], camera, atol=1e-6)
    np.testing.assert_allclose(stations[:, 2, 3], camera[2, 3], atol=1e-9)
    around = [seen_from(station) for station in stations]
    np.testing.assert_allclose([each[2] for each in around], distance, rtol=1e-9)
    steps = np.diff([each[0] for each in around])
    np.testing.assert_allclose((steps + 180) % 360 - 180, 45, atol=1e-6)  # anticlockwise from above: to the camera's right


def test_positive_azimuth_is_to_the_right_of_the_camera() -> None:
    camera = orbit_pose(TARGET, 0.4, 0.5, 1.0)
    (station,) = placed(Rig(name="t", stations=(Station(azimuth=0.2),)), camera)
    assert (inverse(camera) @ station)[0, 3] > 0.1


@given(st.floats(-180, 180), st.floats(5, 80))
def test_the_papers_stations_stand_at_the_papers_offsets_and_heights(azimuth: float, elevation: float) -> None:
    """Horizontal offset d and height d tan(180 / 3.5) or d tan(180 / 2.9) degrees over the target, d = 1 and 1.3 m."""
    camera = orbit_pose(TARGET, *np.deg2rad([azimuth, elevation]), 1.0)
    offsets = [station[:3, 3] - TARGET for station in placed(rig("paper4"), camera)]
    np.testing.assert_allclose([np.linalg.norm(offset[:2]) for offset in offsets], [1.0, 1.0, 1.3, 1.3], rtol=1e-9)
    rise = [d * np.tan(np.pi / part) for d in (1.0, 1.3) for part in (3.5, 2.9)]
    np.testing.assert_allclose([offset[2] for offset in offsets], rise, rtol=1e-9)
    for offset in offsets:
        np.testing.assert_allclose(np.rad2deg(np.arctan2(offset[1], offset[0])), (azimuth + 180) % 360 - 180, atol=1e-6)


def test_pcnbv_stations_stand_in_the_directions_of_the_public_list(data_dir: Path) -> None:
    """Placed, not only listed: the list is y-up and counts azimuth from its z, which here is the present direction."""
    public = np.loadtxt(data_dir / "views" / "viewspace_shapenet_33.txt")
    camera = orbit_pose(TARGET, np.deg2rad(25), np.deg2rad(40), 1.4)
    ahead = np.array([np.cos(np.deg2rad(25)), np.sin(np.deg2rad(25)), 0.0])
    up = np.array([0.0, 0.0, 1.0])
    axes = np.column_stack([np.cross(up, ahead), up, ahead])  # the list's x, y, z in our world
    found = np.array([(station[:3, 3] - TARGET) / 1.4 for station in placed(rig("pcnbv33"), camera)])
    np.testing.assert_allclose(found, public @ axes.T, atol=1e-9)


@pytest.mark.parametrize("name", sorted(RIGS))
def test_a_camera_straight_overhead_has_stations_too(name: str) -> None:
    camera = look_at(TARGET + np.array([0, 0, 1.2]), TARGET, np.array([0.0, 1.0, 0.0]))
    stations = placed(rig(name), camera)
    assert np.all(np.isfinite(stations))
    for station in stations:
        require_rigid(station, "station")
    if name == "ring8":
        np.testing.assert_allclose(stations[0], camera, atol=1e-6)


def test_stations_keep_what_they_do_not_state_and_step_back_on_demand() -> None:
    camera = orbit_pose(TARGET, 0.4, np.deg2rad(40), 1.0)
    stations = (
        Station(azimuth=1.0),
        Station(elevation=0.3),
        Station(distance=0.8),
        Station(azimuth=0.5, elevation=1.0, distance=2.0),
    )
    for factor in (1.0, 1.5):
        angles = [seen_from(station) for station in placed(Rig(name="t", stations=stations), camera, step_back=factor)]
        degrees = np.rad2deg(0.4)
        expected = [
            (degrees + np.rad2deg(1.0), 40, factor), (degrees, np.rad2deg(0.3), factor), (degrees, 40, 0.8),
            (degrees + np.rad2deg(0.5), np.rad2deg(1.0), 2.0),
        ]  # fmt: skip
        np.testing.assert_allclose(angles, expected, atol=1e-6)


def test_a_rig_file_is_read_as_documented(tmp_path: Path) -> None:
    path = tmp_path / "cell.toml"
    path.write_text(
        'name = "cell"\nmin_distance = 0.3\nmin_height = 0.2\n[[view]]\nazimuth_deg = -90\nelevation_deg = 45\ndistance_m = 0.9\n'
        "[[view]]\n[[view]]\ncamera_to_world = [[1, 0, 0, 0], [0, -1, 0, 0], [0, 0, -1, 1.5], [0, 0, 0, 1]]\n"
    )
    cell = rig(str(path))
    assert (cell.name, cell.min_distance, cell.min_height, len(cell.stations)) == ("cell", 0.3, 0.2, 3)
    first, second, third = cell.stations
    np.testing.assert_allclose((first.azimuth, first.elevation, first.distance), (-np.pi / 2, np.pi / 4, 0.9))
    assert (second.azimuth, second.elevation, second.distance, second.camera_to_world) == (0.0, None, None, None)
    np.testing.assert_allclose(third.camera_to_world, [[1, 0, 0, 0], [0, -1, 0, 0], [0, 0, -1, 1.5], [0, 0, 0, 1]], atol=1e-12)


def test_a_rig_file_without_name_and_limits_has_the_defaults(tmp_path: Path) -> None:
    path = tmp_path / "arm-7.toml"
    path.write_text("[[view]]\n")
    assert (rig(str(path)).name, rig(str(path)).min_distance, rig(str(path)).min_height) == ("arm-7", 0.25, 0.05)


BAD = {
    "no view": ("name = 'x'\n", ()),
    "an empty list of views": ("view = []\n", ()),
    "views that are no tables": ("view = [1, 2]\n", ()),
    "a view that is no list": ("[view]\nazimuth_deg = 3\n", ()),
    "an unknown key at the top": ("speed = 2\n[[view]]\n", ()),
    "an unknown key in a view": ("[[view]]\nazimuth = 3\n", ()),
    "an angle in words": ("[[view]]\nelevation_deg = 'high'\n", ()),
    "an angle that is a list": ("[[view]]\nazimuth_deg = [1]\n", ()),
    "an angle that is no number": ("[[view]]\nazimuth_deg = nan\n", ()),
    "an infinite distance": ("[[view]]\ndistance_m = inf\n", ()),
    "no distance at all": ("[[view]]\ndistance_m = 0\n", ()),
    "a negative distance": ("[[view]]\ndistance_m = -0.5\n", ()),
    "a scaled pose": ("[[view]]\ncamera_to_world = [[2,0,0,0],[0,2,0,0],[0,0,2,0],[0,0,0,1]]\n", ()),
    "a pose with a hole": ("[[view]]\ncamera_to_world = [[1,0,0,0],[0,1,0],[0,0,1,0],[0,0,0,1]]\n", ()),
    "a pose in words": ("[[view]]\ncamera_to_world = 'home'\n", ()),
    "a pose that is not finite": ("[[view]]\ncamera_to_world = [[1,0,0,nan],[0,1,0,0],[0,0,1,0],[0,0,0,1]]\n", ()),
    "a limit in words": ("min_height = 'low'\n[[view]]\n", ()),
    "a limit that is no number": ("min_distance = nan\n[[view]]\n", ()),
    "broken TOML": ("[[view]\n", ()),
    "not text": (b"\xff\xfe\x00\x01", ()),
}


@pytest.mark.parametrize("case", [pytest.param(name, marks=marks) for name, (_, marks) in BAD.items()])
def test_a_bad_rig_file_is_refused_in_one_line_that_names_it(case: str, tmp_path: Path) -> None:
    path, content = tmp_path / "cell.toml", BAD[case][0]
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    with pytest.raises(ConfigError) as caught:
        rig(str(path))
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_view_is_named_by_its_place(tmp_path: Path) -> None:
    path = tmp_path / "cell.toml"
    path.write_text("[[view]]\n[[view]]\nsped = 3\n")
    with pytest.raises(ConfigError, match=r"view 1.*sped"):
        rig(str(path))


def test_a_missing_file_and_an_unknown_preset_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"nowhere\.toml") as caught:
        rig(str(tmp_path / "nowhere.toml"))
    assert "\n" not in str(caught.value)
    with pytest.raises(ConfigError, match=r"'ring9' is not known; choose one of .*paper4"):
        rig("ring9")
    folder = tmp_path / "folder.toml"
    folder.mkdir()
    with pytest.raises(ConfigError, match=r"folder\.toml"):
        rig(str(folder))
