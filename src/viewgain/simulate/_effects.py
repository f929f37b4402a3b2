"""What a real depth camera does to a perfect one, each switchable."""

from dataclasses import dataclass, fields, replace

from viewgain.errors import ConfigError


@dataclass(frozen=True, slots=True, kw_only=True)
class Effects:
    """Which effects are on. Each draws from a stream of its own, so switching one leaves the others' draws as they are."""

    noise: bool = True
    """Range noise that grows with distance, incidence and darkness."""
    jitter: bool = True
    """Pixels look in a slightly wrong direction, also within a surface (0 in the presets)."""
    lateral: bool = True
    """Depth edges appear displaced, pixel by pixel."""
    mixing: bool = True
    """A pixel integrates over its footprint: flying pixels at depth edges."""
    multipath: bool = True
    """Light that comes by way of one other surface (time of flight only)."""
    loss: bool = True
    """No return at grazing incidence and from surfaces too dark or too far for the camera's light."""
    wiggle: bool = True
    """The periodic range error that calibration leaves."""
    wrap: bool = True
    """Ranges beyond the unambiguous one come back as near ones."""
    quantisation: bool = True
    """Ranges are rounded to the camera's step."""
    filtering: bool = True
    """The camera's own filter against flying pixels."""

    def without(self, *names: str) -> "Effects":
        """Return the same with some effects switched off.

        Raises:
            ConfigError: If a name is not one of the fields; the message lists them.
        """
        return replace(self, **dict.fromkeys(_known(names), False))

    @classmethod
    def only(cls, *names: str) -> "Effects":
        """Return nothing but the named effects; no name for a perfect camera.

        Raises:
            ConfigError: If a name is not one of the fields; the message lists them.
        """
        return cls(**{name: name in _known(names) for name in EFFECTS})


ALL_EFFECTS = Effects()
"""Everything that a real camera does."""
EFFECTS = tuple(field.name for field in fields(Effects))
"""Names of the effects."""


def _known(names: tuple[str, ...]) -> tuple[str, ...]:
    unknown = set(names) - set(EFFECTS)
    if unknown:
        raise ConfigError(f"effect {sorted(unknown)[0]!r} is not known; choose from {', '.join(EFFECTS)}")
    return names


NO_EFFECTS = Effects.only()
"""A perfect camera."""
