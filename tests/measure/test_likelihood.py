"""The likelihood at a box: its slope against differences of its value, its curvature, and that the truth is near the top."""

from dataclasses import replace

import numpy as np
import pytest

from tests.oracles.derivatives import along_steps
from tests.oracles.scenes import CAMERA, UNMIXED, WELL_SEEN, aligned_extents, scan_of
from viewgain.box import Box
from viewgain.geometry import inverse
from viewgain.measure import BoxEstimate, _fit, measure
from viewgain.measure._fit import COARSE, FINE, SHARP, polled, refine
from viewgain.measure._likelihood import Evaluation, evaluate
from viewgain.scenes import random_box, random_view

LEVELS = {"blurred": COARSE[1], "fine": FINE[0], "sharp": SHARP[0]}


@pytest.fixture(scope="module", params=range(4))
def case(request: pytest.FixtureRequest) -> tuple[BoxEstimate, Box]:
    """A measured box and the truth in the camera's frame."""
    rng = np.random.default_rng(request.param)
    box = random_box(rng, WELL_SEEN)
    view = random_view(rng, box, WELL_SEEN)
    return measure(scan_of(box, view=view, rng=rng, effects=UNMIXED), camera=CAMERA).boxes[0], box.in_frame(inverse(view))


def at(box: Box, found: BoxEstimate, level: str, pixels: np.ndarray | None = None) -> Evaluation:
    """The likelihood for a camera without bloom, and without the doubt about grazing faces: slopes leave both out on purpose."""
    view = found.views[0]
    camera = replace(view.sensor, footprint_px=0.0, grazing_start=np.deg2rad(89.0), grazing_end=np.deg2rad(89.5))
    return evaluate(box, view.pixels if pixels is None else view.pixels.take(pixels), camera, view.noise, LEVELS[level])


def sigma_step(found: BoxEstimate, rng: np.random.Generator, size: float) -> np.ndarray:
    """A step of ``size`` standard deviations in a random direction of the tangent space."""
    direction = rng.normal(size=9)
    return np.asarray(np.linalg.cholesky(found.covariance) @ (direction * size / np.linalg.norm(direction)))


def test_the_slope_sums_up_to_the_change_in_value(case: tuple[BoxEstimate, Box]) -> None:
    """Along a straight way of twelve sigma off the top the integral of the slope is the drop, over the pixels with a return.

    The slope leaves out how sigma and the chance of loss change with the box, and faces that change under a pixel. A sign or a
    factor that is wrong in one of faces, floor and edges shows as far more than the quarter allowed for that.
    """
    found, _ = case
    rng, returned = np.random.default_rng(0), np.flatnonzero(np.isfinite(found.views[0].pixels.ranges))
    for _ in range(3):
        step = sigma_step(found, rng, 12)
        share = np.linspace(0, 1, 31)
        along = [at(found.box.moved(step * part), found, "sharp", returned) for part in share]
        summed = np.trapezoid([evaluation.derivatives.gradient @ step for evaluation in along], share)
        dropped = along[-1].value - along[0].value
        assert dropped < -20
        np.testing.assert_allclose(summed, dropped, rtol=0.25)


@pytest.mark.parametrize("level", LEVELS)
@pytest.mark.parametrize("part", ["face", "floor", "edge"])
def test_the_slope_of_single_pixels_is_their_central_difference(case: tuple[BoxEstimate, Box], level: str, part: str) -> None:
    """Pixel by pixel, away from kinks (where two step sizes disagree); in units of sigma, a quarter of the typical slope."""
    found, _ = case
    rng = np.random.default_rng(1)
    box = found.box.moved(sigma_step(found, rng, 3))
    here = at(box, found, level)
    returned = np.isfinite(found.views[0].pixels.ranges)
    band = {"face": here.inside > 6, "floor": here.inside < -6, "edge": np.abs(here.inside) < 3}[part]
    scale = np.linalg.cholesky(found.covariance).T
    errors, slopes = [], []
    for pixel in rng.choice(np.flatnonzero(band & returned), 25, replace=False):
        own = np.array([pixel])
        fine, coarse = (
            along_steps(lambda moved, own=own: at(moved, found, level, own).value, box, step) for step in (3e-6, 1e-5)
        )
        if np.abs(fine - coarse).max() < 1e-3 * np.abs(coarse).max() + 1e-3:
            errors.append(scale @ (at(box, found, level, own).derivatives.gradient - fine))
            slopes.append(scale @ fine)
    assert len(errors) >= 12
    assert np.sqrt(np.mean(np.square(errors))) < 0.25 * np.sqrt(np.mean(np.square(slopes)))


