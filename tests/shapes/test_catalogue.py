"""Every category: 500 objects that are sound meshes of the promised sizes, all different, and in different structures."""

from dataclasses import dataclass
from functools import cache
from itertools import pairwise

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.shapes.parts import first_hits, is_closed, pieces, repeats
from viewgain.errors import ConfigError, ViewgainError
from viewgain.meshes import TriangleMesh
from viewgain.shapes import CATEGORIES, procedural, random_object

SEEDS = range(500)
categories = pytest.mark.parametrize("category", CATEGORIES)


@dataclass(frozen=True)
class Survey:
    """What 500 objects of a category are like; a row per object."""

    lows: NDArray[np.float64]
    highs: NDArray[np.float64]
    counts: NDArray[np.int64]
    """(500, 3) vertices, triangles, parts."""
    least_area: NDArray[np.float64]
    """Area of the smallest triangle at a diagonal of 1."""
    least_volume: NDArray[np.float64]
    """Signed volume of the smallest part at a diagonal of 1."""
    closed: NDArray[np.bool_]
    tidy: NDArray[np.bool_]
    """Finite, every vertex used, and no triangle twice in a part."""
    signatures: NDArray[np.float64]

    @property
    def extents(self) -> NDArray[np.float64]:
        return self.highs - self.lows


def made(category: str, seed: int) -> TriangleMesh:
    return procedural(category, rng=np.random.default_rng(seed))


@cache
def survey(category: str) -> Survey:
    """All that the tests ask, in one round; keeping the objects themselves would take a gigabyte."""
    columns = list(zip(*(_row(made(category, seed)) for seed in SEEDS), strict=True))
    return Survey(*(np.array(column) for column in columns))


def _row(mesh: TriangleMesh) -> tuple[object, ...]:
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    size = float(np.linalg.norm(high - low))
    parts = pieces(mesh.vertices, mesh.faces)
    tidy = bool(np.isfinite(mesh.vertices).all() and np.bincount(mesh.faces.ravel(), minlength=len(mesh.vertices)).all())
    triangles = (mesh.triangles - (low + high) / 2) / size
    tidy = tidy and not repeats(parts.label, triangles)
    counts = (len(mesh.vertices), len(mesh.faces), len(parts.volumes))
    areas = parts.areas / size**2
    shape = signature(triangles, areas, (high - low) / size)
    return low, high, counts, areas.min(), parts.volumes.min() / size**3, is_closed(mesh.faces), tidy, shape


def signature(triangles: NDArray[np.float64], areas: NDArray[np.float64], extents: NDArray[np.float64]) -> NDArray[np.float64]:
    """What an object looks like apart from its size and its triangulation, given at a diagonal of 1.

    Three extents, the area, where the area lies on average from the middle of the bounding box (three numbers, from index 4),
    and how it spreads about that place (six second moments).
    """
    centres, total = (triangles[:, 0] + triangles[:, 1] + triangles[:, 2]) / 3, areas.sum()
    mean = areas @ centres / total
    apart = centres - mean
    spread = (apart * areas[:, None]).T @ apart / total
    return np.concatenate([extents, [total], mean, spread[np.triu_indices(3)]])


def test_there_are_enough_categories_for_eight_to_train_on_and_as_many_never_seen() -> None:
    assert len(CATEGORIES) >= 18
    assert {"chair", "table", "car", "airplane", "boat", "mug", "hammer", "guitar", "house", "plant"} <= set(CATEGORIES)


def test_an_unknown_category_is_refused_with_the_known_ones() -> None:
    with pytest.raises(ConfigError, match=r"'unicorn'.*airplane.*wrench") as caught:
        procedural("unicorn", rng=np.random.default_rng(0))
    assert isinstance(caught.value, ViewgainError)


def test_the_catalogue_cannot_be_changed() -> None:
    with pytest.raises(TypeError):
        CATEGORIES["unicorn"] = CATEGORIES["chair"]  # type: ignore[index]


@categories
def test_the_same_generator_gives_the_same_bits_and_the_next_draw_another_object(category: str) -> None:
    for seed in range(20):
        rng = np.random.default_rng(seed)
        mesh, following, again = procedural(category, rng=rng), procedural(category, rng=rng), made(category, seed)
        assert mesh.vertices.tobytes() == again.vertices.tobytes()
        assert mesh.faces.tobytes() == again.faces.tobytes()
        assert mesh.name == f"procedural/{category}"
        assert following.vertices.tobytes() != mesh.vertices.tobytes()


@categories
def test_objects_stand_on_the_floor_about_the_origin(category: str) -> None:
    seen = survey(category)
    size = np.linalg.norm(seen.extents, axis=1)
    # One subtraction of numbers of this size rounds by less than 1e-15 of it.
    assert (np.abs(seen.lows[:, 2]) <= 1e-12 * size).all()
    assert (np.abs(seen.lows[:, :2] + seen.highs[:, :2]) <= 1e-12 * size[:, None]).all()


