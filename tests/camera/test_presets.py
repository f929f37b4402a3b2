"""Cameras by name and cameras of one's own: the TOML format, its refusals, and where each number of a preset comes from."""

import math
import re
import subprocess
import sys
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from viewgain.camera import PRESETS, Sensor, sensor
from viewgain.camera._presets import _table
from viewgain.camera._sensor_file import ANGLES, FIELDS, parse, sensor_from_table
from viewgain.errors import ConfigError

OWN = """
name = "mine"
[image]
width = 320
height = 240
horizontal_deg = 60
vertical_deg = 47.5
"""
FOCAL = "[image]\nwidth = 64\nheight = 48\nfx = 55\nfy = 54.0\n"
FOLDER = resources.files("viewgain.camera") / "presets"
OPTIONAL = {"range.unambiguous", "range.modulation_hz", "systematic.scale", "systematic.offset"}
"""What a preset may leave open: what not every data sheet says or every camera has, and the known error of one single camera."""


def numbers(content: dict[str, Any]) -> set[str]:
    return {f"{section}.{key}" for section in ("image", *FIELDS) for key in content.get(section, {})}


def camera_file(folder: Path, text: str) -> Path:
    path = folder / "cell.toml"
    path.write_text(text)
    return path


def refusal(folder: Path, text: str) -> str:
    """The message that refuses a file: one line that names it."""
    path = camera_file(folder, text)
    with pytest.raises(ConfigError) as caught:
        sensor(path)
    message = str(caught.value)
    assert message.startswith(f"{path}: ")
    assert "\n" not in message
    return message


def test_the_names_are_those_of_the_files() -> None:
    assert list(PRESETS) == sorted(entry.name.removesuffix(".toml") for entry in FOLDER.iterdir() if entry.name.endswith(".toml"))


@pytest.mark.parametrize("name", PRESETS)
def test_a_preset_knows_its_own_name_and_is_read_once(name: str) -> None:
    assert sensor(name).name == name
    assert sensor(name) is sensor(name)


@pytest.mark.parametrize("name", PRESETS)
def test_every_number_of_a_preset_has_a_source(name: str) -> None:
    content = _table(name)
    sources = content["sources"]
    unsourced = [key for key in numbers(content) if key not in sources and key.partition(".")[0] not in sources]
    assert unsourced == []
    assert all(len(text) > 10 for text in sources.values())


@pytest.mark.parametrize("name", PRESETS)
def test_a_preset_leaves_no_number_to_a_default_without_a_source(name: str) -> None:
    wanted = {f"{section}.{key}" for section, keys in FIELDS.items() for key in keys} | {f"image.{key}" for key in ANGLES}
    assert wanted - numbers(_table(name)) <= OPTIONAL


@pytest.mark.parametrize("name", PRESETS)
def test_a_preset_that_changes_a_number_says_why(name: str) -> None:
    """A file that extends another must not inherit the source of the number that it replaces."""
    own = parse((FOLDER / f"{name}.toml").read_text(), name)
    sources = own["sources"]
    assert [key for key in numbers(own) if key not in sources and key.partition(".")[0] not in sources] == []


