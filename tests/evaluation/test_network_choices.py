"""Networks of fixed stations as policies of volume: whose score is whose, when they say nothing, and which are refused."""

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.oracles.networks_on_disk import exported, small_settings
from viewgain.errors import ConfigError, ModelError
from viewgain.evaluation import VolumeSettings, choice, run_boxes, volume_case
from viewgain.evaluation._choice import seen_of
from viewgain.evaluation._network_choices import StationNetworkPolicy
from viewgain.evaluation._volume_choices import policy_of
from viewgain.inference import Scorer
from viewgain.plan import CombinedPolicy, ExpectedErrorPolicy

SETTINGS = VolumeSettings(seed=2, captures=2, estimator="lines_published", side=(0.2, 0.5))
CASE = volume_case(SETTINGS, 0)


@dataclass(frozen=True)
class Counting:
    """A scorer whose answer k is k, and that keeps what it was given."""

    got: list[Any] = field(default_factory=list)

    def scores(self, points: np.ndarray, *, frame: str) -> np.ndarray:
        self.got.append((points, frame))
        return np.arange(4.0)


def network(path: Path, **changes: Any) -> Path:
    told = {"rig": "irregular4", "frame": "camera", "normalisation": "metres"} | changes
    exported(path, small_settings("compact", views=4), seed=5, **told)
    return path


@pytest.mark.parametrize("present", range(4))
def test_answer_k_belongs_to_the_station_k_on_from_the_nearest_one(present: int) -> None:
    scorer, seen = Counting(), seen_of(replace(CASE, present=present))
    away = seen.stands.copy()
    away[-1, :3, 3] += [0.03, -0.02, 0.01]  # the camera is where it believes to be, and near a station only
    scores = StationNetworkPolicy(scorer).scores(replace(seen, stands=away))  # type: ignore[arg-type]
    assert {(present + k) % 4: float(k) for k in range(4)} == dict(enumerate(scores.tolist()))
    ((points, frame),) = scorer.got
    assert frame == "camera"
    assert np.array_equal(points, seen.scans[-1].points)


def test_without_a_scan_it_has_no_opinion_and_is_not_asked() -> None:
    scorer = Counting()
    scores = StationNetworkPolicy(scorer).scores(replace(seen_of(CASE), scans=()))  # type: ignore[arg-type]
    assert np.isnan(scores).all()
    assert (scores.shape, scorer.got) == ((4,), [])


@pytest.mark.parametrize("fused", [False, True])
def test_model_and_network_are_weighted_for_what_is_asked(*, fused: bool) -> None:
    """Of a scan alone, or of it and the present one."""
    settings = VolumeSettings(seed=2, captures=2, side=(0.2, 0.5), fused=fused)
    policy = policy_of("combined:pose_scores-irregular4-camera", volume_case(settings, 0))
    assert isinstance(policy, CombinedPolicy)
    assert policy.model.policy == ExpectedErrorPolicy(fused=fused)


@pytest.mark.slow
def test_a_file_decides_as_its_scores_do_by_hand(tmp_path: Path) -> None:
    file = network(tmp_path / "paper.onnx")
    runs = run_boxes(SETTINGS, 2, [f"network:{file}"])
    for number, run in enumerate(runs):
        case = volume_case(SETTINGS, number)
        scan = case.seen
        assert scan is not None
        answers = Scorer.load(file).scores(scan.points, frame="camera")
        stations = sorted((float(answers[k]), (case.present + k) % 4) for k in range(4) if case.reachable[(case.present + k) % 4])
        said = run.choices[f"network:{file}"]
        assert (said.position, said.has_opinion) == (stations[-1][1], True)
        assert said.margin == pytest.approx(stations[-1][0] - stations[-2][0])
        assert said == choice(case, StationNetworkPolicy(Scorer.load(file)))


@pytest.mark.parametrize(
    ("changes", "kind", "words"),
    [
        ({"rig": "ring4"}, "compact", "rig ring4, not of irregular4"),
        ({"frame": "object"}, "compact", "object frame"),
        ({"normalisation": "whole_box"}, "compact", "scores coverage and not volumes"),
        ({}, "compact_view", "told the visited views"),
    ],
)
@pytest.mark.parametrize("how", ["network", "combined"])
def test_a_network_for_something_else_is_said_before_the_first_box(
    how: str, changes: dict[str, Any], kind: Any, words: str, tmp_path: Path
) -> None:
    told = {"rig": "irregular4", "frame": "camera", "normalisation": "metres"} | changes
    exported(tmp_path / "wrong.onnx", small_settings(kind, views=4), **told)
    watched: list[Any] = []
    with pytest.raises(ConfigError, match=words):
        run_boxes(
            SETTINGS, 2, ["farthest", f"{how}:{tmp_path / 'wrong.onnx'}"], folder=tmp_path / "out",
            watch=lambda *done: watched.append(done),
        )  # fmt: skip
    assert watched == []
    assert not (tmp_path / "out").exists()


def test_a_missing_and_a_damaged_file_are_said_before_the_first_box(tmp_path: Path) -> None:
    right = network(tmp_path / "right.onnx")
    (tmp_path / "broken.onnx").write_bytes(right.read_bytes()[:500])
    watched: list[Any] = []
    for name, words in (("nowhere", "no such file"), ("broken", "cannot be read as a network")):
        with pytest.raises(ModelError, match=words):
            run_boxes(
                SETTINGS, 2, [f"network:{right}", f"combined:{tmp_path / name}.onnx"],
                watch=lambda *done: watched.append(done),
            )  # fmt: skip
    assert watched == []
