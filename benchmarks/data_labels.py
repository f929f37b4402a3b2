"""How fast coverage labels are made, beside the obvious ways, and how far the published rule is from plain union.

Everything runs on one thread; times are processor time, medians. Each twin is checked to give the same answer.
"""

import argparse
import importlib.util
import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from benchmarks._data import data_folder
from benchmarks._tables import bootstrap, markdown
from benchmarks.simulation import bumpy_sphere
from viewgain.gain import (
    PCNBV,
    Cover,
    CoverageLabels,
    cover,
    coverage_auc,
    greedy_labels,
    greedy_union,
    model_clouds,
    surface_samples,
)
from viewgain.meshes import MeshFolder, TriangleMesh

Array = NDArray[np.float64]

REPEATS = 5
MESHES = 20
SEED = 2026


@dataclass(frozen=True)
class Model:
    """A mesh with what its labels are made from."""

    name: str
    mesh: TriangleMesh
    clouds: list[Array]
    surface: Array


def run(options: argparse.Namespace) -> None:
    """Print the tables."""
    print("## Coverage labels, one thread\n")
    print(f"33 views of 640x480, {PCNBV.surface_points:,} surface samples, reach {PCNBV.reach:.5f}; processor time, median.\n")
    flat = bumpy_sphere(50)
    slim = TriangleMesh(flat.vertices * [1.0, 0.3, 0.2], flat.faces, "slim bumpy sphere")
    for mesh in (slim, flat):
        _speed(_model(mesh))
    meshes = _real_meshes(MESHES if options.scenes is None else options.scenes)
    if not meshes:
        print("No meshes beside the repository: the tables of real ones are left out.\n")
        return
    _end_to_end(meshes)
    _rules(meshes)


def _model(mesh: TriangleMesh) -> Model:
    still = mesh.normalised()
    surface = surface_samples(still, PCNBV.surface_points, rng=np.random.default_rng(SEED))
    return Model(mesh.name, mesh, model_clouds(still, PCNBV), surface)


def _real_meshes(count: int) -> list[TriangleMesh]:
    """Return meshes drawn from all that lie beside the repository, one per category at most."""
    folder = data_folder()
    if folder is None or not (folder / "meshes").is_dir():
        return []
    entries, rng = MeshFolder.open(folder / "meshes"), np.random.default_rng(SEED)
    categories = rng.permutation(np.array(entries.categories, dtype=object))[:count]
    chosen = [entries.only([str(category)]) for category in categories]
    return [part[int(rng.integers(len(part)))].load() for part in chosen]


def _speed(model: Model) -> None:
    points = sum(len(cloud) for cloud in model.clouds)
    print(f"### {model.name}: {len(model.mesh.faces):,} triangles, {points:,} points\n")
    covered = cover(model.clouds, model.surface, PCNBV.reach)
    rows = [*_cover_rows(model, covered), *_greedy_rows(covered), *_published_rows(model, covered), *_whole_rows(model)]
    print(markdown(("what", "time", "goal"), rows))
    print()


def _cover_rows(model: Model, covered: Cover) -> list[tuple[str, str, str]]:
    """Return the times of the covering masks of all clouds."""
    masks = np.stack([covered.mask(view) for view in range(covered.views)])

    def by_tree(bound: float) -> NDArray[np.bool_]:
        return np.stack(
            [cKDTree(cloud).query(model.surface, distance_upper_bound=bound)[0] < PCNBV.reach for cloud in model.clouds]
        )

    def by_cover(search: str) -> NDArray[np.bool_]:
        found = cover(model.clouds, model.surface, PCNBV.reach, search=search)  # type: ignore[arg-type]
        return np.stack([found.mask(view) for view in range(found.views)])

    rows = [
        ("masks and near pairs, numba (the package)", _checked(lambda: by_cover("numba"), masks), "250 ms"),
        ("the same, scipy's tree (the package without numba)", _checked(lambda: by_cover("scipy"), masks, 1), ""),
        ("masks, cKDTree with its bound, cloud by cloud", _checked(lambda: by_tree(PCNBV.reach), masks, 3), ""),
        ("masks, cKDTree without the bound", _checked(lambda: by_tree(np.inf), masks, 1), ""),
    ]
    if importlib.util.find_spec("torch") is not None:
        rows.append(_torch_row(model, masks))
    return rows


