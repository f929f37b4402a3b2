"""``viewgain evaluate real`` through the real command: simulated scans for its laws, real ones where they lie, and bad input."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.oracles.networks_on_disk import exported
from viewgain.cli import main
from viewgain.measure import measure
from viewgain.network import NetworkSettings
from viewgain.plan import ExpectedErrorPolicy, next_view
from viewgain.scans import read_scan


def ranked(capsys: pytest.CaptureFixture[str], *arguments: object) -> dict[str, Any]:
    assert main(["evaluate", "real", "--json", *map(str, arguments)]) == 0
    content: dict[str, Any] = json.loads(capsys.readouterr().out)
    return content


def test_a_folder_is_ranked_as_next_view_does_and_what_is_no_scan_is_named(
    scans: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("matplotlib")
    folder = tmp_path / "scans"
    (folder / "deep").mkdir(parents=True)
    (folder / "deep" / "one.ply").write_bytes((scans / "one.ply").read_bytes())
    (folder / "notes.txt").write_text("no scan at all")
    (folder / "LICENSE").write_text("not looked at")
    out = tmp_path / "out"
    content = ranked(capsys, folder, "--out", out)
    (only,) = content["scans"]
    assert only["scan"] == "deep/one.ply"
    assert [each["file"] for each in content["not_read"]] == ["notes.txt"]
    measured = measure(read_scan(scans / "one.ply"))
    plans = {"covariance": next_view(measured), "expected": next_view(measured, policy=ExpectedErrorPolicy())}
    assert only["measured"]["boxes"][0]["dimensions_m"] == measured.to_dict()["boxes"][0]["dimensions_m"]  # type: ignore[index]
    for row in only["policies"]:
        plan = plans[row["name"]]
        assert row["best"] == plan.best
        scores = [candidate.assessment.score for candidate in plan.candidates]
        np.testing.assert_allclose([each["score"] for each in row["candidates"]], scores, atol=1e-5)
        assert row["ranking"] == sorted(row["ranking"], key=lambda index: -scores[index])
        turns = np.array([each["turn_deg"] for each in row["candidates"]])
        np.testing.assert_allclose((turns - turns[0] - 45 * np.arange(8) + 180) % 360 - 180, 0, atol=0.1)
    assert only["same_best"] == (plans["covariance"].best == plans["expected"].best)
    text = (out / "real.md").read_text()
    assert "| deep/one.ply |" in text
    assert "- notes.txt: " in text
    assert all(line.count("|") == 8 for line in text.splitlines() if line.startswith("|"))
    assert (out / "01_one.png").read_bytes().startswith(b"\x89PNG")


def test_a_network_ranks_too_and_one_policy_agrees_with_nobody(
    scans: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "net.onnx"
    settings = NetworkSettings(kind="pose_scores", views=5, points=64, neighbours=8, width=8, centres=(16, 8))
    exported(file, settings, rig="irregular", normalisation="metres", frame="camera")
    content = ranked(capsys, scans / "one.ply", "--policies", f"network:{file}")
    (only,) = content["scans"]
    assert (only["same_best"], only["mean_rank_correlation"]) == (None, None)
    assert only["policies"][0]["best"] in only["policies"][0]["ranking"]
    assert only["policies"][0]["candidates"][0]["predicted_volume_sigma_m3"] > 0


def test_each_policy_of_a_network_is_the_one_of_its_name(
    scans: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of a measured box: the formula, its rehearsals, and the network are three opinions."""
    monkeypatch.setattr("viewgain.plan._rehearsed.MOST", 4)
    assert next_view(measure(read_scan(scans / "one.ply"))).stop  # which is not what is asked here
    named = [f"{kind}:pose_scores-irregular-camera" for kind in ("network", "combined", "rehearsed")]
    (only,) = ranked(capsys, scans / "one.ply", "--policies", "expected", "rehearsed", *named)["scans"]
    scores = {row["name"]: [each["score"] for each in row["candidates"]] for row in only["policies"]}
    network, combined, rehearsed = (scores[name] for name in named)
    assert combined == scores["expected"]  # every dimension is bounded
    assert rehearsed == scores["rehearsed"] != combined
    assert network not in (rehearsed, combined)


def test_a_bare_floor_has_nothing_to_rank(scans: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["evaluate", "real", str(scans / "floor_unposed.ply")]) == 3
    assert "none: nothing_on_floor" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["nowhere.ply"], "nowhere.ply"),
        (["EMPTY"], "holds no file that can be read as a scan"),
        (["nowhere.ply", "--policies", "oracle"], "'oracle' is not known"),
        (["nowhere.ply", "--policies", "network:none.onnx"], "none.onnx"),
        (["nowhere.ply", "--policies", "rehearsed:none.onnx"], "none.onnx"),
        (
            ["nowhere.ply", "--policies", "combined_around:some.onnx"],
            "expected, rehearsed, network:FILE, combined:FILE, rehearsed:FILE",
        ),
        (["nowhere.ply", "--policies", "expected", "expected"], "each once"),
        (["nowhere.ply", "--rig", "carousel"], "'carousel' is not known"),
    ],
)
def test_bad_questions_end_in_one_line(
    arguments: list[str], words: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["evaluate", "real", *(str(tmp_path) if word == "EMPTY" else word for word in arguments)]) == 2
    error = capsys.readouterr().err
    assert words in error
    assert error.count("\n") == 1


def test_real_scans_of_the_small_box(data_dir: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = data_dir / "real_boxes" / "trai_tof"
    content = ranked(capsys, folder / "vedere2.pcd", folder / "Vedere_2_final.pcd")
    box, points = content["scans"]
    assert box["measured"]["boxes"][0]["volume_m3"] == pytest.approx(0.0172, rel=0.1)
    now = box["measured"]["boxes"][0]["volume_sigma_m3"]
    best = box["policies"][0]["candidates"][box["policies"][0]["best"]]
    assert best["predicted_volume_sigma_m3"] < now
    assert points["measured"]["reason"] == "no_floor"
    assert all(row["best"] is None for row in points["policies"])
