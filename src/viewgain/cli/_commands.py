"""The commands as dataclasses: the fields are the options, their docstrings the help."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Literal

import tyro

from viewgain.cli._deciding import Deciding

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
    """camera_to_world of each scan (JSON or text, 4x4), in the order of the scans; of all or of none."""
    camera: str | None = None
    """Camera preset (docs/cameras.md) or a TOML file, for noise and systematic error; default estimated from the scan."""
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
    """Join all scans into one estimate: by their poses if all have one, without poses by the boxes that they share."""
    method: Literal["likelihood", "lines", "corners"] = "likelihood"
    """likelihood has error bars; lines and corners are the paper's estimators, without any (docs/lines.md)."""
    as_published: bool = False
    """With lines or corners: as the public program does it, without our mends."""
    shape: Literal["box", "auto", "any"] = "box"
    """box: boxes only; auto: a box where it is one, else enclosing boxes and volumes; any: those for everything."""
    division: float | None = None
    """Scale division d, metres: also give dimensions rounded to the nearest d, and mark those under 12 d. No certification."""
    round_up: float | None = None
    """Then round them up to the next multiple of this, metres, as carriers do."""
    divisor: float | None = None
    """Also give the dimensional weight in kilograms: volume in cubic centimetres over this (5000 and 6000 are common)."""
    json: bool = False
    """One JSON object per result, one line each, and nothing else on stdout."""
    csv: bool = False
    """One CSV row per box, or per object with --shape auto or any."""


@dataclass(frozen=True, kw_only=True)
class Next:
    """Say where the camera should go next so that the volume becomes certain."""

    scans: Scans
    """Scan files; several are fused, with a pose each or none, and the last is the camera as it stands."""
    reading: Annotated[Reading, tyro.conf.arg(name="")] = field(default_factory=Reading)
    """How the files are read."""
    rig: str = "ring8"
    """Candidate poses: ring8, paper4, irregular4, pcnbv33, hemisphere20, ... (docs/rigs.md), or a TOML file of your own."""
    objective: Literal["volume", "coverage"] = "volume"
    """What to become certain of: the volume, or (with --policy network) the whole surface."""
    deciding: Annotated[Deciding, tyro.conf.arg(name="")] = field(default_factory=Deciding)
    """Who decides."""
    tolerance: float = 0.05
    """Relative volume error that is good enough."""
    confidence: float = 0.95
    """Stop when the error is under the tolerance with this probability."""
    place: tuple[float, float, float] | None = None
    """About where the box's centre is, X Y Z in metres in the world of the last scan's pose, z up: of a box that is put at a
    marked spot. It says how long a side may be that no scan shows, and what may stand there where nothing can be measured."""
    place_sigma: float | None = None
    """How exactly it is there, standard deviation per axis, metres; 0.1 where nothing is said."""
    json: bool = False
    """One JSON object, one line, and nothing else on stdout."""


@dataclass(frozen=True, kw_only=True)
class Calibrate:
    """Learn one camera's systematic range error from scans of a box of known size, and write the camera as a file."""

    scans: Scans
    """Scan files; views from several sides and distances tell scale from offset."""
    reading: Annotated[Reading, tyro.conf.arg(name="")] = field(default_factory=Reading)
    """How the files are read."""
    dims: tuple[float, float, float]
    """True sides of the box in any order, metres."""
    out: Path = Path("camera.toml")
    """Camera file to write; use it with --camera from then on."""
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


