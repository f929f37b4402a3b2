"""Rigs by name and by number: the published ones, rings, hemispheres, and irregular ones drawn from a seed."""

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np

from viewgain.errors import ConfigError
from viewgain.rigs._file import read_rig
from viewgain.rigs._jitter import Interval, Jitter
from viewgain.rigs._rig import Rig, Station

GOLDEN_ANGLE = float(np.pi * (3 - np.sqrt(5)))
"""Azimuth from one station of a hemisphere to the next, radians."""
PAPER_JITTER = Jitter(
    position=((-0.1, 0.1), (-0.1, 0.1), (0.0, 0.05)),
    aim=((-0.1, 0.1), (-0.1, 0.1), (0.0, 0.1)),
    rotation=((-0.05, 0.05), (-0.05, 0.05), (0.0, 0.1)),
)
"""Pop and Tamas 2022, public scripts."""
BY_HAND = Jitter(
    position=((-0.02, 0.02),) * 3,
    aim=((-0.02, 0.02),) * 3,
    rotation=((-float(np.deg2rad(2.0)), float(np.deg2rad(2.0))),) * 3,
)
"""Ours: a tripod put back on its marks by hand, 2 cm and 2 degrees either way."""
IRREGULAR_JITTER = Jitter(
    azimuth=(-np.deg2rad(5.0), np.deg2rad(5.0)), elevation=(-np.deg2rad(3.0), np.deg2rad(3.0)), distance=(-0.05, 0.05)
)
"""Ours: uniform, up to 5 degrees, 3 degrees and 5 % either way."""


def ring(count: int, *, elevation: float | None = None, distance: float | None = None) -> Rig:
    """Return ``count`` stations at equal steps of azimuth, anticlockwise from above; station 0 is the direction they count from.

    Args:
        count: Number of stations, at least 2.
        elevation: Of all of them, radians; None leaves it open.
        distance: Of all of them, metres; None leaves it open.

    Raises:
        ConfigError: If ``count`` is under 2.
    """
    if count < 2:
        raise ConfigError(f"got a ring of {count} stations, wanted at least 2")
    azimuths = 2 * np.pi * np.arange(count) / count
    stations = tuple(Station(azimuth=float(a), elevation=elevation, distance=distance) for a in azimuths)
    return Rig(name=f"ring{count}", stations=stations)


def hemisphere(count: int, *, lowest: float = 0.0, distance: float | None = None) -> Rig:
    """Return ``count`` nearly evenly spread stations above ``lowest``, in a spiral from the top down.

    Fibonacci lattice: station k = 0, 1, ... stands at azimuth k pi (3 - sqrt 5) and at the elevation whose sine is
    1 - (1 - sin lowest) (k + 1/2) / count, so each has the same share of the area A = 2 pi (1 - sin lowest) of the unit sphere;
    the angle to the nearest other one is 0.87 to 1.05 times sqrt(A / count).

    Args:
        count: Number of stations, at least 1.
        lowest: Elevation that bounds them from below, radians.
        distance: Of all of them, metres; None leaves it open.

    Raises:
        ConfigError: If ``count`` is under 1 or ``lowest`` is not between -90 and 90 degrees.
    """
    if count < 1 or not -np.pi / 2 <= lowest < np.pi / 2:
        raise ConfigError(f"got a hemisphere of {count} stations from {lowest} rad up, wanted 1 or more, from under pi / 2 up")
    steps = np.arange(count)
    elevations = np.arcsin(1 - (1 - np.sin(lowest)) * (steps + 0.5) / count)
    azimuths = steps * GOLDEN_ANGLE % (2 * np.pi)
    stations = tuple(
        Station(azimuth=float(a), elevation=float(e), distance=distance) for a, e in zip(azimuths, elevations, strict=True)
    )
    return Rig(name=f"hemisphere{count}", stations=stations)


def irregular_rig(
    count: int,
    *,
    rng: np.random.Generator,
    azimuth: Interval = (0.0, 2 * np.pi),
    elevation: Interval = (np.pi / 9, np.pi / 3),
    distance: Interval = (0.8, 1.4),
    jitter: Jitter = IRREGULAR_JITTER,
) -> Rig:
    """Return ``count`` random stations in order of azimuth, counted from the world's x axis.

    Azimuths, elevations (radians) and distances (metres, from the target's centre) are drawn independently and uniformly between
    the two numbers of each interval. The jitter is drawn later, and anew each time the rig is placed.

    Raises:
        ConfigError: If there is no station, or an interval is not finite, runs backwards or starts at no distance.
    """
    if count < 1 or any(not np.all(np.isfinite(i)) or i[0] > i[1] for i in (azimuth, elevation, distance)) or distance[0] <= 0:
        raise ConfigError("an irregular rig wants a station or more, and intervals (low, high) of angles and positive distances")
    azimuths = np.sort(rng.uniform(*azimuth, count))
    rows = zip(azimuths, rng.uniform(*elevation, count), rng.uniform(*distance, count), strict=True)
    stations = tuple(Station(azimuth=float(a), elevation=float(e), distance=float(d)) for a, e, d in rows)
    return Rig(name=f"random{count}", stations=stations, jitter=jitter, absolute=True)


