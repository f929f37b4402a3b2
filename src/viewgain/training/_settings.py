"""What a training recipe says, as records. The defaults of :class:`TrainingSettings` are the published values.

Sources: Pop and Tamas, section on training (Adam's rate, batch, decay, weight of the L2 term); Zeng et al. 2020, public script
(400,000 iterations at most, 512 points).
"""

from dataclasses import dataclass, field
from typing import Literal, TypeAlias

from viewgain.datasets import Frame
from viewgain.errors import ConfigError
from viewgain.network import LossSettings, NetworkSettings

Schedule: TypeAlias = Literal["steps", "cosine", "cosine_clock", "constant"]
"""How the learning rate falls."""
Watched: TypeAlias = Literal["loss", "exact", "within_0.05"]
"""What decides which weights are the best."""


@dataclass(frozen=True, slots=True, kw_only=True)
class DataSettings:
    """Which samples, and how they are shown to the network."""

    recipe: str = ""
    """Data recipe that is built into the run's folder where no data set is given; empty to ask for one."""
    rig: str = ""
    """Rig that the data must be of; empty for any with as many views as the network has."""
    frame: Frame = "object"
    """Frame that the points are shown in, whichever the data set has them in."""
    target: str = "gain_published"
    """Which scores of the data set are learned; also ``histogram:ESTIMATOR:OBJECTIVE`` of stored volume errors, with
    terms (``+incidence+border``) or without, or ``tally:4,3,2,2:SEED`` (``viewgain.datasets.with_target``)."""
    divisions: tuple[str, ...] = ()
    """Learn from what is in part ``train`` of each of these divisions; empty to learn from all samples."""
    validation_share: float = 0.1
    """Share of the objects that are kept out of training to watch it; whole objects, drawn with the seed."""
    validate_on: Literal["objects", "samples"] = "objects"
    """What that share is of. ``samples`` of objects that train too: then the figures measure memory, as on the paper's boxes."""
    without: tuple[int, ...] = ()
    """Numbers of objects that are left out of everything."""
    resident: int = 1024
    """Points of each sample that are held in memory, as half floats; every step draws the network's number of them anew."""
    symmetry: bool = False
    """Show each sample turned and mirrored at random, by those motions about the vertical that carry the rig onto itself; the
    scores move with the views, so they stay right. Refused where the rig has no such motion."""
    vacant: int = 0
    """With symmetry: also by motions that carry up to so many views to where none stands. What is then seen from the places left
    vacant is not known, and nothing is learned of them."""
    whole_scan: bool = False
    """Clouds are whole scans in metres, as the camera measured them, instead of objects scaled to their box; the card says so."""
    within: float = 0.0
    """Of whole scans only what lies within so many metres of what the camera looks at (``viewgain.inference.around_middle``), by
    which a small box gets more of the network's points; 0 for all. The card says so."""
    turn_deg: float = 0.0
    """For networks that are told the candidates' poses: turn the present camera's axes at random by up to so much, points and
    poses alike; what a candidate sees stays the same."""
    mirror: bool = False
    """For the same networks: mirror half of the samples left to right, scene and cameras alike."""
    jitter: float = 0.0
    """Standard deviation of normal noise on every coordinate, in units of the data."""
    dropout: float = 0.0
    """Points are hidden with a share that is drawn for each cloud between 0 and this."""

    def __post_init__(self) -> None:
        if not 0 < self.validation_share < 1 or self.resident < 1:
            raise ConfigError(
                f"data: got validation_share {self.validation_share} and resident {self.resident}, wanted one between 0 and 1 and"
                " one of 1 or more"
            )
        if not 0 <= self.turn_deg <= 180 or (self.whole_scan and self.frame != "camera"):
            raise ConfigError("data: wanted a turn_deg of 0 to 180, and whole scans in the camera frame only")
        if not 0 <= self.within < float("inf") or (self.within and not self.whole_scan):
            raise ConfigError(f"data: got within = {self.within}, wanted 0 or more metres, and whole_scan = true with it")
        if self.vacant < 0 or (self.vacant and not self.symmetry):
            raise ConfigError(f"data: got vacant = {self.vacant}, wanted 0 or more, and symmetry = true with it")
        if self.jitter < 0 or not 0 <= self.dropout < 1:
            raise ConfigError(f"data: got jitter {self.jitter}, dropout {self.dropout}; wanted 0 or more, and 0 to under 1")


