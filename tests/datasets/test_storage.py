"""What is written is read: files of arrays, samples as columns, and every damage a kind refusal."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from viewgain.datasets import Dataset, Sample
from viewgain.datasets._columns import Tables, packed, unpacked
from viewgain.datasets._tensors import encoded, intact, opened
from viewgain.errors import ConfigError, DataError

TABLES = Tables(categories=("box", "mug"), cameras=("a", "b"), splits=("one", "two"))
KINDS = ["<f4", "<f2", "<i8", "<i4", "<i2", "<u4", "<u2", "|u1", "|b1"]


def random_sample(rng: np.random.Generator, points: int, views: int) -> Sample:
    return Sample(
        points=rng.normal(0, 1.5, (points, 3)),
        frame="camera",
        view=int(rng.integers(views)),
        state=rng.random(views) < 0.5,
        candidates=rng.normal(size=(views, 4, 4)),
        reachable=rng.random(views) < 0.5,
        camera=str(rng.choice(TABLES.cameras)),
        noise=float(rng.random()),
        object=int(rng.integers(1000)),
        category=str(rng.choice(TABLES.categories)),
        dims=rng.random(3),
        object_to_camera=rng.normal(size=(4, 4)),
        coverage=float(rng.random()),
        step=int(rng.integers(10)),
        capture=int(rng.integers(1000)),
        seed=(1, 2, 3, int(rng.integers(2**32))),
        splits={name: str(rng.choice(TABLES.parts)) for name in TABLES.splits},
        targets={"gain": rng.random(views), "other": rng.random(views)},
    )


@given(
    st.integers(0, 2**32 - 1),
    st.lists(st.tuples(st.integers(0, 40), st.integers(1, 9)), max_size=5),
    st.sampled_from(["quantised", "float16", "float32"]),
)
def test_samples_come_back_from_a_file(tmp_path_factory: pytest.TempPathFactory, seed: int, sizes: list, storage: str) -> None:
    rng = np.random.default_rng(seed)
    samples = [random_sample(rng, *size) for size in sizes]
    path = tmp_path_factory.mktemp("file") / "shard.safetensors"
    path.write_bytes(encoded(packed(samples, TABLES, storage), {"plan": "x"}))  # type: ignore[arg-type]
    assert intact(path)
    columns, metadata = opened(path)
    assert metadata["plan"] == "x"
    assert len(columns["view"]) == len(samples)
    for row, sample in enumerate(samples):
        back = unpacked(columns, row, TABLES, "camera", ("gain", "other"))
        extent = float(np.ptp(sample.points, axis=0).max()) if len(sample.points) else 0.0
        step = {"quantised": extent / 65535, "float16": 2**-8, "float32": 0.0}[storage]
        np.testing.assert_allclose(back.points, sample.points, atol=0.51 * step + 1e-6)
        assert back.points.dtype == np.float32
        for name in ("candidates", "dims", "object_to_camera"):
            np.testing.assert_array_equal(getattr(back, name), getattr(sample, name).astype(np.float32))
        for name in ("state", "reachable"):
            np.testing.assert_array_equal(getattr(back, name), getattr(sample, name))
        for name in ("view", "camera", "object", "category", "step", "capture", "seed", "splits", "frame"):
            assert getattr(back, name) == getattr(sample, name)
        np.testing.assert_array_equal(back.targets["gain"], sample.targets["gain"].astype(np.float32))


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_of_number_is_aligned_and_comes_back(kind: str, tmp_path: Path) -> None:
    values = np.arange(15).reshape(5, 3).astype(kind)
    path = tmp_path / "a"
    path.write_bytes(encoded({"odd": np.ones(3, np.uint8), "values": values, "none": np.zeros((0, 3), kind)}, {}))
    columns, _ = opened(path)
    np.testing.assert_array_equal(columns["values"], values)
    assert columns["values"].dtype == np.dtype(kind)
    assert columns["values"].flags.aligned
    assert not columns["values"].flags.writeable
    assert columns["none"].shape == (0, 3)


def test_the_file_is_what_others_call_safetensors(tmp_path: Path, boxes: Dataset) -> None:
    numpy = pytest.importorskip("safetensors.numpy", reason="safetensors is not installed; the layout is checked against it")
    path = boxes.folder / "shards" / boxes.manifest.shards[0].name
    columns, _ = opened(path)
    theirs = numpy.load_file(path)
    assert set(theirs) == set(columns)
    for name, column in columns.items():
        np.testing.assert_array_equal(theirs[name], column)


@given(st.data())
def test_a_damaged_file_is_refused_or_found_out(tmp_path_factory: pytest.TempPathFactory, data: st.DataObject) -> None:
    content = bytearray(encoded({"a": np.arange(40, dtype="<i4"), "b": np.ones((3, 3), "<f4")}, {"plan": "x"}))
    whole = bytes(content)
    cut = data.draw(st.one_of(st.none(), st.integers(0, len(content) - 1)))
    if cut is None:
        place = data.draw(st.integers(0, len(content) - 1))
        content[place] ^= data.draw(st.integers(1, 255))
    else:
        del content[cut:]
    path = tmp_path_factory.mktemp("file") / "shard"
    path.write_bytes(content)
    body = whole.index(b"}}") + 2
    try:
        opened(path)
    except DataError:
        assert not intact(path)
        return
    if cut is not None or place >= body + 8:
        assert not intact(path)


@pytest.mark.parametrize("content", [b"", b"1234567", b"\xff" * 8, b"\x02\0\0\0\0\0\0\0{}", b"\x02\0\0\0\0\0\0\0[]rest"])
def test_other_files_are_no_shards(content: bytes, tmp_path: Path) -> None:
    path = tmp_path / "a"
    path.write_bytes(content)
    if content.endswith(b"{}"):
        assert opened(path) == ({}, {})
    else:
        with pytest.raises(DataError):
            opened(path)
    assert not intact(path)


def test_samples_are_found_by_number_from_both_ends(boxes: Dataset) -> None:
    assert len(boxes) == 24
    keys = [sample.seed for sample in boxes]
    assert len(set(keys)) == 24
    for index in (0, 1, 7, 23):
        assert boxes[index].seed == boxes[index - 24].seed == keys[index]
    for index in (24, -25):
        with pytest.raises(IndexError):
            boxes[index]


def test_unknown_columns_and_divisions_are_refused(boxes: Dataset) -> None:
    for name in ("nothing", "points", "candidates"):
        with pytest.raises(ConfigError, match="row per sample"):
            boxes.column(name)
    with pytest.raises(ConfigError, match="same_box"):
        boxes.part("by_moon", "train")
    with pytest.raises(ConfigError, match="no masks"):
        boxes.masks(0)


def test_the_manifest_says_what_the_shards_hold(coverage: Dataset) -> None:
    manifest = coverage.manifest
    assert manifest.samples == len(coverage) == 20
    assert manifest.points == sum(len(sample.points) for sample in coverage)
    assert manifest.bytes == sum(path.stat().st_size for path in (coverage.folder / "shards").iterdir())
    assert manifest.frame == coverage[0].frame == "object"
    assert manifest.targets == ("gain_published", "gain_union")
    assert manifest.recipe["coverage"]["protocol"] == "pcnbv"
    assert [manifest.objects[sample.object].split("/")[0] for sample in coverage] == [sample.category for sample in coverage]