def _torch_row(model: Model, masks: NDArray[np.bool_]) -> tuple[str, str, str]:
    """Return the time of all distances, of the smallest cloud, scaled to all points."""
    import torch

    torch.set_num_threads(1)
    view = int(np.argmin([len(cloud) for cloud in model.clouds]))
    cloud, surface = torch.from_numpy(model.clouds[view]), torch.from_numpy(model.surface)

    def brute() -> NDArray[np.bool_]:
        blocks = [torch.cdist(part, cloud).amin(dim=1) < PCNBV.reach for part in surface.split(512)]
        return torch.cat(blocks).numpy()

    seconds = _median(brute, 1)
    differing = int(np.count_nonzero(brute() != masks[view]))
    scale = sum(len(each) for each in model.clouds) / len(cloud)
    what = f"masks, torch, every distance: one cloud, times {scale:.0f} ({differing} of {len(model.surface):,} masks differ)"
    return what, _milliseconds(seconds * scale), ""


def _greedy_rows(covered: Cover) -> list[tuple[str, str, str]]:
    """Return the times of ten greedy steps by union."""
    count = covered.surface_count
    plain = np.stack([covered.mask(view) for view in range(covered.views)])
    order = greedy_union(covered.masks, count, first=0, steps=10).order

    def boolean() -> NDArray[np.intp]:
        known, chosen = plain[0].copy(), []
        for _ in range(10):
            chosen.append(int(np.argmax((plain & ~known).sum(axis=1))))
            known |= plain[chosen[-1]]
        return np.array(chosen)

    packed = _checked(lambda: greedy_union(covered.masks, count, first=0, steps=10).order, order, 50)
    return [
        ("greedy by union, 10 steps, bit-packed (the package)", packed, "1 ms"),
        ("greedy by union, 10 steps, boolean masks", _checked(boolean, order, 10), ""),
    ]


def _published_rows(model: Model, covered: Cover) -> list[tuple[str, str, str]]:
    """Return the times of labels by the published rule."""
    ten, one = (lambda steps=steps: greedy_labels(covered, first=0, steps=steps) for steps in (10, 1))

    def first_step() -> Array:
        """Return the gains of the first step as the public scripts work them out, with trees for all distances."""
        known = cKDTree(model.clouds[0])
        gains = []
        for cloud in model.clouds:
            new = cloud[known.query(cloud, distance_upper_bound=PCNBV.reach)[0] >= PCNBV.reach]
            near = cKDTree(new).query(model.surface, distance_upper_bound=PCNBV.reach)[0] < PCNBV.reach if len(new) else [0]
            gains.append(np.mean(near))
        return np.array(gains)

    return [
        ("gains of all views by both rules, 10 steps (the package, after the masks)", _milliseconds(_median(ten)), ""),
        ("the same, 1 step", _milliseconds(_median(one)), ""),
        ("gains by the published rule, 1 step, cKDTree with its bound", _checked(first_step, one().gains_published[0], 1), ""),
    ]


def _whole_rows(model: Model) -> list[tuple[str, str, str]]:
    """Return the rate of whole models: drawn, sampled, covered, labelled."""
    clouds, whole = _median(lambda: model_clouds(model.mesh, PCNBV)), _median(lambda: label(model.mesh))
    return [
        ("clouds of 33 views, drawn", _milliseconds(clouds), ""),
        ("whole model: clouds, samples, masks, 10 steps by both rules", f"{1 / whole:.2f} models/s", "1 model/s"),
    ]


def label(mesh: TriangleMesh) -> CoverageLabels:
    """Return PC-NBV's labels of a mesh from its first view, from the triangles on."""
    model = _model(mesh)
    return greedy_labels(cover(model.clouds, model.surface, PCNBV.reach), first=0, steps=PCNBV.steps)


def _end_to_end(meshes: list[TriangleMesh]) -> None:
    seconds = [_median(lambda mesh=mesh: label(mesh), 1) for mesh in meshes]
    faces = [len(mesh.faces) for mesh in meshes]
    print(
        f"Whole models, {len(meshes)} real meshes of {min(faces):,} to {max(faces):,} triangles (median {np.median(faces):,.0f}):"
        f" {len(meshes) / sum(seconds):.2f} models/s; the slowest {max(seconds):.2f} s, the fastest {min(seconds):.2f} s.\n"
    )