@dataclass(frozen=True, slots=True, kw_only=True)
class TrainingSettings:
    """How the weights are found."""

    iterations: int = 400_000
    """Steps at most (public script of PC-NBV)."""
    batch: int = 32
    """Samples per step, over all processes (paper)."""
    learning_rate: float = 1e-4
    """Of Adam, at its highest (paper)."""
    schedule: Schedule = "steps"
    """steps: times :attr:`decay` every :attr:`decay_every` steps (paper). cosine: down to nothing at the last step. cosine_clock:
    the same by the clock, where a time limit is given; such a run cannot be repeated to the bit. constant: as it is."""
    decay: float = 0.7
    """Factor of schedule ``steps`` (paper)."""
    decay_every: int = 50_000
    """Steps between two decays (paper)."""
    warm_up: int = 0
    """Steps over which the rate rises from nothing."""
    clip: float = 0.0
    """Largest norm of the gradient; 0 for no limit."""
    average: float = 0.0
    """Weights that are judged and exported are a running average, with this share kept per step; 0 for the weights themselves."""
    precision: Literal["float32", "bfloat16"] = "float32"
    """Of the forward pass."""
    seed: int = 0
    """Source of all randomness."""
    log_every: int = 50
    """Steps between two lines of metrics. The clock is looked at only then."""
    validate_every: int = 1000
    """Steps between two looks at the validation objects; a multiple of :attr:`log_every`."""
    checkpoint_minutes: float = 5.0
    """Time between two checkpoints; 0 for one with every line of metrics."""
    patience: int = 0
    """Stop after so many validations without a better one; 0 for never."""
    watched: Watched = "loss"
    """What a better one is."""

    def __post_init__(self) -> None:
        if min(self.iterations, self.batch, self.decay_every, self.log_every, self.validate_every) < 1:
            raise ConfigError("training: wanted iterations, batch, decay_every, log_every and validate_every of 1 or more")
        if self.validate_every % self.log_every:
            raise ConfigError(
                f"training: got validate_every {self.validate_every}, wanted a multiple of log_every, which is {self.log_every}"
            )
        if not 0 < self.learning_rate < float("inf") or not 0 < self.decay <= 1 or not 0 <= self.average < 1:
            raise ConfigError("training: wanted a positive learning_rate, decay over 0 and up to 1, average from 0 to under 1")
        if min(self.warm_up, self.clip, self.seed, self.checkpoint_minutes, self.patience) < 0:
            raise ConfigError("training: wanted warm_up, clip, seed, checkpoint_minutes and patience of 0 or more")


@dataclass(frozen=True, slots=True, kw_only=True)
class DistilSettings:
    """A teacher whose scores are learned beside the labels, or in their place."""

    teacher: str
    """A network file (.onnx) or shipped name, or the folder of a run, whose best weights then compute where the student does."""
    weight: float = 0.5
    """Share of the loss that is against the teacher's scores; the rest is against the labels. 1 for the teacher alone."""
    temperature: float | None = None
    """Of the listwise ranking loss against the teacher's scores; none to take that of the loss."""

    def __post_init__(self) -> None:
        if not self.teacher or not 0 < self.weight <= 1 or (self.temperature is not None and not self.temperature > 0):
            raise ConfigError(
                f"distil: got teacher {self.teacher!r}, weight {self.weight}, temperature {self.temperature}; wanted a teacher, a"
                " weight over 0 and up to 1, and a temperature over 0 or none"
            )


@dataclass(frozen=True, slots=True, kw_only=True)
class TrainingRecipe:
    """A whole recipe."""

    name: str
    """Shipped name, or the stem of the file."""
    makes: str
    """What comes out, in a sentence."""
    network: NetworkSettings
    """What is trained."""
    data: DataSettings = field(default_factory=DataSettings)
    """On what."""
    training: TrainingSettings = field(default_factory=TrainingSettings)
    """How."""
    loss: LossSettings = field(default_factory=LossSettings)
    """What is made small."""
    distil: DistilSettings | None = None
    """Who teaches beside the labels, if anybody."""

    def __post_init__(self) -> None:
        kind, uncertainty, with_poses = self.network.kind, self.network.uncertainty, self.network.with_poses
        losses = ("mean", "half_sum") if uncertainty == "none" else (uncertainty,)
        misfits = (
            (
                self.loss.kind not in losses,
                f"a loss of kind {self.loss.kind!r} for a network of uncertainty {uncertainty!r}, wanted {' or '.join(losses)}",
            ),
            (
                self.loss.presence_weight > 0 and kind != "compact",
                f"a presence_weight for a network of kind {kind}, which does not say from where a cloud was seen; wanted compact,"
                " or presence_weight = 0",
            ),
            (
                with_poses and self.data.symmetry,
                f"symmetry for a network of kind {kind}, which knows no rig; wanted mirror and turn_deg",
            ),
            (
                not with_poses and (self.data.mirror or self.data.turn_deg > 0),
                f"mirror or turn_deg for a network of kind {kind}, which is not told poses; wanted symmetry, or neither",
            ),
            (
                self.network.rig != "" and (self.data.frame, self.data.rig) != ("object", self.network.rig),
                f"views that look from {self.network.rig} for data of rig {self.data.rig!r} in the frame of the"
                f" {self.data.frame}, wanted the same rig and the frame of the object",
            ),
            (
                with_poses and self.data.within > 0,
                f"within for a network of kind {kind}, whose candidates look at the whole scan; wanted within = 0",
            ),
            (with_poses and self.distil is not None, f"a teacher for a network of kind {kind}, which knows no rig; drop distil"),
        )
        for is_so, misfit in misfits:
            if is_so:
                raise ConfigError(f"training recipe {self.name}: got {misfit}")