@categories
def test_sizes_keep_to_the_documented_ranges_and_make_use_of_them(category: str) -> None:
    extents = survey(category).extents
    lowest, highest = np.array(CATEGORIES[category].lowest), np.array(CATEGORIES[category].highest)
    assert (extents > lowest).all()
    assert (extents < highest).all()
    assert (np.ptp(extents, axis=0) > 0.4 * (highest - lowest)).all()


@categories
def test_no_object_is_flat(category: str) -> None:
    """Wrenches and hammers are the thinnest: a few millimetres of a few decimetres."""
    extents = survey(category).extents
    share = 0.02 if category in ("wrench", "hammer") else 0.04
    assert (extents.min(axis=1) / extents.max(axis=1)).min() > share


@categories
def test_triangle_counts_stay_small(category: str) -> None:
    triangles = survey(category).counts[:, 1]
    assert triangles.min() >= 80
    assert triangles.max() <= 6500
    assert np.median(triangles) >= 400


@categories
def test_no_triangle_is_degenerate_or_there_twice_and_no_vertex_unused(category: str) -> None:
    assert survey(category).least_area.min() > 1e-10  # a square of 0.01 mm on an object of a metre; rounding alone gives 1e-16
    assert survey(category).tidy.all()


@categories
def test_every_part_is_closed_and_wound_outwards(category: str) -> None:
    assert survey(category).closed.all()
    assert survey(category).least_volume.min() > 0


@categories
def test_from_outside_only_outer_sides_are_seen(category: str) -> None:
    """Folds in a cap or walls that cross would show an inner side; a part of positive volume could still have them."""
    seen = inner = 0
    for seed in range(12):
        rng = np.random.default_rng(seed)
        ray = rng.normal(size=3)
        ray /= np.linalg.norm(ray)
        mesh = made(category, seed).normalised()
        aims = mesh.triangles[rng.choice(len(mesh.faces), 100)].mean(axis=1)
        hit = first_hits(mesh.triangles, aims - 2 * ray, ray)
        assert (hit >= 0).all()
        seen += len(hit)
        inner += int((mesh.face_normals[hit] @ ray > 1e-9).sum())
    assert inner <= 0.005 * seen  # thin walls may cross by a hair where a curved surface is split along the other diagonal


@categories
def test_all_objects_differ_in_shape_and_not_only_in_size(category: str) -> None:
    """No two of 500 agree in all of the signature to 1e-4 of the diagonal; most are farther than 0.5 % from all others."""
    signatures = survey(category).signatures
    apart = np.abs(signatures[:, None] - signatures[None]).max(axis=2)
    np.fill_diagonal(apart, np.inf)
    nearest = apart.min(axis=1)
    assert nearest.min() > 1e-4
    assert np.median(nearest) > 5e-3


@categories
def test_categories_vary_in_structure(category: str) -> None:
    """A structure is the number of parts with the numbers of vertices and triangles."""
    assert len(np.unique(survey(category).counts, axis=0)) >= 30


def test_categories_differ_from_each_other() -> None:
    """The nearest object, by the signature, is mostly of the same kind: an untrained guess among 25 is right 4 % of the time."""
    known = np.array([row for category in CATEGORIES for row in survey(category).signatures[:60]])
    asked = np.array([row for category in CATEGORIES for row in survey(category).signatures[60:70]])
    known_label, asked_label = np.repeat(np.arange(len(CATEGORIES)), 60), np.repeat(np.arange(len(CATEGORIES)), 10)
    nearest = np.abs(asked[:, None] - known[None]).sum(axis=2).argmin(axis=1)
    assert (known_label[nearest] == asked_label).mean() > 0.6


def test_random_objects_come_from_all_categories_and_repeat_with_the_seed() -> None:
    rng, twin = np.random.default_rng(1), np.random.default_rng(1)
    names = []
    for _ in range(200):
        mesh = random_object(rng=rng)
        names.append(mesh.name)
        assert mesh.vertices.tobytes() == random_object(rng=twin).vertices.tobytes()
    assert {name.removeprefix("procedural/") for name in names} == set(CATEGORIES)
    assert any(a != b for a, b in pairwise(names))


def test_objects_face_x_and_stand_upright() -> None:
    """By where the surface lies on average from the middle of the bounding box, in shares of the diagonal."""
    behind = survey("chair").signatures[:, 4]
    assert (behind < 0).mean() > 0.85  # the back is behind
    assert survey("bed").signatures[:, 4].mean() < 0  # so are headboard and pillows
    assert survey("table").signatures[:, 6].mean() > 0  # a top on legs
    assert survey("lamp").signatures[:, 6].mean() > 0  # a shade on a pole
    for category in ("car", "boat", "bus", "motorbike", "skateboard", "hammer", "wrench"):
        assert (survey(category).extents.argmax(axis=1) != 1).mean() > 0.5, category  # longer along their way than across
    for category in ("bench", "sofa", "bookshelf"):
        assert (survey(category).extents[:, 1] > survey(category).extents[:, 0]).mean() > 0.75, category  # wider than deep