def test_importing_the_room_reads_no_preset() -> None:
    code = (
        "import sys, builtins, io\n"
        "opened = []\n"
        "sys.addaudithook(lambda event, args: opened.append(str(args[0])) if event == 'open' else None)\n"
        "from viewgain.camera import PRESETS, sensor\n"
        "assert not [name for name in opened if name.endswith('.toml')], opened\n"
        "sensor('xtion')\n"
        "assert [name for name in opened if name.endswith('.toml')], 'the audit hook sees nothing'\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True, timeout=60)


def test_an_unknown_camera_is_refused_with_the_names_of_the_known_ones() -> None:
    with pytest.raises(ConfigError) as caught:
        sensor("kinect_v9")
    assert "'kinect_v9'" in str(caught.value)
    assert all(name in str(caught.value) for name in PRESETS)


def test_the_femto_is_the_azure_kinect_by_another_name() -> None:
    for mode in ("nfov", "wfov"):
        femto, azure = _table(f"femto_{mode}"), _table(f"azure_kinect_{mode}")
        assert {key: femto[key] for key in ("image", *FIELDS)} == {key: azure[key] for key in ("image", *FIELDS)}


def test_the_kinect_v2_wraps_where_its_three_frequencies_meet() -> None:
    assert sensor("kinect_v2").unambiguous == pytest.approx(299_792_458 / (2 * math.gcd(16, 80, 120) * 1e6), abs=0.005)


def test_an_own_camera_has_what_its_file_says_and_the_defaults(tmp_path: Path) -> None:
    text = OWN + "[noise]\nconstant = 0.001\nper_metre = 0\n[signal]\ngrazing_start_deg = 65\n[range]\nunambiguous = inf\n"
    camera = sensor(str(camera_file(tmp_path, text)))
    plain = Sensor(name="plain", intrinsics=camera.intrinsics)
    assert (camera.name, camera.kind, camera.intrinsics.width, camera.intrinsics.height) == ("mine", "tof", 320, 240)
    assert camera.intrinsics.fx == pytest.approx(160 / np.tan(np.deg2rad(30)), rel=1e-12)
    assert (camera.noise_constant, camera.noise_per_metre, camera.unambiguous) == (0.001, 0.0, np.inf)
    assert camera.grazing_start == pytest.approx(np.deg2rad(65), rel=1e-12)
    assert (camera.range_max, camera.scale_sd, camera.lateral_px) == (plain.range_max, plain.scale_sd, plain.lateral_px)


def test_a_file_without_a_name_is_called_by_its_own(tmp_path: Path) -> None:
    assert sensor(camera_file(tmp_path, OWN.replace('name = "mine"', ""))).name == "cell"
    assert sensor(camera_file(tmp_path, 'extends = "xtion"')).name == "cell"


def test_a_calibrated_camera_gives_its_lens(tmp_path: Path) -> None:
    text = FOCAL + "cx = 30.7\ncy = 24.9\ndistortion = [-0.3, 0.1, 0, 0.001]"
    intrinsics = sensor(camera_file(tmp_path, text)).intrinsics
    assert (intrinsics.fx, intrinsics.fy, intrinsics.cx, intrinsics.cy) == (55.0, 54.0, 30.7, 24.9)
    assert intrinsics.distortion == (-0.3, 0.1, 0.0, 0.001)


def test_a_file_that_extends_a_preset_changes_what_it_says_and_nothing_else(tmp_path: Path) -> None:
    text = 'extends = "kinect_v2"\n' + FOCAL + "cx = 31\ncy = 23\n[systematic]\nscale_sd = 0.001"
    mine, base = sensor(camera_file(tmp_path, text)), sensor("kinect_v2")
    assert (mine.intrinsics.fx, mine.scale_sd) == (55.0, 0.001)
    assert (mine.offset_sd, mine.noise_constant, mine.kind) == (base.offset_sd, base.noise_constant, base.kind)


@given(
    st.sampled_from(sorted(FIELDS)).flatmap(lambda s: st.tuples(st.just(s), st.sampled_from(sorted(FIELDS[s])))),
    st.floats(0.01, 1),
)
def test_every_key_reaches_its_field(key: tuple[str, str], share: float) -> None:
    section, name = key
    value = {"min": 3 * share, "max": 0.2 + 5 * share, "grazing_start_deg": 80 * share, "grazing_end_deg": 85 + share}.get(
        name, share
    )
    content = {"image": {"width": 64, "height": 48, "horizontal_deg": 60, "vertical_deg": 45}, section: {name: value}}
    if name == "grazing_start_deg":
        content[section] = {name: value, "grazing_end_deg": 89}
    camera = sensor_from_table(content, "cell.toml", default_name="cell")
    expected = np.deg2rad(value) if name.endswith("_deg") else value
    assert getattr(camera, FIELDS[section][name]) == expected


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("not TOML", "cannot be read as a camera file"),
        ("x = " + "9" * 5000, "cannot be read as a camera file"),
        ("", "lacks image.width"),
        ("[image]\nwidth = 64\nheight = 48", "lacks image.horizontal_deg"),
        ("[image]\nwidth = 64\nheight = 48\nfx = 50", "lacks image.fy"),
        (OWN + "fx = 50", "unknown key image.horizontal_deg"),
        (OWN + "distortion = [0, 0, 0, 0]", "unknown key image.distortion"),
        (OWN.replace("320", "320.0"), "image.width = 320.0, wanted a whole number"),
        (OWN.replace("320", '"320"'), "image.width = 320, wanted a number"),
        (OWN.replace("320", "0"), "0 x 240 pixels"),
        (OWN.replace("= 60", "= 180"), "image.horizontal_deg = 180"),
        (OWN.replace("= 60", "= nan"), "image.horizontal_deg = nan"),
        ("image = 3", "got image = 3, wanted a section"),
        ("colour = 3\n" + OWN, "unknown key colour"),
        (OWN + "[noise]\nper_meter = 0.01", "unknown key noise.per_meter; wanted constant, per_metre"),
        (OWN + "[noise]\nper_metre = nan", "noise.per_metre = nan, wanted a finite number"),
        (OWN + "[noise]\nper_metre = true", "noise.per_metre = True, wanted a number"),
        (OWN + '[noise]\nper_metre = "1 %"', "noise.per_metre = 1 %, wanted a number"),
        (OWN + "[range]\nmax = inf", "range.max = inf"),
        (OWN + "[range]\nunambiguous = nan", "range.unambiguous = nan"),
        (OWN + "[range]\nmax = 1" + "0" * 400, "range.max of more than 300 digits"),
        (OWN + "[range]\nmin = 5", "got range 5.0 to 4.0 m"),
        (OWN + "[lateral]\npx = -1", "lateral.px = -1"),
        (OWN + "[quantisation]\nper_square_metre = -1", "quantisation.per_square_metre = -1"),
        (OWN + "[noise]\nper_square_metre = -1", "the noise is negative somewhere"),
        ('kind = "stereo"\n' + OWN, "kind 'stereo'"),
        ("kind = 3\n" + OWN, "got kind = 3"),
        (OWN.replace('"mine"', '"two\\nlines"'), "wanted one line of text"),
        ('extends = "nothing"\n' + OWN, "extends = 'nothing', wanted one of"),
        ("extends = []\n" + OWN, "extends = '[]'"),
        (OWN + '[sources]\nnoise.per_metre = "data sheet"', "got sources.noise ="),
        (OWN + '[sources]\n"noise.per_meter" = "data sheet"', "unknown key sources.noise.per_meter"),
        (FOCAL + "cx = 1\ncy = 1\ndistortion = 3", "image.distortion = 3, wanted a list"),
        (FOCAL + "cx = 1\ncy = 1\ndistortion = [0.1]", "got 1 distortion coefficients"),
        (FOCAL + "cx = nan\ncy = 1", "image.cx = nan"),
    ],
)  # fmt: skip
def test_a_bad_file_is_refused_by_file_and_key(tmp_path: Path, text: str, message: str) -> None:
    assert message in refusal(tmp_path, text)


