"""The scorer: laws of what it does to a cloud, refusals, and files that are not what they should be."""

import contextlib
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.oracles.networks_on_disk import card_of, exported, small_settings
from viewgain.errors import ConfigError, ModelError, ScanError
from viewgain.geometry import rotation_from_rotvec
from viewgain.inference import (
    Bounds,
    PoseScorer,
    Scorer,
    around_middle,
    bounds_of,
    find_model,
    model_name,
    normalised,
    shipped_models,
    thinned,
)

Array = np.ndarray


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Networks of fresh weights by name."""
    made = tmp_path_factory.mktemp("networks")
    exported(made / "object.onnx", small_settings("compact"))
    exported(made / "seen.onnx", small_settings("compact"), normalisation="seen_box", sampling="farthest")
    exported(made / "camera.onnx", small_settings("compact"), frame="camera")
    exported(made / "middle.onnx", small_settings("compact"), frame="camera", normalisation="metres", within=0.5)
    exported(made / "told.onnx", small_settings("compact_view"))
    exported(made / "sure.onnx", small_settings("compact", uncertainty="gaussian"))
    return made


def shell(number: int = 50, *, seed: int = 0) -> Array:
    """Points of a box of 0.4 x 0.3 x 0.2 about the origin, its corners among them."""
    rng = np.random.default_rng(seed)
    signs = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    points = np.concatenate((signs, rng.uniform(-1, 1, (number - 8, 3))))
    return points * np.array([0.2, 0.15, 0.1])


AHEAD = np.array([0.0, 0.0, 1.5])
BOX = Bounds(np.zeros(3), float(np.linalg.norm([0.4, 0.3, 0.2])))


@settings(max_examples=15)
@given(shift=st.tuples(*[st.floats(-3, 3)] * 3), scale=st.floats(0.01, 100.0))
def test_place_and_size_do_not_matter(folder: Path, shift: tuple[float, float, float], scale: float) -> None:
    points, move = shell(), np.array(shift)
    scorer = Scorer.load(folder / "object.onnx")
    wanted = scorer.scores(points, bounds=BOX)
    moved = scorer.scores(scale * (points + move), bounds=Bounds(scale * move, scale * BOX.diagonal))
    np.testing.assert_allclose(moved, wanted, rtol=0, atol=2e-5)
    seen = Scorer.load(folder / "seen.onnx")
    np.testing.assert_allclose(seen.scores(scale * (points + move)), seen.scores(points), rtol=0, atol=2e-5)


def test_normalised_points_are_taken_as_they_are(folder: Path) -> None:
    scorer, points = Scorer.load(folder / "object.onnx"), shell()
    ready = points / BOX.diagonal
    np.testing.assert_allclose(scorer.scores(ready), scorer.scores(points, bounds=BOX), rtol=0, atol=1e-6)
    with pytest.raises(ConfigError, match="normalised"):
        scorer.scores(5 * ready)


def test_in_the_camera_frame_the_box_is_moved_onto_the_axis(folder: Path) -> None:
    card = Scorer.load(folder / "camera.onnx").card
    ahead = normalised(shell() + AHEAD, card, Bounds(AHEAD, BOX.diagonal))
    np.testing.assert_allclose(ahead, shell() / BOX.diagonal + [0.0, 0.0, 1.0], atol=1e-12)
    turn = rotation_from_rotvec(np.array([0.2, -0.3, 0.0]))  # the camera pans and tilts: what it looks at moves with it
    centre = turn @ AHEAD
    aside = normalised((shell() + AHEAD) @ turn.T, card, Bounds(centre, BOX.diagonal))
    np.testing.assert_allclose(aside, ahead, atol=1e-9)


def test_of_a_whole_scan_only_what_lies_about_the_middle_counts(folder: Path) -> None:
    wide = shell() + AHEAD
    scorer = Scorer.load(folder / "middle.onnx")
    wanted = scorer.scores(wide)
    rng = np.random.default_rng(0)
    around = rng.uniform(-1, 1, (400, 3)) * [3.0, 3.0, 0.1] + [0.0, 0.0, 2.5]
    beyond = around[np.linalg.norm(around - AHEAD, axis=1) > 0.9]
    beyond = beyond[np.hypot(beyond[:, 0], beyond[:, 1]) > 0.5]  # not where the camera looks
    np.testing.assert_array_equal(scorer.scores(np.concatenate((wide, beyond))), wanted)
    assert np.abs(scorer.scores(np.concatenate((wide, [[0.3, 0.0, 1.5]]))) - wanted).max() > 1e-6


@settings(max_examples=30)
@given(number=st.integers(1, 60), seed=st.integers(0, 99), within=st.floats(1e-6, 2.0))
def test_what_lies_about_the_middle_is_all_that_is_near_one_of_the_points_ahead(number: int, seed: int, within: float) -> None:
    rng = np.random.default_rng(seed)
    points = rng.uniform(-1, 1, (number, 3)) + AHEAD
    kept = around_middle(points, within)
    assert len(kept) >= 1
    near = np.linalg.norm(points[:, None] - points[None], axis=-1) <= within
    chosen = (points[:, None] == kept[None]).all(-1).any(1)
    off_axis = np.arctan2(np.hypot(points[:, 0], points[:, 1]), points[:, 2])
    assert any(np.array_equal(chosen, near[row]) for row in np.argsort(off_axis)[:9])
    assert len(around_middle(points, 10.0)) == number


def test_one_point_that_flies_before_the_middle_is_not_what_the_camera_looks_at() -> None:
    wall = np.stack(np.meshgrid(np.linspace(-1, 1, 41), np.linspace(-1, 1, 41), [2.0]), axis=-1).reshape(-1, 3)
    flying = np.concatenate(([[0.0, 0.0, 0.4]], wall[np.hypot(wall[:, 0], wall[:, 1]) > 0.01]))
    kept = around_middle(flying, 0.5)
    assert np.all(kept[:, 2] == 2.0)
    assert np.hypot(kept[:, 0], kept[:, 1]).max() <= 0.5 + 0.1  # what counts as the middle is a neighbour on the wall
    assert len(kept) > 250
    assert len(around_middle(np.empty((0, 3)), 0.5)) == 0


@pytest.mark.parametrize("sampling", ["random", "farthest"])
def test_thinning_keeps_distinct_points_and_repeats_itself(sampling: str) -> None:
    points = np.concatenate((shell(200), shell(200)))
    kept, again = (thinned(points, 64, sampling, rng=np.random.default_rng(3)) for _ in range(2))
    assert np.array_equal(kept, again)
    assert len(np.unique(points[kept], axis=0)) == 64
    assert len(thinned(points[:30], 64, sampling, rng=np.random.default_rng(0))) == 30
    assert len(thinned(points, 512, sampling, rng=np.random.default_rng(0))) == 200


def test_the_farthest_points_are_those_that_a_loop_finds() -> None:
    points = shell(40, seed=5)
    kept = thinned(points, 12, "farthest", rng=np.random.default_rng(1))
    first = int(np.random.default_rng(1).integers(40))
    taken = [first]
    while len(taken) < 12:
        taken.append(max(range(40), key=lambda i: min(np.sum((points[i] - points[j]) ** 2) for j in taken)))
    assert sorted(taken) == kept.tolist()


def test_the_order_of_points_and_repeated_ones_change_nothing(folder: Path) -> None:
    scorer, points, rng = Scorer.load(folder / "object.onnx"), shell(), np.random.default_rng(0)
    wanted = scorer.scores(points, bounds=BOX)
    np.testing.assert_allclose(scorer.scores(rng.permutation(points), bounds=BOX), wanted, rtol=0, atol=1e-5)
    np.testing.assert_allclose(scorer.scores(np.tile(points, (3, 1)), bounds=BOX), wanted, rtol=0, atol=1e-5)


@pytest.mark.parametrize("number", [1, 2, 9, 64, 5000])
def test_any_number_of_points_is_scored(folder: Path, number: int) -> None:
    points = np.random.default_rng(0).uniform(-0.1, 0.1, (number, 3))
    assert np.all(np.isfinite(Scorer.load(folder / "object.onnx").scores(points)))
    assert np.all(np.isfinite(Scorer.load(folder / "seen.onnx").scores(points)))


def test_a_network_that_is_told_wants_to_be_told(folder: Path) -> None:
    told, blind, points = Scorer.load(folder / "told.onnx"), Scorer.load(folder / "object.onnx"), shell()
    state = np.arange(16) == 3
    assert told.scores(points, state, bounds=BOX).shape == (16,)
    assert np.abs(told.scores(points, state, bounds=BOX) - told.scores(points, ~state, bounds=BOX)).max() > 1e-6
    for act in (
        lambda: told.scores(points, bounds=BOX),
        lambda: told.scores(points, state[:5], bounds=BOX),
        lambda: blind.scores(points, state, bounds=BOX),
    ):
        with pytest.raises(ConfigError, match="view"):
            act()


def test_a_network_may_say_how_sure_it_is(folder: Path) -> None:
    assert Scorer.load(folder / "sure.onnx").assessed(shell(), bounds=BOX).sigma.min() > 0
    assert Scorer.load(folder / "object.onnx").assessed(shell(), bounds=BOX).sigma is None


def test_a_frame_or_rig_that_does_not_fit_is_refused_with_the_reason(folder: Path) -> None:
    scorer = Scorer.load(folder / "object.onnx")
    assert scorer.refusal() is None
    assert scorer.refusal(frame="object", rig="pcnbv16") is None
    assert "camera_to_world" in scorer.refusal(frame="camera")
    assert "pcnbv16" in scorer.refusal(rig="ring8")
    with pytest.raises(ConfigError, match="object frame"):
        scorer.scores(shell(), bounds=BOX, frame="camera")


def test_clouds_without_sense_are_refused(folder: Path) -> None:
    scorer = Scorer.load(folder / "object.onnx")
    for points in (np.zeros((0, 3)), np.zeros((4, 2)), np.zeros(3), np.full((4, 3), np.nan), np.full((4, 3), np.inf)):
        with pytest.raises(ScanError):
            scorer.scores(points, bounds=BOX)
    for bad in (lambda: Bounds(np.zeros(3), 0.0), lambda: Bounds(np.full(3, np.nan), 1.0), lambda: Bounds(np.zeros(2), 1.0)):
        with pytest.raises(ConfigError):
            bad()
    with pytest.raises(ScanError):
        bounds_of(np.zeros((0, 3)))


def test_files_that_are_no_network_of_ours_are_refused_in_one_line(folder: Path, tmp_path: Path) -> None:
    onnx = pytest.importorskip("onnx")
    whole = (folder / "object.onnx").read_bytes()
    model = onnx.load_model_from_string(whole)
    (tmp_path / "empty.onnx").write_bytes(b"")
    (tmp_path / "text.onnx").write_text("not a network at all\n" * 30)
    (tmp_path / "half.onnx").write_bytes(whole[: len(whole) // 2])
    (tmp_path / "short.onnx").write_bytes(whole[:-40])
    card = model.metadata_props[0].value
    for name, text in (
        ("foreign", None), ("no-json", "{"), ("list", "[]"), ("no-rig", card.replace('"rig"', '"gir"')),
        ("views", card.replace('"views": 16', '"views": 8')), ("type", card.replace('"views": 16', '"views": "16"')),
        ("frame", card.replace('"frame": "object"', '"frame": "moon"')), ("deep", "[" * 100_000),
    ):  # fmt: skip
        del model.metadata_props[:]
        if text is not None:
            onnx.helper.set_model_props(model, {"viewgain_card": text})
        onnx.save(model, tmp_path / f"{name}.onnx")
    files = sorted(tmp_path.glob("*.onnx"))
    assert len(files) == 12
    for path in [*files, tmp_path / "missing.onnx"]:
        with pytest.raises(ModelError) as caught:
            Scorer.load(path)
        assert path.name in str(caught.value)
        assert "\n" not in str(caught.value)


@settings(max_examples=40)
@given(place=st.integers(0, 10**9), byte=st.integers(0, 255))
def test_a_changed_byte_never_crashes(folder: Path, place: int, byte: int) -> None:
    """It may go unnoticed in a weight; what is found is a ModelError, never another exception."""
    content = bytearray((folder / "object.onnx").read_bytes())
    content[place % len(content)] = byte
    path = folder / "changed.onnx"
    path.write_bytes(content)
    with contextlib.suppress(ModelError, ConfigError):
        Scorer.load(path).scores(shell(), bounds=BOX)


def test_weights_that_are_no_numbers_are_found(folder: Path, tmp_path: Path) -> None:
    onnx = pytest.importorskip("onnx")
    model = onnx.load(folder / "object.onnx")
    for stored in model.graph.initializer:
        if stored.data_type == onnx.TensorProto.FLOAT16:
            values = np.full(tuple(stored.dims), np.nan, dtype=np.float16)
            stored.CopyFrom(onnx.numpy_helper.from_array(values, stored.name))
    onnx.save(model, tmp_path / "nan.onnx")
    with pytest.raises(ModelError, match="finite"):
        Scorer.load(tmp_path / "nan.onnx").scores(shell(), bounds=BOX)


def test_names_find_the_shipped_networks_or_say_which_there_are(tmp_path: Path) -> None:
    assert model_name("compact", "pcnbv16", "object") == "compact-pcnbv16-object"
    for name in shipped_models():
        assert (PoseScorer if name.startswith("pose_scores-") else Scorer).load(name).card.views > 0
    for name in ("no-such-network", "../weights/README", ""):
        with pytest.raises(ModelError, match="not shipped"):
            find_model(name)
    with pytest.raises(ModelError, match="no such file"):
        find_model(tmp_path / "x.onnx")


def test_threads_are_said_and_at_least_one(folder: Path) -> None:
    one, two = (Scorer.load(folder / "object.onnx", threads=n).scores(shell(), bounds=BOX) for n in (1, 2))
    np.testing.assert_allclose(one, two, rtol=0, atol=1e-5)
    with pytest.raises(ConfigError, match="threads"):
        Scorer.load(folder / "object.onnx", threads=0)


def test_scoring_needs_no_torch(folder: Path) -> None:
    code = (
        "import sys, numpy as np\nfrom viewgain.inference import Scorer\n"
        f"s = Scorer.load({str(folder / 'object.onnx')!r}).scores(np.eye(3) / 4)\n"
        "assert s.shape == (16,) and not {'torch', 'onnx'} & set(sys.modules), sorted(sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr


def test_a_card_that_contradicts_itself_is_refused() -> None:
    plain = small_settings("compact")
    for changes in (
        {"order": "rig"},
        {"views": 0},
        {"points": 0},
        {"name": ""},
        {"rig": ""},
        {"distance": 0.0},
        {"within": 0.5},
        {"normalisation": "metres", "within": -1.0},
    ):
        with pytest.raises(ModelError):
            card_of(plain, **changes)