@pytest.mark.parametrize("level", LEVELS)
def test_information_is_symmetric_and_nowhere_negative(case: tuple[BoxEstimate, Box], level: str) -> None:
    found, _ = case
    rng = np.random.default_rng(2)
    for size in (0, 3, 30):
        here = at(found.box.moved(sigma_step(found, rng, size)), found, level)
        np.testing.assert_allclose(
            here.derivatives.information,
            here.derivatives.information.T,
            rtol=1e-9,
            atol=1e-6 * np.abs(here.derivatives.information).max(),
        )
        values = np.linalg.eigvalsh(here.derivatives.information)
        assert values[0] > -1e-9 * values[-1]
        assert np.all(here.derivatives.edge_precision >= 0)


def test_information_is_about_the_curvature_of_the_value(case: tuple[BoxEstimate, Box]) -> None:
    """The drop at four sigma, both ways averaged, is eight units by the information; the data say so within a factor of two."""
    found, _ = case
    rng, here, ratios = np.random.default_rng(3), at(found.box, found, "sharp"), []
    root = np.linalg.cholesky(np.linalg.inv(here.derivatives.information))
    for _ in range(12):
        direction = rng.normal(size=9)
        step = root @ direction * 4 / np.linalg.norm(direction)
        values = [at(found.box.moved(side * step), found, "sharp").value for side in (-1, 1)]
        ratios.append((here.value - np.mean(values)) / 8)
    assert 0.5 < np.median(ratios) < 2


def test_twice_the_pixels_are_twice_the_evidence(case: tuple[BoxEstimate, Box]) -> None:
    found, _ = case
    everything = np.arange(len(found.views[0].pixels.ranges))
    once, twice = at(found.box, found, "fine"), at(found.box, found, "fine", np.concatenate([everything, everything]))
    np.testing.assert_allclose(twice.value, 2 * once.value, rtol=1e-9)
    np.testing.assert_allclose(
        twice.derivatives.gradient,
        2 * once.derivatives.gradient,
        rtol=1e-6,
        atol=1e-6 * np.abs(twice.derivatives.information).max() ** 0.5,
    )
    np.testing.assert_allclose(
        twice.derivatives.information,
        2 * once.derivatives.information,
        rtol=1e-9,
        atol=1e-6 * np.abs(once.derivatives.information).max(),
    )
    np.testing.assert_allclose(twice.systematic, 2 * once.systematic, rtol=1e-9, atol=1e-6 * np.abs(once.systematic).max())


def test_the_estimate_is_likelier_than_the_truth_and_the_truth_likelier_than_a_wrong_box(case: tuple[BoxEstimate, Box]) -> None:
    """The estimate maximises, so it beats the truth by a few units (nine parameters: half of chi-squared with 9); a box that is
    2 cm too long loses by far more."""
    found, truth = case
    own = Box(found.box.box_to_camera, aligned_extents(found.box, truth))
    best, true = at(found.box, found, "sharp").value, max(at(own, found, "sharp").value, at(truth, found, "sharp").value)
    assert best > true - 8  # the climb may end on a side peak, a fraction of sigma from the top
    assert best - true < 25
    for axis in range(3):
        step = np.zeros(9)
        step[6 + axis] = 0.02
        assert at(own.moved(step), found, "sharp").value < true - 10


def test_refining_from_a_bit_off_leads_back_to_the_estimate(case: tuple[BoxEstimate, Box]) -> None:
    """From ten sigma off in a random direction to within one: the top is wide enough to be climbed."""
    found, _ = case
    rng = np.random.default_rng(4)
    for _ in range(3):
        fit = refine(found.box.moved(sigma_step(found, rng, 10)), found.views, (*COARSE, *FINE), 10)
        spread = np.sqrt(np.diag(found.covariance)[6:])
        assert np.all(np.abs(fit.box.extents - found.box.extents) < spread + 2e-4)
        assert fit.value > refine(found.box, found.views, SHARP, 0).value - 4


def test_refining_never_ends_below_its_start(case: tuple[BoxEstimate, Box]) -> None:
    found, _ = case
    rng = np.random.default_rng(5)
    for size in (2, 20):
        start = found.box.moved(sigma_step(found, rng, size))
        assert refine(start, found.views, SHARP, 3).value >= refine(start, found.views, SHARP, 0).value


def test_a_box_a_rounding_error_too_thin_is_polled_too(case: tuple[BoxEstimate, Box], monkeypatch: pytest.MonkeyPatch) -> None:
    """A climb may end a hair under the least extent; with every face held by ranges that box is the only candidate."""
    found, _ = case
    monkeypatch.setattr(_fit, "_PINNING", 0.0)
    thin = refine(Box(found.box.box_to_camera, np.array([0.01 - 1e-12, 0.3, 0.2])), found.views, SHARP, 0)
    assert polled(thin, 0.005) is thin.box