def _paper(name: str, *, unnormalised: bool) -> Rig:
    """Return the four positions of Pop and Tamas 2022, read off their public scripts.

    All stand on one azimuth, along the footprint's diagonal, at horizontal offset d from a top corner and height d tan(pi / 3.5)
    or d tan(pi / 2.9) above it, d = 1 or 1.3 m, and look at that corner. The scripts mean the offset vector to be d (L, W) /
    |(L, W)| but divide by the squared norm, L and W being the half extents in metres; ``unnormalised`` does the same.
    """
    stations = tuple(
        Station(corner=0, elevation=e, distance=d / float(np.cos(e)), unnormalised=unnormalised)
        for d in (1.0, 1.3)
        for e in (np.pi / 3.5, np.pi / 2.9)
    )
    return Rig(name=name, stations=stations, jitter=PAPER_JITTER)


def _recorded4() -> Rig:
    """Return four positions with the names of the recordings of Pop and Tamas 2022; what the names mean is our reading.

    Their paper says four positions and angles, their public scripts the names alone. Ours stand on the footprint's diagonal, 0.5
    or 1 m from the nearest top corner as measured on the floor, level with it (Sameheight) or as far above it (Top), and look at
    it. From straight above no side is seen and their estimator finds no volume, so Top is aslant. In alphabetical order, as
    folders are read: theirs is Top before Sameheight, the same order in a circle.
    """
    stations = tuple(
        Station(corner=0, elevation=elevation, distance=floor / float(np.cos(elevation)), name=f"{name}_{100 * floor:03.0f}")
        for name, elevation in (("Sameheight", 0.0), ("Top", np.pi / 4))
        for floor in (0.5, 1.0)
    )
    return Rig(name="recorded4", stations=stations, jitter=BY_HAND)


def _irregular4() -> Rig:
    """Return four stations at odd angles, ours: no rotation maps one onto another."""
    azimuths, elevations = np.deg2rad([20.0, 70.0, 140.0, 225.0]), np.deg2rad([35.0, 48.0, 32.0, 42.0])
    rows = zip(azimuths, elevations, (1.0, 1.3, 0.85, 1.15), strict=True)
    stations = tuple(Station(azimuth=float(a), elevation=float(e), distance=d) for a, e, d in rows)
    return Rig(name="irregular4", stations=stations, jitter=IRREGULAR_JITTER, absolute=True)


def _pcnbv(count: int) -> Rig:
    """Return the first ``count`` of the 33 directions of Zeng et al. 2020 (PC-NBV), in their published order.

    The pole, then eight azimuths at elevations 60, 30, 0 and -30 degrees. The public list is y-up and counts azimuth from its z
    towards its x: our x, y, z are its z, x, y. Table 1 of Pop and Tamas 2022 has the first 16.
    """
    rows = [Station(elevation=np.pi / 2)]
    for elevation in np.deg2rad([60.0, 30.0, 0.0, -30.0]):
        rows += [Station(azimuth=np.pi * k / 4, elevation=float(elevation)) for k in range(8)]
    return Rig(name=f"pcnbv{count}", stations=tuple(rows[:count]))


RIGS = {
    each.name: each
    for each in (
        ring(8),
        _paper("paper4", unnormalised=False),
        _paper("paper4_unnormalised", unnormalised=True),
        _recorded4(),
        _irregular4(),
        _pcnbv(33),
        _pcnbv(16),
    )
}
"""Rigs by name; rings and hemispheres of any number besides."""
FAMILIES: dict[str, Callable[[int], Rig]] = {"ring": ring, "hemisphere": hemisphere}
"""Rigs by name and number."""


def rig(name: str | Rig) -> Rig:
    """Return a preset by name, ``ring<N>`` or ``hemisphere<N>``, or the rig of a TOML file by its path (docs/rigs.md).

    Raises:
        ConfigError: If the name is no preset and no readable rig file.
    """
    if isinstance(name, Rig):
        return name
    if name in RIGS:
        return RIGS[name]
    numbered = re.fullmatch(rf"({'|'.join(FAMILIES)})([1-9][0-9]{{0,4}})", name)
    if numbered:
        return FAMILIES[numbered[1]](int(numbered[2]))
    path = Path(name)
    if path.suffix != ".toml":
        known = ", ".join([*RIGS, *(f"{family}<N>" for family in FAMILIES)])
        raise ConfigError(f"rig {name!r} is not known; choose one of {known}, or give a .toml file")
    return read_rig(path)
