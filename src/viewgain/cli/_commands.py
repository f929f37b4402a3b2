"""The commands as dataclasses: the fields are the options, their docstrings the help."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Literal

import tyro

Scans = tyro.conf.Positional[tuple[Path, ...]]


@dataclass(frozen=True, kw_only=True)
class Reading:
    """How the files are read."""

    intrinsics: Path | None = None
    """Camera JSON of depth images (fx, fy, cx, cy, ...); without it the JSON beside the image is taken."""
    amplitude: Path | None = None
    """Amplitude image of a depth image."""
    min_amplitude: float | None = None
    """Drop returns weaker than this, in the amplitude's own units."""
    units: Literal["m", "mm"] | None = None
    """Units of the file; default detected and said."""
    pose: tuple[Path, ...] = ()
    """camera_to_world of each scan (JSON or text, 4x4), in the order of the scans."""
    camera: str | None = None
    """Camera preset (pico_flexx, xtion) for noise and systematic error; default estimated from the scan."""
    floor: Path | None = None
    """Scan of the empty scene from the same pose, where the box hides the floor."""


@dataclass(frozen=True, kw_only=True)
class Measure:
    """Measure the boxes in one scan or several: dimensions, volume, error bars, flags."""

    scans: Scans
    """Scan files: PLY, PCD, NPZ, NPY, XYZ, CSV or 16-bit depth PNG."""
    reading: Annotated[Reading, tyro.conf.arg(name="")] = field(default_factory=Reading)
    """How the files are read."""
    fuse: bool = False
    """Join all scans (each with a pose) into one estimate instead of measuring them apart."""
    json: bool = False
    """One JSON object per result, one line each, and nothing else on stdout."""
    csv: bool = False
    """One CSV row per box."""


@dataclass(frozen=True, kw_only=True)
class Next:
    """Say where the camera should go next so that the volume becomes certain."""

    scans: Scans
    """Scan files; several need a pose each, and the last is the camera as it stands."""
    reading: Annotated[Reading, tyro.conf.arg(name="")] = field(default_factory=Reading)
    """How the files are read."""
    rig: str = "ring8"
    """Candidate poses: ring8, paper4, pcnbv33, or a TOML file of your own."""
    objective: Literal["volume"] = "volume"
    """What to become certain of."""
    tolerance: float = 0.05
    """Relative volume error that is good enough."""
    confidence: float = 0.95
    """Stop when the error is under the tolerance with this probability."""
    json: bool = False
    """One JSON object, one line, and nothing else on stdout."""


@dataclass(frozen=True, kw_only=True)
class Demo:
    """Run the whole loop on a random simulated scene and write a report folder."""

    out: Path = Path("demo-report")
    """Folder for the report (pictures, numbers.json, index.html)."""
    seed: int = 4
    """Which scene."""
    rig: str = "ring8"
    """Candidate poses."""
    camera: str = "pico_flexx"
    """Camera preset."""
    tolerance: float = 0.05
    """Relative volume error that is good enough."""
    confidence: float = 0.95
    """Stop when the error is under the tolerance with this probability."""
    max_views: int = 5
    """Most scans to take."""
