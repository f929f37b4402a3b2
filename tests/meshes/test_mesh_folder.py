"""Folders of meshes in every layout, on small trees; what is chosen and divided is chosen by category."""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from tests.meshes import files
from viewgain.errors import ConfigError, MeshError
from viewgain.meshes import MeshFolder

PC_NBV = {
    "02691156": "airplane",
    "02933112": "cabinet",
    "02958343": "car",
    "03001627": "chair",
    "03636649": "lamp",
    "04256520": "sofa",
    "04379243": "table",
    "04530566": "vessel",
    "02924116": "bus",
    "02818832": "bed",
    "02871439": "bookshelf",
    "02828884": "bench",
    "03467517": "guitar",
    "03790512": "motorbike",
    "04225987": "skateboard",
    "03948459": "pistol",
}


def plain(root: Path) -> Path:
    files.put(root, "chair/b.ply", files.ply())
    files.put(root, "chair/a.OBJ", files.obj())
    files.put(root, "car/sedan.off", files.off())
    files.put(root, "lamp/c.stl", files.stl())
    files.put(root, "lamp/d.glb", files.glb())
    for ignored in ("index.csv", "LICENSES/by.txt", "chair/notes.txt", "chair/.hidden.ply", ".git/e.ply", "lamp/deep/f.ply"):
        files.put(root, ignored, "nothing of interest")
    return root


def shapenet1(root: Path) -> Path:
    for synset, model in (("02691156", "b"), ("02691156", "a"), ("04530566", "c"), ("99999999", "d")):
        files.put(root, f"{synset}/{model}/model.obj", files.obj())
        files.put(root, f"{synset}/{model}/model.mtl", "newmtl gold")
        files.put(root, f"{synset}/{model}/images/texture.jpg", "")
    files.put(root, "02691156/broken/readme.txt", "a model without its mesh")
    return root


def shapenet2(root: Path) -> Path:
    for synset, model in (("02691156", "b"), ("02691156", "a"), ("04530566", "c")):
        files.put(root, f"{synset}/{model}/models/model_normalized.obj", files.obj())
        files.put(root, f"{synset}/{model}/models/model_normalized.json", "{}")
    return root


def modelnet(root: Path) -> Path:
    for path in ("bathtub/train/bathtub_0002", "bathtub/train/bathtub_0001", "bathtub/test/bathtub_0107", "bed/test/bed_0516"):
        files.put(root, f"{path}.off", files.off("OFF"))
    files.put(root, "README.txt", "")
    files.put(root, "bathtub/train/._bathtub_0001.off", "")
    return root


def names(folder: MeshFolder) -> list[str]:
    return [f"{entry.category}/{entry.name}" for entry in folder]


@pytest.mark.parametrize("layout", ["auto", "named"])
@pytest.mark.parametrize(
    ("make", "expected", "listed"),
    [
        (plain, "folder", ["car/sedan", "chair/a", "chair/b", "lamp/c", "lamp/d"]),
        (shapenet1, "shapenet1", ["99999999/d", "airplane/a", "airplane/b", "vessel/c"]),
        (shapenet2, "shapenet2", ["airplane/a", "airplane/b", "vessel/c"]),
        (modelnet, "modelnet", ["bathtub/bathtub_0001", "bathtub/bathtub_0002", "bathtub/bathtub_0107", "bed/bed_0516"]),
    ],
)
def test_layouts(tmp_path: Path, make: Callable[[Path], Path], expected: str, listed: list[str], layout: str) -> None:
    folder = MeshFolder.open(str(make(tmp_path)), layout="auto" if layout == "auto" else expected)
    assert folder.layout == expected
    assert names(folder) == listed
    assert len(folder) == len(listed)
    mesh = folder[0].load()
    assert mesh.name == listed[0]
    assert len(mesh.faces) == 6


def test_modelnet_keeps_its_own_parts(tmp_path: Path) -> None:
    folder = MeshFolder.open(modelnet(tmp_path))
    assert names(folder.part("train")) == ["bathtub/bathtub_0001", "bathtub/bathtub_0002"]
    assert names(folder.part("test")) == ["bathtub/bathtub_0107", "bed/bed_0516"]
    with pytest.raises(ConfigError, match=r"'val', and .* has test and train"):
        folder.part("val")


