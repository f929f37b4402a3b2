"""The commands about volume planners as dataclasses: the fields are the options, their docstrings the help."""

from dataclasses import dataclass
from pathlib import Path

import tyro


@dataclass(frozen=True, kw_only=True)
class FreshBoxes:
    """What all commands on fresh boxes ask: which boxes, seen by which camera, from how far."""

    seed: int = 0
    """Source of boxes and scans."""
    camera: str = "pico_flexx"
    """Camera preset (docs/cameras.md) or a TOML file."""
    side: tuple[float, float] = (0.05, 1.2)
    """Least and longest side of the boxes, metres."""
    distance: float = 1.2
    """For stations that leave it open, metres from the centre."""
    elevation: float = 35.0
    """For stations that leave it open, degrees."""
    json: bool = False
    """One JSON object, one line, and nothing else on stdout."""


@dataclass(frozen=True, kw_only=True)
class EvaluateVolume(FreshBoxes):
    """Say how well planners choose the next view for a box's volume, on fresh boxes from a seed of your choice."""

    boxes: int = 20
    """How many boxes; one takes half a minute or so with the default estimator."""
    first: int = 0
    """Number of the first box: so a long run can be done in parts, or on several machines (docs/volume_nbv.md)."""
    rig: str = "irregular4"
    """Positions: irregular4, ring8, hemisphere12, ... (docs/rigs.md), or a TOML file."""
    policies: tuple[str, ...] = ("expected", "covariance", "farthest", "constant", "random", "oracle")
    """Who chooses: expected, expected_around, rehearsed, rehearsed_around, covariance, farthest, constant, random, informed,
    oracle, and with a network, network:FILE.onnx, combined:FILE.onnx, combined_around:FILE.onnx, rehearsed:FILE.onnx,
    rehearsed_around:FILE.onnx (_around: is told that the rig was put up around the box, to 10 cm; rehearsed: tries the contenders
    out in simulation, up to a minute for each box)."""
    estimator: str = "default"
    """Who measures: default, lines_published, lines_mended, corners_published, corners_mended."""
    captures: int = 24
    """Scans of each position that score it; as many others are the oracle's."""
    fused: bool = False
    """A position is worth what its scan and the present one say together (default estimator only)."""
    off_centre: float = 0.0
    """How far the middle of the rig lies from each box's centre, standard deviation per axis, metres."""
    workers: int = 1
    """Processes; the results are the same whatever the number."""
    out: Path | None = None
    """Folder of the results: what every box took is kept, so the same command goes on where it was; volume.md and volume.json."""


@dataclass(frozen=True, kw_only=True)
class EvaluateLoop(FreshBoxes):
    """Say how many views planners need until a box's volume is certain, on fresh boxes from a seed of your choice."""

    boxes: int = 20
    """How many boxes; one takes up to a minute on irregular4, most of it for the oracle."""
    rig: str = "irregular4"
    """Positions: irregular4, ring8, hemisphere12, ... (docs/rigs.md), or a TOML file."""
    policies: tuple[str, ...] = ("covariance", "expected", "farthest", "ring", "random", "greedy", "oracle")
    """Who chooses: covariance, expected, expected_around, farthest, ring, random, greedy, oracle, network:FILE.onnx,
    combined:FILE.onnx, combined_around:FILE.onnx."""
    most_views: int = 4
    """Scans of each box, 2 or more; the oracle tries all sets of as many."""
    tolerance: float = 0.02
    """Relative volume error asked for."""
    confidence: float = 0.95
    """Stop when the planner gives the error to be under the tolerance with this probability."""
    workers: int = 1
    """Processes; the results are the same whatever the number."""
    out: Path | None = None
    """Folder of the results: what came of every box is kept, so the same command goes on where it was; loop.md, .json, .png."""


@dataclass(frozen=True, kw_only=True)
class EvaluateShapes:
    """Say how well planners choose the second view for the volumes of objects of any shape."""

    objects: int = 24
    """How many, of the categories in turn; one takes a few seconds."""
    seed: int = 0
    """Source of objects and scans."""
    categories: tuple[str, ...] = ()
    """Kinds of objects; default the procedural ones that no shipped network trained on, or all of --meshes."""
    meshes: Path | None = None
    """Folder of meshes, category/name.ply (docs/meshes.md), z up; default procedural objects."""
    size: tuple[float, float] = (0.2, 0.8)
    """Shortest and longest diagonal of an object, metres."""
    rig: str = "ring8"
    """Positions: ring8, hemisphere12, irregular4, ... (docs/rigs.md), or a TOML file."""
    camera: str = "pico_flexx"
    """Camera preset (docs/cameras.md) or a TOML file."""
    policies: tuple[str, ...] = ()
    """Who chooses: columns, rear_side_voxel, ... (docs/volumetric.md), auto, covariance, expected, expected_around, farthest,
    network:FILE.onnx, combined:FILE.onnx, combined_around:FILE.onnx, constant, random, oracle; default one of each kind."""
    captures: int = 2
    """Scans of each position that score it; as many others are the oracle's."""
    distance: float = 1.2
    """For stations that leave it open, metres from the centre."""
    elevation: float = 35.0
    """For stations that leave it open, degrees."""
    workers: int = 1
    """Processes; the results are the same whatever the number."""
    json: bool = False
    """One JSON object, one line, and nothing else on stdout."""
    out: Path | None = None
    """Folder of the results: what came of every object is kept, so the same command goes on where it was; shapes.md, .json."""


