"""What a recipe says, as records: points, boxes, recordings, coverage, meshes. The defaults are stated where a field is."""

from dataclasses import dataclass, field
from typing import ClassVar, Literal, TypeAlias

from viewgain.datasets._sample import Frame
from viewgain.errors import ConfigError

Pair: TypeAlias = tuple[float, float]
"""Lowest and highest value of a uniform distribution."""
PointStorage: TypeAlias = Literal["quantised", "float16", "float32"]
"""How points lie on disk. ``quantised``: 16 bits per coordinate over the sample's own extent, 0.05 mm for 3 m."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PointRules:
    """How many points a sample keeps, where they are given and how they are stored."""

    frame: Frame = "camera"
    """Frame of the stored points."""
    cap: int = 4096
    """Scans with more points are thinned to so many at random; those with fewer keep all."""
    resample: int = 0
    """If over 0: every sample has exactly so many points instead, some twice where the scan has fewer."""
    storage: PointStorage = "quantised"
    """How they lie on disk."""

    def __post_init__(self) -> None:
        if self.frame not in ("camera", "object") or self.storage not in ("quantised", "float16", "float32"):
            raise ConfigError(
                f"points: got frame {self.frame!r} and storage {self.storage!r}, wanted known ones; see docs/data.md"
            )
        if self.cap < 1 or self.resample < 0:
            raise ConfigError(f"points: got cap {self.cap} and resample {self.resample}, wanted 1 or more, and 0 or more")


@dataclass(frozen=True, slots=True, kw_only=True)
class CoverageSettings:
    """Exact clouds of meshes from a published rig, and the coverage that each view adds."""

    kind: ClassVar[str] = "coverage"
    protocol: str = "paper"
    """A key of ``viewgain.gain.COVERAGE_PROTOCOLS``: rig, steps, surface points, reach, camera."""
    starts: int = 0
    """First views per mesh, drawn without repetition; 0 for every view of the rig."""
    steps: int = 0
    """Samples of each sequence of views: after 1, 2, ... of them; 0 for as many as the protocol has steps."""
    wander: float = 0.0
    """Chance at each step that the next view of the sequence is drawn at random among those not taken, instead of the best."""
    per_category: int = 40
    """Procedural objects per category, where no folder of meshes is given."""
    categories: tuple[str, ...] = ()
    """Only these; empty for all."""
    test_share: float = 0.2
    """Share of the categories (division by category) and of the meshes (division by mesh) that is kept for testing."""
    held_out: tuple[str, ...] = ()
    """Further categories that are the test part of the division by category, instead of a share that is drawn."""
    per_held_out: int = 40
    """Procedural objects in each of those."""
    masks: bool = True
    """Store which surface points each view covers, so that further targets need no rays."""

    def __post_init__(self) -> None:
        _check_counts("coverage", self.per_category, self.test_share)
        if self.steps < 0 or not 0 <= self.wander <= 1:
            raise ConfigError(f"coverage: got steps {self.steps} and wander {self.wander}, wanted 0 or more, and 0 to 1")
        if self.per_held_out < 1 or set(self.held_out) & set(self.categories) or (self.held_out and not self.categories):
            raise ConfigError("coverage: wanted categories beside held_out, none in both, and per_held_out of 1 or more")


@dataclass(frozen=True, slots=True, kw_only=True)
class BoxSettings:
    """Boxes on a floor, scanned many times from each station of a rig."""

    kind: ClassVar[str] = "boxes"
    sizes: tuple[tuple[float, float, float], ...] = ()
    """Side lengths of each box, metres; empty to draw them."""
    count: int = 0
    """How many boxes to draw, where no sizes are given."""
    side: Pair = (0.1, 0.6)
    """Drawn side lengths, metres."""
    yaw_deg: Pair = (0.0, 0.0)
    """Turn of the box about the vertical, degrees."""
    rig: str = "paper4"
    """Stations; ``irregular`` draws a rig for each box."""
    views: tuple[int, int] = (4, 8)
    """Least and most stations of an irregular rig."""
    captures: int = 1000
    """Scans from each station, each with the rig's jitter drawn anew."""
    captures_per_unit: int = 250
    """Scans of one station that are one unit of work. The bits of a scan do not depend on it."""
    train_captures: int = 700
    """Of the division ``same_box``: the first so many scans of each station train, the others test."""
    test_boxes: int = 0
    """Of the division ``other_box``: the last so many boxes test."""
    cameras: tuple[str, ...] = ("pico_flexx",)
    """Camera presets or files; one is drawn for each box."""
    noise: tuple[float, ...] = (1.0,)
    """Factors on the camera's noise; one is drawn for each box."""
    systematic: bool = False
    """Draw a systematic range error for the camera of each box, from what calibration leaves."""
    without: tuple[str, ...] = ()
    """Effects of the camera to leave out (docs/simulating.md)."""
    boxes: tuple[int, int] = (1, 1)
    """Least and most boxes in a scene, the one to look at included."""
    clutter: tuple[int, int] = (0, 0)
    """Least and most procedural objects around."""
    walls: tuple[int, int] = (0, 0)
    """Least and most walls."""
    reflectivity: Pair = (0.5, 0.5)
    """Share of light that each body gives back."""
    expected: bool = False
    """Store what each station is expected to be worth for the volume, worked out from the true box without a scan: targets
    ``volume_alone`` and ``volume_fused`` (docs/volume_nbv.md)."""

    def __post_init__(self) -> None:
        if bool(self.sizes) == bool(self.count):
            raise ConfigError("boxes: wanted either the sizes of the boxes or a count of boxes to draw")
        if min((min(size) for size in self.sizes), default=1.0) <= 0 or not 0 < self.side[0] <= self.side[1]:
            raise ConfigError("boxes: wanted positive side lengths, and side = [low, high]")
        if self.captures < 1 or self.captures_per_unit < 1 or not self.cameras or not self.noise or min(self.noise) < 0:
            raise ConfigError("boxes: wanted captures, captures_per_unit, cameras and noise of at least one each, none negative")
        if not 0 <= self.train_captures <= self.captures or not 0 <= self.test_boxes <= self.number:
            raise ConfigError(f"boxes: wanted train_captures up to {self.captures} and test_boxes up to {self.number}")
        if self.views[0] < 1 or self.views[0] > self.views[1] or self.boxes[0] < 1:
            raise ConfigError("boxes: wanted views = [least, most] and boxes = [least, most] of 1 or more")

    @property
    def number(self) -> int:
        """How many boxes there are."""
        return len(self.sizes) or self.count