def test_other_layouts_have_no_parts(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="no parts"):
        MeshFolder.open(plain(tmp_path)).part("train")


@pytest.mark.parametrize(("synset", "name"), PC_NBV.items())
def test_the_classes_of_pc_nbv_have_names(tmp_path: Path, synset: str, name: str) -> None:
    files.put(tmp_path, f"{synset}/a/model.obj", files.obj())
    assert MeshFolder.open(tmp_path).categories == (name,)


def test_taxonomy_names_what_it_knows(tmp_path: Path) -> None:
    taxonomy = [{"synsetId": "02691156", "name": "plane,aeroplane"}, {"synsetId": "99999999", "name": "thing", "children": []}]
    files.put(tmp_path, "taxonomy.json", json.dumps(taxonomy))
    assert MeshFolder.open(shapenet1(tmp_path)).categories == ("plane", "thing", "vessel")


@pytest.mark.parametrize("content", [b"", b"{", b"[1]", b"[{}]", b'{"a": 1}', b"7", b"\xff\xfe", b"[" * 100_000])
def test_a_bad_taxonomy(tmp_path: Path, content: bytes) -> None:
    files.put(tmp_path, "taxonomy.json", content)
    with pytest.raises(ConfigError) as caught:
        MeshFolder.open(shapenet1(tmp_path))
    assert str(tmp_path / "taxonomy.json") in str(caught.value)
    assert str(caught.value).isprintable()


def test_a_taxonomy_matters_to_shapenet_only(tmp_path: Path) -> None:
    files.put(tmp_path, "taxonomy.json", "{")
    assert len(MeshFolder.open(plain(tmp_path))) == 5


def test_listing_reads_no_mesh(tmp_path: Path) -> None:
    files.put(tmp_path, "chair/a.ply", "not a mesh")
    entry = MeshFolder.open(tmp_path)[0]
    with pytest.raises(MeshError, match=r"a\.ply: is not a PLY"):
        entry.load()


def test_loading_obeys_the_limit(tmp_path: Path) -> None:
    with pytest.raises(MeshError, match="over the limit of 5"):
        MeshFolder.open(plain(tmp_path))[0].load(max_faces=5)


def test_two_layouts_at_once_must_be_told_apart(tmp_path: Path) -> None:
    shapenet2(modelnet(plain(tmp_path)))
    with pytest.raises(ConfigError) as caught:
        MeshFolder.open(tmp_path)
    message = str(caught.value)
    for part in (str(tmp_path), "5 as folder (<category>/<name>.ext)", "4 as modelnet", "3 as shapenet2", "layout="):
        assert part in message
    assert MeshFolder.open(tmp_path, layout="modelnet").categories == ("bathtub", "bed")


@pytest.mark.parametrize("layout", ["auto", "folder", "shapenet1", "shapenet2", "modelnet"])
def test_a_folder_without_meshes(tmp_path: Path, layout: str) -> None:
    files.put(tmp_path, "meshes_lie_too_high.ply", files.ply())
    files.put(tmp_path, "a/b/c/d/e.ply", files.ply())
    with pytest.raises(MeshError) as caught:
        MeshFolder.open(tmp_path, layout=layout)
    message = str(caught.value)
    patterns = {
        "folder": "<category>/<name>.ext",
        "shapenet1": "/model.obj",
        "shapenet2": "model_normalized.obj",
        "modelnet": "train|test",
    }
    for name, pattern in patterns.items():
        assert (pattern in message) == (layout in ("auto", name))
    assert str(tmp_path) in message


def test_no_such_folder_or_layout(tmp_path: Path) -> None:
    with pytest.raises(MeshError, match="no such folder"):
        MeshFolder.open(tmp_path / "nowhere")
    with pytest.raises(MeshError, match="is not a folder"):
        MeshFolder.open(files.put(tmp_path, "a.ply", files.ply()))
    with pytest.raises(ConfigError, match="got 'shapenet', wanted one of auto, folder, shapenet1, shapenet2, modelnet"):
        MeshFolder.open(tmp_path, layout="shapenet")


def test_a_folder_that_may_not_be_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    root, real = plain(tmp_path), Path.iterdir

    def denied(path: Path) -> object:
        if path.name == "chair":
            raise PermissionError(13, "Permission denied", str(path))
        return real(path)

    monkeypatch.setattr(Path, "iterdir", denied)  # as root, who runs the tests in a container, may read everything
    with pytest.raises(MeshError, match="chair: cannot be read"):
        MeshFolder.open(root)


