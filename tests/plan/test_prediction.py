"""The prediction against the measurement: what a view is expected to teach, and what it then does."""

import numpy as np
import pytest

from tests.oracles.scenes import MODELLED
from viewgain.camera import sensor
from viewgain.measure import LOOSE_PRIOR, Knowledge, marginal, measure, pose_precision
from viewgain.plan import predict
from viewgain.scenes import Scene, SceneRanges, random_box, random_view
from viewgain.simulate import capture

CAMERA = sensor("pico_flexx").without_systematic()


def sigmas(knowledge: Knowledge) -> np.ndarray:
    return np.sqrt(np.diag(np.linalg.inv(knowledge.information + LOOSE_PRIOR)))[6:]


@pytest.mark.slow
def test_predicted_sigmas_of_the_present_view_are_the_measured_ones() -> None:
    """Same box, same pose: expectation and information of the real pixels agree within a third."""
    ratios = []
    for seed in range(12):
        rng = np.random.default_rng(seed)
        box = random_box(rng)
        view = random_view(rng, box, SceneRanges(elevation_deg=(28, 50), aim_sd=0.02, distance=(1.0, 1.4)))
        measured = measure(capture(Scene((box,)), view, CAMERA, rng=rng, effects=MODELLED), camera=CAMERA).boxes[0]
        expected = predict(measured.box, np.eye(4), CAMERA, measured.views[0].noise)
        ratios.append(sigmas(expected.knowledge) / sigmas(measured.knowledge))
    middle = np.median(ratios, axis=0)
    assert np.all((middle > 0.75) & (middle < 1.33)), middle


def one_view() -> tuple[Knowledge, object]:
    rng = np.random.default_rng(0)
    box = random_box(rng).in_frame(
        np.linalg.inv(random_view(rng, random_box(np.random.default_rng(0)), SceneRanges(aim_sd=0.01)))
    )
    return predict(box, np.eye(4), CAMERA, 1.0).knowledge, box


def test_more_views_never_take_knowledge_away() -> None:
    knowledge, _ = one_view()
    assert np.all(sigmas(knowledge.plus(knowledge)) <= sigmas(knowledge) * (1 + 1e-9))
    assert np.all(np.linalg.eigvalsh(knowledge.information) > -1e-6 * np.linalg.norm(knowledge.information))


def test_an_unsure_pose_teaches_less_and_a_perfect_one_loses_nothing() -> None:
    knowledge, box = one_view()
    to_box = np.linalg.inv(box.box_to_camera)
    last = sigmas(knowledge)
    for metres, degrees in ((1e-7, 1e-6), (0.003, 0.3), (0.03, 3.0)):
        precision = pose_precision(to_box, to_box, (metres, np.deg2rad(degrees)))
        now = sigmas(Knowledge(*marginal(knowledge.information, knowledge.systematic, precision)))
        assert np.all(now >= last * (1 - 1e-3))
        last = now
    nearly = pose_precision(to_box, to_box, (1e-7, 1e-8))
    assert np.allclose(
        marginal(knowledge.information, knowledge.systematic, nearly)[0], knowledge.information, rtol=0.02, atol=1e3
    )


def test_a_camera_that_looks_away_learns_nothing() -> None:
    _, box = one_view()
    behind = np.diag([-1.0, 1.0, -1.0, 1.0])
    away = predict(box, behind, CAMERA, 1.0)
    assert not away.knowledge.information.any()
    assert away.sights == ()


def test_twice_the_noise_is_a_quarter_of_the_range_information() -> None:
    """With edges silenced only range readings are left, and they scale as 1 / sigma^2."""
    from dataclasses import replace

    _, box = one_view()
    deaf = replace(CAMERA, edge_sd_px=1e3)
    once, twice = (predict(box, np.eye(4), deaf, noise).knowledge.systematic[:, :-1] for noise in (1.0, 2.0))
    assert np.allclose(once, 4 * twice, rtol=1e-9)
    assert np.abs(once).max() == pytest.approx(np.abs(4 * twice).max())
