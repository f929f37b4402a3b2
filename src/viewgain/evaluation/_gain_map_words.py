"""The maps of one box as Markdown: what was asked, and how each policy's order agrees with the truth."""

import numpy as np

from viewgain.evaluation._gain_map import GainMap, PolicyMap
from viewgain.evaluation._map_values import Meaning
from viewgain.evaluation._position_scores import best_positions
from viewgain.evaluation._volume_words import off_centre_in_words

MEANINGS: dict[Meaning, str] = {
    "error": "expected volume error",
    "sigma_left": "standard deviation of the volume left",
    "minus_score": "minus the score, no unit",
}
"""What the values of a map are."""
_HEADER = ("", "says", "best position", "true error there, %", "rank correlation with the truth")


def gain_map_markdown(drawn: GainMap) -> str:
    """Return the table as Markdown."""
    truth, asked = drawn.truth, drawn.case.settings
    scans = f"mean volume error of {asked.captures} scans"
    rows = [
        ("truth", scans, position_in_words(drawn, truth.least), _percent(truth.mean[truth.least]), ""),
        *(_row(drawn, each) for each in drawn.policies),
    ]  # fmt: skip
    lines = ["| " + " | ".join(cells) + " |" for cells in (_HEADER, ["---"] * len(_HEADER), *rows)]
    sides = " x ".join(f"{side:.3f}" for side in drawn.case.box.extents)
    what = "fused with the present scan" if asked.fused else "alone"
    return "\n".join([
        f"## What each position is worth: box {drawn.case.number} of seed {asked.seed}, {sides} m, rig {asked.rig}",
        "",
        f"Yaw {np.rad2deg(drawn.yaw):.0f}°, camera {asked.camera}, estimator {asked.estimator}, each scan {what}"
        f"{off_centre_in_words(asked)}. Volume error: its size, a miss counts as 100 %."
        f" {int(truth.allowed.sum())} of {len(truth.allowed)} positions can be reached,"
        f" {int(best_positions(truth).sum())} of them count as best (within two standard errors of the least). Policies decide on"
        f" one scan from position {position_in_words(drawn, drawn.case.present)}.",
        "",
        *lines,
    ]) + "\n"  # fmt: skip


def position_in_words(drawn: GainMap, place: int) -> str:
    """Return a position with its direction from the box: 7 (azimuth 120°, elevation 35°)."""
    azimuth, elevation = np.rad2deg(drawn.azimuth[place]), np.rad2deg(drawn.elevation[place])
    return f"{place} (azimuth {azimuth:.0f}°, elevation {elevation:.0f}°)"


def _row(drawn: GainMap, said: PolicyMap) -> tuple[str, ...]:
    if said.best is None:
        return (said.name, MEANINGS[said.meaning], "no opinion", "", "")
    agreed = "" if said.correlation is None else f"{said.correlation:.2f}"
    there = _percent(drawn.truth.mean[said.best])
    return (said.name, MEANINGS[said.meaning], position_in_words(drawn, said.best), there, agreed)


def _percent(share: float) -> str:
    return f"{100 * share:.2f}"