def test_links_in_a_circle_and_second_names_change_nothing(tmp_path: Path) -> None:
    expected = names(MeshFolder.open(plain(tmp_path)))
    (tmp_path / "aaa").symlink_to(tmp_path)
    (tmp_path / "armchair").symlink_to(tmp_path / "chair")
    (tmp_path / "itself").symlink_to(tmp_path / "itself")
    (tmp_path / "lamp" / "up").symlink_to(tmp_path)
    (tmp_path / "lamp" / "gone.ply").symlink_to(tmp_path / "nowhere.ply")
    (tmp_path / "lamp" / "self.ply").symlink_to(tmp_path / "lamp" / "self.ply")
    files.put(tmp_path, "at_the_top.ply", files.ply())
    assert names(MeshFolder.open(tmp_path)) == expected


def test_a_data_set_made_of_links_is_followed(tmp_path: Path) -> None:
    plain(tmp_path / "store")
    (tmp_path / "set").mkdir()
    (tmp_path / "set" / "seat").symlink_to(tmp_path / "store" / "chair")
    assert names(MeshFolder.open(tmp_path / "set")) == ["seat/a", "seat/b"]


def test_the_order_does_not_come_from_the_disk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    expected = names(MeshFolder.open(plain(tmp_path)))
    real = Path.iterdir
    monkeypatch.setattr(Path, "iterdir", lambda path: iter(sorted(real(path), reverse=True)))
    assert names(MeshFolder.open(tmp_path)) == expected


def test_only_and_without(tmp_path: Path) -> None:
    folder = MeshFolder.open(plain(tmp_path))
    assert folder.only(["lamp", "car"]).categories == folder.without(["chair"]).categories == ("car", "lamp")
    assert names(folder.only("car")) == ["car/sedan"]
    for choose in (folder.only, folder.without):
        with pytest.raises(ConfigError, match="sofa not among the 3: car, chair, lamp"):
            choose(["sofa", "car"])


def test_split_by_named_categories(tmp_path: Path) -> None:
    folder = MeshFolder.open(plain(tmp_path))
    parts = folder.split(train=["chair"], test=["lamp"])
    assert list(parts) == ["train", "test"]
    assert names(parts["train"]) == ["chair/a", "chair/b"]
    assert names(parts["test"]) == ["lamp/c", "lamp/d"]
    with pytest.raises(ConfigError, match="chair is in more than one part"):
        folder.split(train=["chair", "car"], test=["lamp", "chair"])
    with pytest.raises(ConfigError, match="sofa not among"):
        folder.split(train=["sofa"])


def many(root: Path, count: int) -> MeshFolder:
    for number in range(count):
        files.put(root, f"c{number:02}/a.ply", "")
        files.put(root, f"c{number:02}/b.ply", "")
    return MeshFolder.open(root)


def test_random_split_by_category(tmp_path: Path) -> None:
    folder = many(tmp_path, 20)
    parts = folder.random_split(rng=np.random.default_rng(1), train=0.7, val=0.1, test=0.2)
    assert {name: len(part.categories) for name, part in parts.items()} == {"train": 14, "val": 2, "test": 4}
    assert sorted(names(parts["train"]) + names(parts["val"]) + names(parts["test"])) == names(folder)
    assert not set(parts["train"].categories) & set(parts["test"].categories)


def test_random_split_comes_from_its_generator(tmp_path: Path) -> None:
    folder = many(tmp_path, 20)

    def train(seed: int) -> list[str]:
        return names(folder.random_split(rng=np.random.default_rng(seed), train=0.5, test=0.5)["train"])

    assert train(1) == train(1)
    assert train(1) != train(2)


@pytest.mark.parametrize(
    "shares", [{}, {"train": 0.5}, {"train": 1.5, "test": -0.5}, {"train": float("nan")}, {"a": 0.99, "b": 0.01}]
)
def test_shares_that_make_no_sense(tmp_path: Path, shares: dict[str, float]) -> None:
    with pytest.raises(ConfigError, match="random_split"):
        many(tmp_path, 4).random_split(rng=np.random.default_rng(0), **shares)