@dataclass(frozen=True, kw_only=True)
class Simulate:
    """Write simulated scans of a scene from every station of a rig, with the truth beside them."""

    out: Path
    """Folder for the scans and truth.json, without a recording in it."""
    scene: Literal["box", "random", "mesh", "object"] = "box"
    """A box on a floor; a random scene of boxes, walls and clutter; a mesh file; a procedural object."""
    dims: tuple[float, float, float] = (0.4, 0.3, 0.2)
    """Length, width and height of the box, metres (scene box)."""
    yaw: float = 0.0
    """Turn of the box or object about the vertical, degrees (not scene random)."""
    mesh: Path | None = None
    """Mesh file: PLY, OBJ, STL, GLB or OFF (scene mesh)."""
    category: str = "chair"
    """Kind of procedural object (scene object)."""
    size: float | None = None
    """Diagonal to scale the mesh or object to, metres; default its own size."""
    camera: str = "pico_flexx"
    """Camera preset (docs/cameras.md) or a TOML file."""
    rig: str = "ring8"
    """Stations: ring8, paper4, irregular4, pcnbv33, hemisphere20, ... (docs/rigs.md), or a TOML file."""
    elevation: float = 35.0
    """For the stations that leave it open, degrees."""
    distance: float = 1.2
    """For the stations that leave it open, metres from the centre."""
    captures: int = 1
    """Scans per station, each with the rig's jitter drawn anew."""
    frames: int = 1
    """Frames averaged per scan."""
    seed: int = 0
    """Source of all randomness: the same seed writes the same files."""
    reflectivity: float = 0.5
    """Share of light that the surfaces give back, over 0 and up to 1 (not scene random)."""
    without: tuple[str, ...] = ()
    """Effects to switch off: noise jitter lateral mixing multipath loss wiggle wrap quantisation filtering."""
    perfect: bool = False
    """A perfect camera standing exactly where it should."""
    systematic: bool = False
    """Draw this camera's systematic range error from what calibration leaves; default none."""
    formats: tuple[Literal["png", "npz", "ply"], ...] = ("png", "npz")
    """What to write of each scan; a PNG comes with its camera JSON."""
    by_station: bool = False
    """A folder for each station, as recordings are read (docs/recording.md); needs one format alone."""
    workers: int = 1
    """Processes to share the stations; the files are the same whatever the number."""


@dataclass(frozen=True, kw_only=True)
class DatasetBuild:
    """Build a data set, or what is missing of it."""

    recipe: tyro.conf.Positional[str]
    """Name of a shipped recipe (viewgain dataset recipes) or a TOML file (docs/data.md)."""
    out: Path
    """Folder of the data set."""
    meshes: Path | None = None
    """Folder of meshes by category (docs/meshes.md); default procedural ones."""
    recordings: Path | None = None
    """Folder of your own scans, box/position/files, for recipes that read them."""
    errors: tuple[str, ...] = ()
    """Then also the volume errors of every scan by these estimators: default, lines_published, lines_mended, ..."""
    seed: int | None = None
    """Source of all randomness; default the recipe's."""
    workers: int = 1
    """Processes; the files are the same whatever the number."""
    engine: Literal["local", "ray"] = "local"
    """Who does the work; the files are the same."""
    ray_address: str | None = None
    """Of a running Ray cluster: auto, host:port or ray://host:10001; default Ray is started on this machine."""
    resume: bool = False
    """Go on with what is in the folder; damaged shards are made anew."""


@dataclass(frozen=True, kw_only=True)
class DatasetRecipes:
    """List the shipped recipes: what each makes and how long it takes."""


@dataclass(frozen=True, kw_only=True)
class DatasetInfo:
    """Say what a data set holds."""

    folder: tyro.conf.Positional[Path]
    """Folder of the data set."""
    json: bool = False
    """One JSON object, one line."""


@dataclass(frozen=True, kw_only=True)
class DatasetVerify:
    """Read every byte of a data set and compare it with what was written."""

    folder: tyro.conf.Positional[Path]
    """Folder of the data set."""


@dataclass(frozen=True, kw_only=True)
class DatasetExport:
    """Write a folder that the Hugging Face tools load, with a card; nothing is uploaded."""

    folder: tyro.conf.Positional[Path]
    """Folder of the data set."""
    out: Path
    """Folder to write, empty or missing."""


@dataclass(frozen=True, kw_only=True)
class Dataset:
    """Training data from a recipe: build, list recipes, look, verify, export."""

    action: tyro.conf.OmitSubcommandPrefixes[
        Annotated[DatasetBuild, tyro.conf.subcommand("build")]
        | Annotated[DatasetRecipes, tyro.conf.subcommand("recipes")]
        | Annotated[DatasetInfo, tyro.conf.subcommand("info")]
        | Annotated[DatasetVerify, tyro.conf.subcommand("verify")]
        | Annotated[DatasetExport, tyro.conf.subcommand("export-hf")]
    ]
    """What to do."""
