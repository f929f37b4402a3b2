"""The weights in the package: they load, say what they are, are small, and choose better than answers without learning."""

import json

import numpy as np
import pytest

from viewgain.cli import main
from viewgain.inference import VOLUME_MODEL, PoseScorer, Scorer, find_model, shipped_models, volume_scorer

LARGEST, ALL = 8e6, 40e6
"""Bytes of one file, and of all together."""


def test_each_is_small_and_its_card_says_what_it_learned_from_and_how_good_it_is() -> None:
    names = shipped_models()
    assert {"compact-pcnbv16-object", "compact_view-pcnbv16-object", "compact-pcnbv16-camera", VOLUME_MODEL} <= set(names)
    assert sum(find_model(name).stat().st_size for name in names) < ALL
    for name in names:
        assert find_model(name).stat().st_size < LARGEST
        card = (PoseScorer if name.startswith("pose_scores-") else Scorer).load(name).card
        assert f"{card.kind}-{card.rig}-{card.frame}" == name
        assert all(source.licence == "Apache-2.0" for source in card.trained_on)
        assert card.metrics
        assert all(metric.floors for metric in card.metrics)
        text = find_model(name).with_suffix(".md").read_text(encoding="utf-8")
        assert card.rig in text
        assert "Apache-2.0" in text


@pytest.mark.parametrize("name", ["compact-pcnbv16-object", "compact_view-pcnbv16-object", "compact_view-pcnbv33-object"])
def test_the_order_of_points_that_lie_on_a_grid_changes_nothing(name: str) -> None:
    """As points of half floats do: many lie exactly as far along the direction by which the networks sort them as another."""
    rng, network = np.random.default_rng(0), Scorer.load(name)
    grid = np.stack(np.meshgrid(*[np.arange(-16, 16)] * 3), axis=-1).reshape(-1, 3) / 64
    points = rng.permutation(grid)[:400].astype(np.float32)
    mask, told = np.ones((1, 400), dtype=bool), np.eye(1, network.card.views, dtype=np.float32)
    wanted = network.run(points[None], mask, told if network.card.with_view_state else None)
    for _ in range(5):
        again = network.run(rng.permutation(points)[None], mask, told if network.card.with_view_state else None)
        np.testing.assert_allclose(again, wanted, rtol=0, atol=1e-6)


@pytest.mark.slow
def test_on_fresh_objects_they_choose_far_better_than_the_constant_answer(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["evaluate", "table1", "--fresh", "1", "--seed", "5", "--json"]) == 0
    tables = [json.loads(line) for line in capsys.readouterr().out.splitlines() if line.startswith("{")]
    assert {table["frame"] for table in tables} == {"object", "camera"}
    for table in tables:
        exact = {row["name"]: row["shares"]["mean"][0] for row in table["rows"]}
        learned = [share for name, share in exact.items() if name in shipped_models()]
        assert learned
        assert min(learned) > exact["constant answer"] + 0.05


def test_the_network_for_volumes_is_opened_once_and_says_what_its_file_says() -> None:
    rng = np.random.default_rng(0)
    points, poses = rng.uniform(0.5, 1.5, (300, 3)), np.tile(np.eye(4), (3, 1, 1))
    poses[:, :3, 3] = rng.normal(size=(3, 3))
    assert volume_scorer() is volume_scorer()
    again = PoseScorer.load(VOLUME_MODEL).assessed(points, poses)
    np.testing.assert_array_equal(volume_scorer().assessed(points, poses).scores, again.scores)
