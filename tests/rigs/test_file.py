"""Rig files: read as documented, written and read back, and refused in one line."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.rigs.cameras import EYE, UP, orbit
from viewgain.errors import ConfigError
from viewgain.rigs import RIGS, KeepOut, Rig, Station, hemisphere, irregular_rig, read_rig, rig, to_toml

DOCUMENTED = """
name = "cell"
absolute = true
min_distance = 0.3
max_distance = 1.5
min_height = 0.2
max_height = 2

[jitter]
azimuth_deg = 5
elevation_deg = [-1, 2]
distance_share = 0.05
position_m = [0.1, 0.1, [0, 0.05]]
aim_m = [0, 0.02, 0]
rotation_deg = [1, 1, [0, 3]]

[[keep_out]]
axis = [0, 0, 2]
half_angle_deg = 20

[[keep_out]]
axis = [-1, 0, 0]
half_angle_deg = 35
apex = [0.1, 0.2, 0.3]

[[view]]
azimuth_deg = -90
elevation_deg = 45
distance_m = 0.9

[[view]]

[[view]]
corner = 2
unnormalised = true

[[view]]
camera_to_world = [[1, 0, 0, 0], [0, -1, 0, 0], [0, 0, -1, 1.5], [0, 0, 0, 1]]
"""


def written(text: str, folder: Path) -> Rig:
    path = folder / "cell.toml"
    path.write_text(text, encoding="utf-8")
    return rig(str(path))


def assert_same(found: Rig, expected: Rig) -> None:
    """To rounding: the file is in degrees."""
    assert (found.name, found.absolute, len(found.stations)) == (expected.name, expected.absolute, len(expected.stations))
    limits = [(r.min_distance, r.max_distance, r.min_height, r.max_height) for r in (found, expected)]
    assert limits[0] == limits[1]
    np.testing.assert_allclose(found.jitter.bounds, expected.jitter.bounds, rtol=1e-12, atol=0)
    for one, other in zip(found.keep_out, expected.keep_out, strict=True):
        np.testing.assert_allclose(one.axis, other.axis, rtol=1e-12)
        np.testing.assert_allclose(one.half_angle, other.half_angle, rtol=1e-12)
        np.testing.assert_equal(one.apex, other.apex)
    for mine, theirs in zip(found.stations, expected.stations, strict=True):
        assert (mine.name, mine.corner, mine.unnormalised) == (theirs.name, theirs.corner, theirs.unnormalised)
        assert mine.distance == theirs.distance
        assert (mine.elevation is None) == (theirs.elevation is None)
        angles = [(station.azimuth, station.elevation or 0.0) for station in (mine, theirs)]
        np.testing.assert_allclose(angles[0], angles[1], rtol=1e-12)
        assert (mine.camera_to_world is None) == (theirs.camera_to_world is None)
        if theirs.camera_to_world is not None:
            np.testing.assert_allclose(mine.camera_to_world, theirs.camera_to_world, atol=1e-12)


def test_a_rig_file_is_read_as_documented(tmp_path: Path) -> None:
    cell = written(DOCUMENTED, tmp_path)
    assert (cell.name, cell.absolute, len(cell.stations)) == ("cell", True, 4)
    assert (cell.min_distance, cell.max_distance, cell.min_height, cell.max_height) == (0.3, 1.5, 0.2, 2.0)
    first, second, third, fourth = cell.stations
    np.testing.assert_allclose((first.azimuth, first.elevation, first.distance), (-np.pi / 2, np.pi / 4, 0.9))
    assert second == Station()
    assert third == Station(corner=2, unnormalised=True)
    np.testing.assert_allclose(fourth.camera_to_world, [[1, 0, 0, 0], [0, -1, 0, 0], [0, 0, -1, 1.5], [0, 0, 0, 1]], atol=1e-12)
    degrees = np.rad2deg(cell.jitter.bounds)
    np.testing.assert_allclose(degrees[:2], [[-5, 5], [-1, 2]])
    np.testing.assert_allclose(cell.jitter.bounds[2:9], [[-0.05, 0.05], [-0.1, 0.1], [-0.1, 0.1], [0, 0.05], [0, 0],
                                                         [-0.02, 0.02], [0, 0]])  # fmt: skip
    np.testing.assert_allclose(degrees[9:], [[-1, 1], [-1, 1], [0, 3]])
    ceiling, base = cell.keep_out
    np.testing.assert_allclose(ceiling.axis, UP)
    np.testing.assert_allclose(np.rad2deg([ceiling.half_angle, base.half_angle]), [20, 35])
    assert ceiling.apex is None
    np.testing.assert_allclose(base.apex, [0.1, 0.2, 0.3])


def test_a_rig_file_without_name_and_limits_has_the_defaults(tmp_path: Path) -> None:
    path = tmp_path / "arm-7.toml"
    path.write_text("[[view]]\n")
    found = read_rig(path)
    assert_same(found, Rig(name="arm-7", stations=(Station(),)))
    assert (found.min_distance, found.max_distance, found.min_height, found.max_height) == (0.25, np.inf, 0.05, np.inf)


def test_the_example_of_the_docs_is_read(tmp_path: Path) -> None:
    page = (Path(__file__).resolve().parents[2] / "docs" / "rigs.md").read_text(encoding="utf-8")
    example = page.split("```toml")[1].split("```")[0]
    cell = written(example, tmp_path)
    assert (len(cell.stations), len(cell.keep_out)) == (4, 2)


@pytest.mark.parametrize("name", [*RIGS, "ring3", "hemisphere12"])
def test_presets_survive_being_written_and_read(name: str, tmp_path: Path) -> None:
    assert_same(written(to_toml(rig(name)), tmp_path), rig(name))


@given(st.integers(0, 2**32), st.text(st.characters(codec="utf-8", exclude_categories=("Cc", "Cs")), min_size=1))
def test_any_rig_survives_being_written_and_read(tmp_path_factory: pytest.TempPathFactory, seed: int, name: str) -> None:
    rng = np.random.default_rng(seed)
    cones = (KeepOut(axis=rng.normal(size=3), half_angle=1.0), KeepOut(axis=UP, half_angle=0.1, apex=rng.normal(size=3)))
    drawn = irregular_rig(3, rng=rng)
    posed = Station(camera_to_world=orbit(np.zeros(3), 1.0, 0.5, 2.0), name="on_the_wall")
    stations = (*drawn.stations, Station(corner=1, unnormalised=True, name="left-1"), posed)
    whole = replace(drawn, name=name, stations=stations, keep_out=cones, max_height=float(rng.uniform(1, 3)))
    assert_same(written(to_toml(whole), tmp_path_factory.mktemp("rigs")), whole)


BAD = {
    "no view": "name = 'x'\n",
    "nothing": "",
    "an empty list of views": "view = []\n",
    "views that are no tables": "view = [1, 2]\n",
    "a view that is a number": "view = 3\n",
    "a view that is no list": "[view]\nazimuth_deg = 3\n",
    "an unknown key at the top": "speed = 2\n[[view]]\n",
    "an unknown key in a view": "[[view]]\nazimuth = 3\n",
    "an angle in words": "[[view]]\nelevation_deg = 'high'\n",
    "an angle as text": "[[view]]\nelevation_deg = '45'\n",
    "an angle that is true": "[[view]]\nelevation_deg = true\n",
    "an angle that is a list": "[[view]]\nazimuth_deg = [1]\n",
    "an angle that is no number": "[[view]]\nazimuth_deg = nan\n",
    "an angle of many digits": f"[[view]]\nazimuth_deg = 1{'0' * 400}\n",
    "an infinite distance": "[[view]]\ndistance_m = inf\n",
    "no distance at all": "[[view]]\ndistance_m = 0\n",
    "a negative distance": "[[view]]\ndistance_m = -0.5\n",
    "a fifth corner": "[[view]]\ncorner = 4\n",
    "half a corner": "[[view]]\ncorner = 0.5\n",
    "a corner that is true": "[[view]]\ncorner = true\n",
    "a name that is a number": "[[view]]\nname = 3\n",
    "a name that leaves its folder": "[[view]]\nname = '../left'\n",
    "a name that is hidden": "[[view]]\nname = '.left'\n",
    "a name twice": "[[view]]\nname = 'left'\n[[view]]\nname = 'left'\n",
    "unnormalised in words": "[[view]]\ncorner = 0\nunnormalised = 'yes'\n",
    "unnormalised without a corner": "[[view]]\nunnormalised = true\n",
    "a pose and an angle": f"[[view]]\nazimuth_deg = 3\ncamera_to_world = {EYE.tolist()}\n",
    "a scaled pose": "[[view]]\ncamera_to_world = [[2,0,0,0],[0,2,0,0],[0,0,2,0],[0,0,0,1]]\n",
    "a pose with a hole": "[[view]]\ncamera_to_world = [[1,0,0,0],[0,1,0],[0,0,1,0],[0,0,0,1]]\n",
    "a small pose": "[[view]]\ncamera_to_world = [[1, 2], [3, 4]]\n",
    "a pose in words": "[[view]]\ncamera_to_world = 'home'\n",
    "a pose that is not finite": "[[view]]\ncamera_to_world = [[1,0,0,nan],[0,1,0,0],[0,0,1,0],[0,0,0,1]]\n",
    "a limit in words": "min_height = 'low'\n[[view]]\n",
    "a limit that is no number": "min_distance = nan\n[[view]]\n",
    "limits that cross": "min_height = 1\nmax_height = 0.5\n[[view]]\n",
    "absolute by half": "absolute = 0.5\n[[view]]\n",
    "jitter that is no table": "jitter = 3\n[[view]]\n",
    "an unknown key in the jitter": "jitter = {azimuth = 3}\n[[view]]\n",
    "jitter backwards": "jitter = {azimuth_deg = [3, -3]}\n[[view]]\n",
    "negative jitter": "jitter = {azimuth_deg = -3}\n[[view]]\n",
    "jitter of three bounds": "jitter = {azimuth_deg = [1, 2, 3]}\n[[view]]\n",
    "a shift of two axes": "jitter = {position_m = [1, 2]}\n[[view]]\n",
    "a shift of one number": "jitter = {position_m = 1}\n[[view]]\n",
    "a distance of nothing": "jitter = {distance_share = 1}\n[[view]]\n",
    "an empty list of cones": "keep_out = []\n[[view]]\n",
    "a cone without axis": "[[keep_out]]\nhalf_angle_deg = 3\n[[view]]\n",
    "a cone without angle": "[[keep_out]]\naxis = [0, 0, 1]\n[[view]]\n",
    "a cone without direction": "[[keep_out]]\naxis = [0, 0, 0]\nhalf_angle_deg = 3\n[[view]]\n",
    "a cone in the plane": "[[keep_out]]\naxis = [0, 1]\nhalf_angle_deg = 3\n[[view]]\n",
    "a cone too wide": "[[keep_out]]\naxis = [0, 0, 1]\nhalf_angle_deg = 181\n[[view]]\n",
    "a cone of unknown keys": "[[keep_out]]\naxis = [0, 0, 1]\nhalf_angle = 1\n[[view]]\n",
    "a cone with a tip in words": "[[keep_out]]\naxis = [0, 0, 1]\nhalf_angle_deg = 3\napex = 'base'\n[[view]]\n",
    "broken TOML": "[[view]\n",
    "not text": b"\xff\xfe\x00\x01",
}


@pytest.mark.parametrize("case", BAD)
def test_a_bad_rig_file_is_refused_in_one_line_that_names_it(case: str, tmp_path: Path) -> None:
    path, content = tmp_path / "cell.toml", BAD[case]
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    with pytest.raises(ConfigError) as caught:
        rig(str(path))
    assert str(caught.value).count(str(path)) == 1
    assert "\n" not in str(caught.value)


def test_what_is_wrong_is_named_by_its_place(tmp_path: Path) -> None:
    for text, place in (
        ("[[view]]\n[[view]]\nsped = 3\n", r"cell\.toml: view 1: .*sped"),
        ("[[view]]\n[[keep_out]]\naxis = [0, 0, 1]\nhalf_angle_deg = 0\n", r"cell\.toml: keep_out 0: .*half angle"),
        ("[[view]]\n[jitter]\nspeed = 3\n", r"cell\.toml: jitter: .*speed"),
    ):
        with pytest.raises(ConfigError, match=place):
            written(text, tmp_path)


def test_a_missing_file_and_a_folder_are_refused(tmp_path: Path) -> None:
    (tmp_path / "folder.toml").mkdir()
    for name in ("nowhere.toml", "folder.toml", "nul\0.toml"):
        with pytest.raises(ConfigError, match="cannot be read as a rig file") as caught:
            rig(str(tmp_path / name))
        assert "\n" not in str(caught.value)


def test_a_file_holds_degrees() -> None:
    assert "azimuth_deg = 45.0" in to_toml(rig("ring8"))
    assert "max_height = inf" in to_toml(hemisphere(1))
