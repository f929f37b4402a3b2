"""A network as a policy: what it is given, whose stations its scores belong to, and when it refuses."""

import json
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import pytest

from tests.oracles.networks_on_disk import exported, small_settings
from tests.oracles.scenes import corner_view, scan_of, standing_box
from viewgain.cli import main
from viewgain.cli._commands import Next
from viewgain.cli._deciding import Deciding
from viewgain.cli._next import run_next
from viewgain.errors import ConfigError, ModelError
from viewgain.inference import Ensemble, Scorer, Scores
from viewgain.plan import NetworkPolicy, next_view
from viewgain.scans import Scan, write_scan

BOX = standing_box(np.array([0.4, 0.3, 0.25]), yaw=0.3)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("networks")
    exported(made / "object.onnx", small_settings("compact"))
    exported(made / "camera.onnx", small_settings("compact"), frame="camera")
    exported(made / "told.onnx", small_settings("compact_view"))
    exported(made / "sure.onnx", small_settings("compact", uncertainty="evidential"))
    return made


@pytest.fixture(scope="module")
def scan() -> Scan:
    """A box from its corner, with the camera's pose."""
    return scan_of(BOX, view=corner_view(BOX))


def planned(scan: Scan, network: Path, rig: str = "pcnbv16"):
    return next_view(scan, rig, objective="coverage", policy=NetworkPolicy(Scorer.load(network), scan, rig))


@pytest.mark.parametrize("name", ["object", "camera", "told"])
def test_every_station_gets_a_score_and_the_best_reachable_one_wins(scan: Scan, folder: Path, name: str) -> None:
    plan = planned(scan, folder / f"{name}.onnx")
    scores = [candidate.assessment.score for candidate in plan.candidates]
    assert len(scores) == 16
    assert np.std(scores) > 0
    assert scores[plan.best] == max(c.assessment.score for c in plan.candidates if c.reachable)
    assert (plan.objective, plan.policy, plan.stop) == ("coverage", "network", False)


@dataclass(frozen=True)
class Marked:
    """A scorer that gives score k to answer k and keeps what it got."""

    inner: Scorer
    got: list = field(default_factory=list)
    sigma: np.ndarray | None = None

    @property
    def card(self):
        return self.inner.card

    def refusal(self, **known: str) -> str | None:
        return self.inner.refusal(**known)

    def assessed(self, points: np.ndarray, state: object, *, bounds: object, frame: str) -> Scores:
        self.got.append((points, state, bounds, frame))
        return Scores(np.arange(16.0), self.sigma)


def test_answers_are_counted_from_the_present_view_without_the_view_state(scan: Scan, folder: Path) -> None:
    """A camera at 35 degrees stands at station 9, the first of those at 30 degrees: answer 0 is its, answer 1 that of 10."""
    blind = Marked(Scorer.load(folder / "object.onnx"))
    plan = next_view(scan, "pcnbv16", objective="coverage", policy=NetworkPolicy(blind, scan, "pcnbv16"))
    assert [c.assessment.score for c in plan.candidates] == np.roll(np.arange(16.0), 9).tolist()
    told = Marked(Scorer.load(folder / "told.onnx"))
    plan = next_view(scan, "pcnbv16", objective="coverage", policy=NetworkPolicy(told, scan, "pcnbv16"))
    assert [c.assessment.score for c in plan.candidates] == np.arange(16.0).tolist()
    assert np.flatnonzero(told.got[0][1]).tolist() == [9]


def test_standard_deviations_go_with_their_scores(scan: Scan, folder: Path) -> None:
    marked = Marked(Scorer.load(folder / "sure.onnx"), sigma=np.arange(16.0) + 1)
    plan = next_view(scan, "pcnbv16", objective="coverage", policy=NetworkPolicy(marked, scan, "pcnbv16"))
    assert [c.assessment.sigma for c in plan.candidates] == [c.assessment.score + 1 for c in plan.candidates]
    assert plan.to_dict()["candidates"][0]["score_sigma"] == plan.candidates[0].assessment.sigma


def test_it_abstains_the_more_the_surer_it_should_be_and_says_why(scan: Scan, folder: Path) -> None:
    marked = Marked(Scorer.load(folder / "sure.onnx"), sigma=np.full(16, 3.0))
    plans = [
        next_view(
            scan, "pcnbv16", objective="coverage", policy=NetworkPolicy(marked, scan, "pcnbv16", abstain_below=float(limit))
        )
        for limit in np.linspace(0, 1, 11)
    ]
    abstained = [plan.abstention is not None for plan in plans]
    assert abstained == sorted(abstained)
    assert (abstained[0], abstained[-1]) == (False, True)
    chosen = plans[0].best
    for plan in plans:
        assert (plan.best, plan.reason) == ((None, "abstains") if plan.abstention else (chosen, None))
    assert f"prefers view {chosen}" in plans[-1].abstention
    assert "under the 1.00 asked for" in plans[-1].to_dict()["abstention"]


