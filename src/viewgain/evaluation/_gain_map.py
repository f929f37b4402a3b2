"""What every position around one fresh box is worth, and what each policy believes that it is worth (docs/volume_nbv.md)."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from viewgain.arrays import Vector
from viewgain.errors import ConfigError
from viewgain.evaluation._choice import seen_of
from viewgain.evaluation._map_values import Meaning, Valued, rank_correlation, valued
from viewgain.evaluation._position_scores import PositionScores, best_positions, position_scores
from viewgain.evaluation._volume_case import VolumeCase, VolumeSettings, volume_case
from viewgain.evaluation._volume_choices import VOLUME_FLOORS, check_volume_policies, volume_policy
from viewgain.evaluation._volume_errors import errors_of_scans
from viewgain.plan import choose
from viewgain.rigs import Target

APART = float(np.deg2rad(1.0))
"""Positions less than this apart, seen from the box, would cover each other on a map, radians."""


@dataclass(frozen=True, slots=True, eq=False)
class PolicyMap:
    """What one policy believes of every position."""

    name: str
    """The policy's, as it was asked for."""
    meaning: Meaning
    """What its values are."""
    values: Vector
    """(V,) in rig order, the less the better; NaN where it has no opinion."""
    best: int | None
    """The position it would take; None without an opinion."""
    correlation: float | None
    """Rank correlation with the truth over the positions that can be reached; None where there is none."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class GainMap:
    """One box: the directions of the positions, their true worth, and what the policies believe."""

    case: VolumeCase
    """The box, the rig around it, and where the camera stands."""
    truth: PositionScores
    """Mean |V / V* - 1| of the scans of each position, a miss counted as 1."""
    policies: tuple[PolicyMap, ...]
    """In the order in which they were named."""

    @property
    def yaw(self) -> float:
        """Turn of the box's x axis from the world's, anticlockwise from above, radians."""
        return Target(self.case.box.box_to_camera, self.case.box.extents).yaw

    @property
    def azimuth(self) -> Vector:
        """(V,) directions of the positions from the box's centre, anticlockwise from the world's x axis, radians."""
        away = _away(self.case)
        return np.asarray(np.arctan2(away[:, 1], away[:, 0]) % (2 * np.pi))

    @property
    def elevation(self) -> Vector:
        """(V,) their angles over the horizon as seen from the box's centre, radians."""
        away = _away(self.case)
        return np.asarray(np.arctan2(away[:, 2], np.linalg.norm(away[:, :2], axis=1)))

    def to_dict(self) -> dict[str, object]:
        """Return the JSON form: angles in degrees, lengths in metres, null for what is not known."""
        case, best = self.case, best_positions(self.truth)
        distances = np.linalg.norm(_away(case), axis=1)
        return {
            "settings": case.settings.to_dict(),
            "box": case.number,
            "extents_m": np.round(case.box.extents, 6).tolist(),
            "yaw_deg": round(float(np.rad2deg(self.yaw)), 3),
            "present": case.present,
            "positions": [
                {
                    "azimuth_deg": round(float(np.rad2deg(self.azimuth[k])), 3),
                    "elevation_deg": round(float(np.rad2deg(self.elevation[k])), 3),
                    "distance_m": round(float(distances[k]), 4),
                    "reachable": bool(case.reachable[k]),
                    "error": _finite(self.truth.mean[k]),
                    "standard_error": _finite(self.truth.error[k]),
                    "counts_as_best": bool(best[k]),
                }
                for k in range(len(distances))
            ],
            "best": self.truth.least,
            "policies": [
                {
                    "name": each.name,
                    "meaning": each.meaning,
                    "values": [_finite(value) for value in each.values],
                    "best": each.best,
                    "error_of_its_best": None if each.best is None else _finite(self.truth.mean[each.best]),
                    "rank_correlation": _finite(each.correlation),
                }
                for each in self.policies
            ],
        }


def gain_map(settings: VolumeSettings, number: int, policies: Sequence[str]) -> GainMap:
    """Return the map of box ``number`` of a seed: what every position is worth, and what each policy says from the present one.

    Args:
        settings: The question; of its scans those that score the positions are taken, not the oracle's.
        number: Which box, 0 or more.
        policies: Names of policies that decide on a scan.

    Raises:
        ConfigError: If there is no such policy or it scores no positions, the number is negative, the settings leave no box, or
            two positions of the rig stand in one direction.
        ModelError: If a network cannot be used.
    """
    _check_mapped(number, policies)
    case = volume_case(settings, number)
    _require_apart(case)
    seen = seen_of(case)
    # Policies before the truth: a bad file should not cost minutes of scans.
    believed = [valued(volume_policy(name, case), seen) for name in policies]
    truth = position_scores(errors_of_scans(case, range(settings.captures)), case.reachable)
    return GainMap(
        case=case,
        truth=truth,
        policies=tuple(_held_against(truth, name, said) for name, said in zip(policies, believed, strict=True)),
    )


def _held_against(truth: PositionScores, name: str, said: Valued) -> PolicyMap:
    best = choose(-said.values, truth.allowed)
    known = best is not None and bool(np.isfinite(said.values[best]))
    correlation = rank_correlation(truth.mean, said.values, truth.allowed)
    return PolicyMap(name, said.meaning, said.values, best if known else None, correlation)


def _check_mapped(number: int, policies: Sequence[str]) -> None:
    if number < 0:
        raise ConfigError(f"evaluate map: got box {number}, wanted 0 or more")
    check_volume_policies(tuple(policies))
    for name in policies:
        if name in VOLUME_FLOORS:
            raise ConfigError(f"evaluate map: policy {name!r} scores no positions; name policies that decide on a scan")


def _require_apart(case: VolumeCase) -> None:
    away = _away(case)
    away = away / np.linalg.norm(away, axis=1, keepdims=True)
    close = np.argwhere(np.triu(away @ away.T > np.cos(APART), k=1))
    if len(close):
        one, other = close[0]
        raise ConfigError(
            f"evaluate map: positions {one} and {other} of rig {case.settings.rig} stand in one direction, where a map has one"
            " place; take a rig such as hemisphere48"
        )


def _away(case: VolumeCase) -> Vector:
    """Return (V, 3) from the box's centre to each position, metres, world frame."""
    return np.asarray(case.stations[:, :3, 3] - case.box.centre)


def _finite(value: float | None) -> float | None:
    return float(f"{value:.6g}") if value is not None and np.isfinite(value) else None