@dataclass(frozen=True)
class Gap:
    """How the two rules differ on one mesh."""

    coverage: tuple[Array, Array]
    """(11,) by the published rule and by union, along the published rule's own sequence, mean over starts."""
    union_greedy: Array
    """(11,) by union along union's own sequence, mean over starts."""
    same_choice: float
    """Share of starts whose first choice is the same by both rules."""
    spread: float
    """Largest difference between a view's two gains at the first step, mean over starts."""
    correlation: float
    """Between the two rules' gains at the first step, mean over starts."""


def _rules(meshes: list[TriangleMesh]) -> None:
    """Print how far the published rule is from union."""
    gaps = [_gap(_model(mesh)) for mesh in meshes]
    published, union = (np.stack([gap.coverage[k] for gap in gaps]) for k in (0, 1))
    own = np.stack([gap.union_greedy for gap in gaps])
    print(f"### The published rule beside union: {len(meshes)} real meshes, every view of 33 as the first\n")
    print("Mean coverage. Published: gains added up, along its own greedy sequence; union: the same views, counted once.\n")
    columns = (0, 1, 2, 3, 5, 9)
    rows = [
        (
            name,
            *(f"{100 * table[:, k].mean():.1f} %" for k in columns),
            f"{np.mean([coverage_auc(row[:10]) for row in table]):.4f}",
        )
        for name, table in (
            ("published", published),
            ("the same views by union", union),
            ("union's own sequence by union", own),
        )
    ]
    print(markdown(("coverage", *(f"{k + 1} views" for k in columns), "AUC of 10"), rows))
    over = 100 * (published - union)[:, 9]
    low, high = bootstrap(over)
    print(f"\nAfter ten views the published figure is {over.mean():.1f} points more ({low:.1f} to {high:.1f}), per mesh", end=" ")
    print(f"{over.min():.1f} to {over.max():.1f}; it is over 100 % on {np.sum(published[:, 9] > 1)} of {len(meshes)} meshes.")
    same, spread, correlation = (
        np.array([getattr(gap, name) for gap in gaps]) for name in ("same_choice", "spread", "correlation")
    )
    print(f"First step: the same view is best in {100 * same.mean():.0f} % of starts (per mesh {100 * same.min():.0f}", end=" ")
    print(
        f"to {100 * same.max():.0f}); a view's two gains differ by at most {100 * spread.mean():.1f} points (mean over starts),",
        end=" ",
    )
    print(f"and correlate by {correlation.mean():.3f} (per mesh from {correlation.min():.3f}).\n")


def _gap(model: Model) -> Gap:
    covered = cover(model.clouds, model.surface, PCNBV.reach)
    starts = range(covered.views)
    labels = [greedy_labels(covered, first=first, steps=PCNBV.steps) for first in starts]
    union = [greedy_union(covered.masks, covered.surface_count, first=first, steps=PCNBV.steps) for first in starts]
    first = [(each.gains_published[0], each.gains_union[0]) for each in labels]
    return Gap(
        (
            np.mean([each.coverage_published for each in labels], axis=0),
            np.mean([each.coverage_union for each in labels], axis=0),
        ),
        np.mean([each.coverage for each in union], axis=0),
        float(np.mean([a.order[0] == b.order[0] for a, b in zip(labels, union, strict=True)])),
        float(np.mean([np.abs(a - b).max() for a, b in first])),
        float(np.mean([np.corrcoef(a, b)[0, 1] for a, b in first])),
    )


def _checked(work: Callable[[], NDArray[np.generic]], wanted: NDArray[np.generic], repeats: int = REPEATS) -> str:
    """Return the time of some work, and say so if its answer is not the wanted one."""
    same = np.array_equal(work(), wanted)
    return _milliseconds(_median(work, repeats)) + ("" if same else " (ANSWER DIFFERS)")


def _median(work: Callable[[], object], repeats: int = REPEATS) -> float:
    """Return the median processor time, seconds; the first of several runs, which may compile, is left out."""
    if repeats > 1:
        work()
    seconds = []
    for _ in range(repeats):
        start = time.process_time()
        work()
        seconds.append(time.process_time() - start)
    return float(np.median(seconds))


def _milliseconds(seconds: float) -> str:
    return f"{1e3 * seconds:,.0f} ms" if seconds >= 0.01 else f"{1e3 * seconds:.2f} ms"