def test_to_abstain_wants_a_standard_deviation(scan: Scan, folder: Path) -> None:
    one, two = (Ensemble([Scorer.load(folder / "object.onnx")] * number) for number in (1, 2))
    with pytest.raises(ConfigError, match="standard deviations"):
        NetworkPolicy(one, scan, "pcnbv16", abstain_below=0.5)
    with pytest.raises(ConfigError, match="probability"):
        NetworkPolicy(two, scan, "pcnbv16", abstain_below=1.5)
    sure = next_view(scan, "pcnbv16", objective="coverage", policy=NetworkPolicy(two, scan, "pcnbv16", abstain_below=0.9))
    assert sure.abstention is None  # twice the same network: no spread


def test_the_network_sees_the_object_alone_in_the_axes_of_the_stations(scan: Scan, folder: Path) -> None:
    blind = Marked(Scorer.load(folder / "object.onnx"))
    next_view(scan, "pcnbv16", objective="coverage", policy=NetworkPolicy(blind, scan, "pcnbv16"))
    points, _, bounds, frame = blind.got[0]
    assert frame == "object"
    assert bounds.diagonal == pytest.approx(np.linalg.norm(BOX.extents), rel=0.03)
    centred = points - bounds.centre
    assert np.linalg.norm(centred, axis=1).max() < 0.53 * bounds.diagonal
    assert centred[:, 2].max() == pytest.approx(0.125, abs=0.02)  # the top, half the height above the centre
    assert centred[:, 0].mean() > 0.03  # the near side, towards azimuth 0, is the one that is seen
    assert abs(centred[:, 1].mean()) < 0.05


def test_a_network_of_the_object_frame_refuses_a_scan_without_a_pose(scan: Scan, folder: Path) -> None:
    unposed = replace(scan, camera_to_world=None)
    with pytest.raises(ConfigError, match="camera_to_world"):
        planned(unposed, folder / "object.onnx")
    assert planned(unposed, folder / "camera.onnx").best is not None


def test_another_rig_and_another_objective_are_refused(scan: Scan, folder: Path) -> None:
    with pytest.raises(ConfigError, match="pcnbv16"):
        planned(scan, folder / "object.onnx", rig="ring8")
    with pytest.raises(ConfigError, match="policy"):
        next_view(scan, "pcnbv16", objective="coverage")
    with pytest.raises(ConfigError, match="not known"):
        next_view(scan, "pcnbv16", objective="beauty")


def test_the_command_ranks_by_a_network(scan: Scan, folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "scan.ply"
    write_scan(replace(scan, camera_to_world=None), path)
    chosen = Deciding(policy="network", model=(folder / "camera.onnx",))
    command = Next(scans=(path,), rig="pcnbv16", objective="coverage", deciding=chosen)
    assert run_next(command) == 0
    assert "policy network" in capsys.readouterr().out
    with pytest.raises(ModelError, match="wanted pose_scores"):
        run_next(replace(command, objective="volume"))
    with pytest.raises(ConfigError, match="--policy combined, which knows boxes only"):
        run_next(replace(command, deciding=replace(chosen, policy="combined")))
    with pytest.raises(ConfigError, match="boxes only"):
        run_next(replace(command, deciding=Deciding()))
    with pytest.raises(ModelError, match="not shipped"):
        run_next(replace(command, rig="ring9", deciding=Deciding(policy="network")))


def test_the_command_abstains_in_words(scan: Scan, folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "scan.npz"
    write_scan(scan, path)
    networks = [str(folder / "sure.onnx"), str(folder / "sure.onnx")]
    arguments = ["next", str(path), "--rig", "pcnbv16", "--objective", "coverage", "--policy", "network", "--model", *networks]
    assert main([*arguments, "--abstain", "1"]) == 0
    words = capsys.readouterr().out
    assert "No view is named: the network prefers view" in words
    assert main([*arguments, "--abstain", "1", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert (told["best"], told["reason"]) == (None, "abstains")
    assert main(arguments) == 0
    assert "No view is named" not in capsys.readouterr().out