@dataclass(frozen=True, slots=True, kw_only=True)
class RecordedSettings:
    """Scans of real boxes, in folders by box and position."""

    kind: ClassVar[str] = "recorded"
    train_share: float = 0.7
    """Of the division ``same_box``: share of the scans of each position that train, drawn at random."""
    test_boxes: int = 1
    """Of the division ``other_box``: the last so many boxes, by name, test. Folders of one size in ``boxes.toml`` are one box."""
    camera: str = ""
    """Camera preset or file, for the estimators; empty where not known."""

    def __post_init__(self) -> None:
        if not 0 <= self.train_share <= 1 or self.test_boxes < 0:
            raise ConfigError("recorded: wanted a train_share from 0 to 1, and test_boxes of 0 or more")


@dataclass(frozen=True, slots=True, kw_only=True)
class MeshSettings:
    """Meshes on a floor, scanned by a real camera from irregular rigs, and the coverage that each station would add."""

    kind: ClassVar[str] = "meshes"
    views: tuple[int, int] = (4, 12)
    """Least and most stations."""
    diagonal: Pair = (0.2, 0.8)
    """Diagonal of the bounding box, metres."""
    cameras: tuple[str, ...] = ("pico_flexx",)
    """Camera presets or files; one is drawn for each mesh."""
    noise: tuple[float, ...] = (1.0,)
    """Factors on the camera's noise; one is drawn for each mesh."""
    without: tuple[str, ...] = ()
    """Effects of the camera to leave out."""
    reach: float = 0.01
    """A surface point is covered if a point lies this near, in diagonals of the mesh."""
    surface_points: int = 4096
    """Points drawn on the surface."""
    per_category: int = 40
    """Procedural objects per category, where no folder of meshes is given."""
    categories: tuple[str, ...] = ()
    """Only these; empty for all."""
    test_share: float = 0.2
    """Share of the categories, and of the meshes, kept for testing."""
    masks: bool = True
    """Store which surface points each station covers."""

    def __post_init__(self) -> None:
        _check_counts("meshes", self.per_category, self.test_share)
        if not 1 <= self.views[0] <= self.views[1] or not 0 < self.diagonal[0] <= self.diagonal[1] or self.reach <= 0:
            raise ConfigError("meshes: wanted views and diagonal as [low, high], and a positive reach")
        if not self.cameras or not self.noise or min(self.noise) < 0 or self.surface_points < 1:
            raise ConfigError("meshes: wanted a camera, a noise factor and a surface point at least")


Content: TypeAlias = CoverageSettings | BoxSettings | RecordedSettings | MeshSettings
"""What a data set is made of."""
CONTENTS: dict[str, type[Content]] = {each.kind: each for each in (CoverageSettings, BoxSettings, RecordedSettings, MeshSettings)}
"""By the kind that a recipe file names."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Recipe:
    """A whole recipe."""

    name: str
    """Shipped name, or the stem of the file."""
    makes: str
    """What comes out, in a sentence."""
    takes: str = "not measured"
    """How long it takes, as measured."""
    seed: int = 0
    """Source of all randomness."""
    units_per_shard: int = 1
    """Units of work that are stored together. It changes the files, not the samples."""
    points: PointRules = field(default_factory=PointRules)
    """Points of each sample."""
    content: Content
    """What is scanned."""

    def __post_init__(self) -> None:
        if self.seed < 0 or self.units_per_shard < 1:
            raise ConfigError(f"recipe {self.name}: wanted a seed of 0 or more and units_per_shard of 1 or more")


def _check_counts(kind: str, per_category: int, test_share: float) -> None:
    if per_category < 1 or not 0 <= test_share < 1:
        raise ConfigError(f"{kind}: got per_category {per_category}, test_share {test_share}; wanted 1 or more, and 0 to under 1")
