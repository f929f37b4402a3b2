"""The commands about volume planners as dataclasses: the fields are the options, their docstrings the help."""

from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True, kw_only=True)
class EvaluateVolume:
    """Say how well planners choose the next view for a box's volume, on fresh boxes from a seed of your choice."""

    boxes: int = 20
    """How many boxes; one takes half a minute or so with the default estimator."""
    seed: int = 0
    """Source of boxes and scans."""
    rig: str = "irregular4"
    """Positions: irregular4, ring8, hemisphere12, ... (docs/rigs.md), or a TOML file."""
    camera: str = "pico_flexx"
    """Camera preset (docs/cameras.md) or a TOML file."""
    policies: tuple[str, ...] = ("model", "covariance", "farthest", "constant", "random", "oracle")
    """Who chooses: model, covariance, farthest, constant, random, oracle, network:FILE.onnx, combined:FILE.onnx."""
    estimator: str = "default"
    """Who measures: default, lines_published, lines_mended, corners_published, corners_mended."""
    captures: int = 24
    """Scans of each position that score it; as many others are the oracle's."""
    fused: bool = False
    """A position is worth what its scan and the present one say together (default estimator only)."""
    side: tuple[float, float] = (0.05, 1.2)
    """Least and longest side of the boxes, metres."""
    distance: float = 1.2
    """For stations that leave it open, metres from the centre."""
    elevation: float = 35.0
    """For stations that leave it open, degrees."""
    workers: int = 1
    """Processes; the results are the same whatever the number."""
    json: bool = False
    """One JSON object, one line, and nothing else on stdout."""
    out: Path | None = None
    """Folder of the results: what every box took is kept, so the same command goes on where it was; volume.md and volume.json."""
