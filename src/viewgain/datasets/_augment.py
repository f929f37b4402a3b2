"""Augmentation: what may be changed about a sample without changing its answer. Every draw comes from an explicit generator."""

from dataclasses import dataclass, replace

import numpy as np

from viewgain.datasets._sample import Sample
from viewgain.errors import ConfigError
from viewgain.geometry import inverse, pose, rotation_from_rotvec, transform


@dataclass(frozen=True, slots=True, kw_only=True)
class Augmentation:
    """How far samples are changed; nothing by default."""

    turn_deg: float = 0.0
    """In frame camera: roll of the present camera, uniform up to this either way, degrees; the candidates' poses follow. In frame
    object: turn of the object about its vertical; the candidates stay where they are, seen from the camera."""
    jitter: float = 0.0
    """Standard deviation of normal noise on every coordinate, metres."""
    dropout: float = 0.0
    """Points are dropped with a share that is uniform between 0 and this."""

    def __post_init__(self) -> None:
        if self.turn_deg < 0 or self.jitter < 0 or not 0 <= self.dropout < 1:
            raise ConfigError("augmentation: wanted turn_deg and jitter of 0 or more, and a dropout of 0 to under 1")

    def apply(self, sample: Sample, *, rng: np.random.Generator) -> Sample:
        """Return a changed sample. The same four streams are drawn whatever the settings are."""
        turn, drop = rng.uniform(-1, 1), rng.random()
        keep, noise = rng.random(len(sample.points)), rng.standard_normal(sample.points.shape)
        kept = keep >= self.dropout * drop if self.dropout else np.ones(len(keep), dtype=bool)
        points = (sample.points + self.jitter * noise)[kept]
        motion = pose(rotation_from_rotvec(np.array([0.0, 0.0, np.deg2rad(self.turn_deg) * turn])), np.zeros(3))
        points = transform(motion, points).astype(sample.points.dtype)
        if sample.frame == "object":
            return replace(sample, points=points, object_to_camera=sample.object_to_camera @ inverse(motion))
        return replace(
            sample, points=points, candidates=motion @ sample.candidates, object_to_camera=motion @ sample.object_to_camera
        )


NO_AUGMENTATION = Augmentation()
"""Samples as they are."""