def test_a_file_that_cannot_be_read_is_refused(tmp_path: Path) -> None:
    (tmp_path / "folder.toml").mkdir()
    (tmp_path / "latin.toml").write_bytes(b'name = "\xe9"')
    for name in ("missing.toml", "folder.toml", "latin.toml", "nul\0.toml"):
        with pytest.raises(ConfigError, match="cannot be read as a camera file"):
            sensor(tmp_path / name)


def test_a_file_is_read_again_when_it_has_changed(tmp_path: Path) -> None:
    assert sensor(camera_file(tmp_path, OWN)).intrinsics.width == 320
    assert sensor(camera_file(tmp_path, OWN.replace("320", "160"))).intrinsics.width == 160


DOCS = Path(__file__).parents[2] / "docs" / "cameras.md"


@pytest.mark.parametrize("name", PRESETS)
def test_the_documentation_has_the_numbers_of_the_preset(name: str) -> None:
    camera, lens = sensor(name), _table(name)["image"]
    row = next(line for line in DOCS.read_text().splitlines() if line.startswith(f"| `{name}` "))
    cells = [cell.strip() for cell in row.strip("|").split("|")]
    assert cells[1:6] == [
        f"{lens['width']} x {lens['height']}",
        f"{lens['horizontal_deg']:g} x {lens['vertical_deg']:g}",
        f"{camera.range_min:g} to {camera.range_max:g}",
        f"{1e3 * camera.range_sigma(np.ones(1), np.ones(1))[0]:.1f}",
        f"{100 * camera.scale_sd:g} % + {1e3 * camera.offset_sd:g} mm",
    ]


def test_the_example_in_the_documentation_is_a_camera(tmp_path: Path) -> None:
    examples = re.findall(r"```toml\n(.*?)```", DOCS.read_text(), flags=re.DOTALL)
    assert len(examples) == 2
    for text in examples:
        assert sensor(camera_file(tmp_path, text)).name