@dataclass(frozen=True, kw_only=True)
class EvaluateMap(FreshBoxes):
    """Draw what every position around one fresh box is worth: the truth of many scans, and what each policy believes."""

    box: int = 0
    """Which box of the seed, the same as that of evaluate volume."""
    rig: str = "hemisphere48"
    """Positions: hemisphere<N>, ring<N>, irregular4, ... (docs/rigs.md), or a TOML file; one in each direction."""
    policies: tuple[str, ...] = ("expected", "covariance")
    """Who decides: expected, expected_around, rehearsed, rehearsed_around, covariance, farthest, and with a network,
    network:FILE.onnx, combined:FILE.onnx, combined_around:FILE.onnx, rehearsed:FILE.onnx, rehearsed_around:FILE.onnx."""
    estimator: str = "default"
    """Who measures: default, lines_published, lines_mended, corners_published, corners_mended."""
    captures: int = 8
    """Scans of each position whose mean error is the truth."""
    fused: bool = False
    """A position is worth what its scan and the present one say together (default estimator only)."""
    off_centre: float = 0.0
    """How far the middle of the rig lies from the box's centre, standard deviation per axis, metres."""
    out: Path | None = None
    """Folder to write map.md, map.json and (extra: report) map.png into."""


@dataclass(frozen=True, kw_only=True)
class EvaluateReal:
    """Say what each policy would do next on real scans, why, and how far policies agree; nobody knows the truth there."""

    scans: tyro.conf.Positional[tuple[Path, ...]]
    """Scan files (docs/formats.md), and folders of them; what cannot be read in a folder is left out and named."""
    rig: str = "ring8"
    """Candidates: ring8, hemisphere12, ... (docs/rigs.md), or a TOML file."""
    policies: tuple[str, ...] = ("covariance", "expected")
    """Who decides: covariance, expected, network:FILE.onnx, combined:FILE.onnx; rehearsed, rehearsed:FILE.onnx (a minute or more
    for each scan)."""
    json: bool = False
    """One JSON object, one line, and nothing else on stdout."""
    out: Path | None = None
    """Folder to write real.md, real.json and (extra: report) a picture per scan into."""


@dataclass(frozen=True, kw_only=True)
class EvaluateTable2:
    """Say how often networks name the best position of a box, on boxes that train and on others: the paper's Table 2."""

    data: Path
    """Folder of a built set of boxes or recordings, with volume errors (viewgain dataset build ... --errors lines_published)."""
    models: tuple[str, ...] = ()
    """Networks of whole scans: .onnx files or shipped names; none for the floors alone."""
    target: str = "histogram:lines_published:soft"
    """What says which position is best: histogram:ESTIMATOR:OBJECTIVE, with +incidence, +border or both (docs/volume_nbv.md), or
    tally:4,3,2,2:SEED for one drawn label per box."""
    captures: int = 50
    """Test scans of each box and position that are judged, at most."""
    folds: int = 0
    """Choices of held-out boxes to train a network for, each anew; 0 for none."""
    leave: int = 3
    """Boxes that each choice holds out."""
    recipe: str = "volume_paper_short"
    """What is trained for each choice."""
    minutes: float = 2.0
    """How long each of those trains."""
    seed: int = 0
    """Of the intervals, and of the order of the choices."""
    json: bool = False
    """One JSON object per table, one line each, and nothing else on stdout."""
    out: Path | None = None
    """Folder to write table2.md and table2.json into, and the runs of the folds, which go on there."""


@dataclass(frozen=True, kw_only=True)
class EvaluateLabels:
    """Say which position of each box labels choose, with the constraints of time of flight and without, and what it is worth."""

    data: Path
    """Folder of a built set of boxes, with volume errors (viewgain dataset build ... --errors lines_published)."""
    targets: tuple[str, ...] = tuple(
        f"histogram:lines_published:soft{terms}" for terms in ("", "+incidence", "+border", "+incidence+border")
    )
    """Labels, as in training; the first is what the others are held against."""
    estimator: str = "lines_published"
    """Whose volume errors say what a position is worth."""
    seed: int = 0
    """Of the intervals."""
    json: bool = False
    """One JSON object, one line, and nothing else on stdout."""
    out: Path | None = None
    """Folder to write labels.md and labels.json into."""
