"""The table of planners for objects of any shape from runs that are made up, and objects from seeds."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from viewgain.errors import ConfigError, DataError, MeshError
from viewgain.evaluation import (
    Choice,
    ShapeRun,
    ShapeSettings,
    check_shape_policies,
    shape_case,
    shape_markdown,
    shape_table,
)
from viewgain.parcels import upright_box

SETTINGS = ShapeSettings(captures=2)
POLICIES = ("wise", "random", "constant", "oracle")
HELD_OUT = ("bed", "bench", "bookshelf", "bus", "drill", "guitar", "motorbike", "skateboard")


def run_of(number: int, *, chosen: int) -> ShapeRun:
    """Return an object seen from position 0: the hull is best from 1, the box from 2; from 3 there is no box at all."""
    errors = np.full((2, 4, 4), np.nan)
    errors[0, 1:] = np.array([-0.1, -0.2, -0.6])[:, None]
    errors[1, 1:3] = np.array([0.3, 0.0])[:, None]
    return ShapeRun(
        number=number, category="bus", reachable=np.array([False, True, True, True]), present=0,
        first=np.array([-0.5, np.nan]), errors=errors, choices={"wise": Choice(chosen, number > 0)}, milliseconds={"wise": 5.0},
    )  # fmt: skip


def test_the_gap_is_that_from_a_guess_to_the_oracle() -> None:
    table = shape_table([run_of(0, chosen=1), run_of(1, chosen=2)], SETTINGS, POLICIES)
    rows = {row.name: row for row in table.rows}
    assert list(rows) == ["wise", "uniform guess", "constant position", "constant offset", "oracle"]
    guess, oracle = rows["uniform guess"], rows["oracle"]
    assert guess.error.mean == pytest.approx((0.3, 1.3 / 3))
    assert oracle.error.mean == pytest.approx((0.1, 0.0))
    assert rows["wise"].error.mean == pytest.approx((0.15, 0.15))
    closed = [row.closed for row in (guess, oracle, rows["wise"])]
    assert all(each is not None for each in closed)
    assert [each.mean for each in closed if each is not None] == [
        pytest.approx((0.0, 0.0)),
        pytest.approx((1.0, 1.0)),
        pytest.approx(((0.3 - 0.15) / (0.3 - 0.1), (1.3 / 3 - 0.15) / (1.3 / 3))),
    ]
    assert rows["wise"].best.mean == (0.5, 0.5)
    assert (rows["wise"].undecided, rows["wise"].milliseconds) == (1, 5.0)
    assert rows["constant offset"].error.mean == pytest.approx((0.1, 0.0))
    assert table.first.mean == pytest.approx((0.5, 1.0))  # a miss costs all of the volume
    assert table.bias.mean == pytest.approx((-0.3, (0.3 + 0.0 - 1.0) / 3))
    assert (table.reachable, table.counted, table.ceiling.mean) == (3.0, (1.0, 1.0), (1.0, 1.0))
    assert "| wise | 15.00 (10.00 to 20.00) | 75 (50 to 100) | 50.0 (0.0 to 100.0) |" in shape_markdown(table)


def test_without_a_gap_none_is_closed_and_the_table_is_plain_json() -> None:
    runs = [replace(run_of(number, chosen=1), errors=np.full((2, 4, 4), 0.25)) for number in range(2)]
    table = shape_table(runs, SETTINGS, POLICIES)
    assert all(row.closed is None for row in table.rows)
    assert "| oracle | 25.00 (25.00 to 25.00) |  | 100.0 (100.0 to 100.0) |" in shape_markdown(table)
    assert table.to_dict()["volumes"] == ["hull", "standing box"]
    with pytest.raises(DataError, match="2 or more"):
        shape_table(runs[:1], SETTINGS, POLICIES)


def test_an_object_depends_on_seed_and_number_alone() -> None:
    one, other = shape_case(SETTINGS, 3), shape_case(replace(SETTINGS, captures=5), 3)
    assert np.array_equal(one.scans.mesh.vertices, other.scans.mesh.vertices)
    assert (one.present, one.scans.seed) == (other.present, other.scans.seed)
    assert not np.array_equal(one.scans.mesh.bounds, shape_case(replace(SETTINGS, seed=1), 3).scans.mesh.bounds)


def test_objects_are_of_kinds_that_no_network_trained_on_and_stand_on_the_floor() -> None:
    assert SETTINGS.kinds() == HELD_OUT
    cases = [shape_case(replace(SETTINGS, size=(0.3, 0.5)), number) for number in range(10)]
    assert [case.category for case in cases] == [*HELD_OUT, *HELD_OUT[:2]]
    for case in cases:
        mesh = case.scans.mesh
        assert mesh.bounds[0, 2] == pytest.approx(0.0, abs=1e-12)
        assert 0.15 < np.linalg.norm(upright_box(mesh.vertices).extents) < 0.75  # drawn along the axes before it was turned
        assert case.reachable.sum() >= 2
        assert not case.reachable[case.present]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"seed": -1}, "seed -1"),
        ({"captures": 1}, "1 captures"),
        ({"size": (0.5, 0.2)}, "sizes"),
        ({"size": (0.1, np.nan)}, "sizes"),
        ({"distance": np.inf}, "distance inf"),
        ({"elevation_deg": np.nan}, "elevation nan"),
        ({"categories": ("bus", "ghost")}, "got ghost, wanted some of"),
        ({"rig": "nowhere"}, "rig 'nowhere'"),
        ({"camera": "eye"}, "camera 'eye'"),
    ],
)
def test_settings_that_make_no_sense_are_refused(change: dict[str, object], words: str) -> None:
    with pytest.raises(ConfigError, match=words):
        ShapeSettings(**change)  # type: ignore[arg-type]


def test_meshes_that_are_not_there_are_refused(tmp_path: Path) -> None:
    with pytest.raises(MeshError):
        ShapeSettings(meshes=tmp_path / "nowhere")
    with pytest.raises(ConfigError, match="two positions of rig ring8"):
        shape_case(replace(SETTINGS, size=(4.0, 4.0)), 0)


def test_unknown_policies_are_refused() -> None:
    check_shape_policies(("columns", "kriegel", "auto", "network:some.onnx", "random"))
    for name in ("best", "network:", "columns:some.onnx"):
        with pytest.raises(ConfigError, match=f"'{name}' is not known; choose from columns, "):
            check_shape_policies((name,))
    for names in ((), ("columns", "columns")):
        with pytest.raises(ConfigError, match="each once"):
            check_shape_policies(names)
