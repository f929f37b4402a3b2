"""The model card: what a network is for, how its input is made, what it learned from, how good it is. It travels in the file."""

import dataclasses
import json
import math
import types
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias, Union, get_args, get_origin, get_type_hints

from viewgain.errors import ModelError, one_line

CARD_SCHEMA = 1
"""Version of the JSON form; it grows by new keys only."""
POSE_KIND = "pose_scores"
"""The kind of networks that are told the candidates' poses; rig and order on their cards say only what they were trained on."""
FrameName: TypeAlias = Literal["object", "camera"]
"""Where points are given: in the object's own frame (z up, turned as in the data), or in the present camera (x right, y down)."""
Rule: TypeAlias = Literal["whole_box", "seen_box", "metres"]
"""Which bounding box sets centre and scale: that of the whole object, to be known or estimated; or that of the points.
``metres``: none, a whole scan is given as it was measured, with the floor."""
Sampling: TypeAlias = Literal["random", "farthest"]
"""How points are drawn where there are too many."""
Order: TypeAlias = Literal["present_first", "rig"]
"""Score k belongs to station (present view + k) mod V, or to station k."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Source:
    """One source of training data."""

    name: str
    """What it is, e.g. "procedural shapes, 52 categories"."""
    licence: str
    """Its licence, an SPDX identifier where there is one."""
    amount: str = ""
    """How much of it, in words."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Metric:
    """One measured figure with what makes it worth anything."""

    name: str
    """What was measured, e.g. "exact position"."""
    split: str
    """On what, e.g. "unseen categories"."""
    value: float
    """The figure."""
    interval: tuple[float, float] | None = None
    """95 % interval."""
    floors: dict[str, float] = dataclasses.field(default_factory=dict)
    """What answers without any learning get, by name, e.g. the constant answer."""
    unit: str = ""
    """Of the figure."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ModelCard:
    """All that has to be known to use a network rightly."""

    name: str
    """What it is called."""
    task: str
    """What its scores mean, in a sentence."""
    kind: str
    """Its architecture, a name of ``viewgain.network.Kind``."""
    rig: str
    """The candidate views, a name of :func:`viewgain.rigs.rig`; scores follow its order."""
    views: int
    """V, how many they are."""
    points: int = 512
    """Points that a cloud is thinned or padded to."""
    frame: FrameName = "object"
    """Where points are given."""
    normalisation: Rule = "whole_box"
    """Which bounding box is moved to the origin and scaled to diagonal 1."""
    distance: float = 1.0
    """Frame camera: the box's centre then stands on the camera's axis at this distance, in diagonals."""
    within: float = 0.0
    """Rule ``metres``: only points within so many metres of what the camera looks at (:func:`around_middle`); 0 for all."""
    sampling: Sampling = "random"
    """How points are drawn where there are more."""
    order: Order = "present_first"
    """Which station a score belongs to."""
    with_view_state: bool = False
    """Whether the network is told which stations were visited."""
    uncertainty: bool = False
    """Whether it gives a standard deviation with each score."""
    parameters: int = 0
    """How many numbers it has learned."""
    trained_on: tuple[Source, ...] = ()
    """The training data and its licences."""
    training: dict[str, str] = dataclasses.field(default_factory=dict)
    """How it was trained: recipe, steps, seed, time, versions."""
    metrics: tuple[Metric, ...] = ()
    """How good it is."""
    limits: tuple[str, ...] = ()
    """What it is not for, and where it fails."""
    licence: str = "Apache-2.0"
    """Of the weights."""

    def __post_init__(self) -> None:
        if min(self.views, self.points) < 1 or not self.distance > 0 or not self.name or not self.rig:
            raise ModelError(
                f"model card {self.name!r}: got {self.views} views, {self.points} points, distance {self.distance}, rig"
                f" {self.rig!r}; wanted a name, a rig, and positive numbers"
            )
        if not 0 <= self.within < math.inf or (self.within and self.normalisation != "metres"):
            raise ModelError(
                f"model card {self.name}: got within {self.within} with rule {self.normalisation!r}, wanted metres from 0 on, and"
                " rule metres where it is over 0"
            )
        if (self.order == "rig") != self.with_view_state:
            raise ModelError(
                f"model card {self.name}: got order {self.order!r} with_view_state={self.with_view_state}; wanted rig order with"
                " the view state and present_first without"
            )

    def to_json(self) -> str:
        """Return the card as one line of JSON."""
        return json.dumps({"schema": CARD_SCHEMA, **dataclasses.asdict(self)}, allow_nan=False)

    @classmethod
    def from_json(cls, text: str) -> "ModelCard":
        """Return the card of a JSON text; keys of later versions are passed over.

        Raises:
            ModelError: If it is no JSON object, a key is missing, or a value has the wrong type.
        """
        try:
            card: ModelCard = _record(cls, json.loads(text))
        except (ValueError, TypeError, KeyError, RecursionError) as error:
            raise ModelError(f"model card: cannot be read ({one_line(error)}); export the network again") from error
        return card


def _record(kind: type[Any], content: Any) -> Any:
    """Return a record from parsed JSON, every value checked against its annotation."""
    if not isinstance(content, Mapping):
        raise TypeError(f"{kind.__name__}: got {type(content).__name__}, wanted an object")
    hints = get_type_hints(kind)
    values = {}
    for field in dataclasses.fields(kind):
        if field.name in content:
            values[field.name] = _value(hints[field.name], content[field.name], field.name)
        elif field.default is dataclasses.MISSING and field.default_factory is dataclasses.MISSING:
            raise KeyError(f"{field.name} is missing")
    return kind(**values)


def _value(hint: Any, content: Any, name: str) -> Any:
    """Return one value, checked against its annotation: records, literals, tuples, dicts, unions with None, plain types."""
    origin, arguments = get_origin(hint), get_args(hint)
    if dataclasses.is_dataclass(hint):
        return _record(hint, content)  # type: ignore[arg-type]
    if origin is Literal and content in arguments:
        return content
    if origin in (Union, types.UnionType):
        return None if content is None else _value(arguments[0], content, name)
    if origin is tuple and isinstance(content, list):
        kinds = [arguments[0]] * len(content) if arguments[-1] is Ellipsis else arguments
        return tuple(_value(each, item, name) for each, item in zip(kinds, content, strict=True))
    if origin is dict and isinstance(content, Mapping):
        return {str(key): _value(arguments[1], item, name) for key, item in content.items()}
    if hint is float and isinstance(content, int | float) and not isinstance(content, bool):
        return float(content)
    if hint in (str, int, bool) and type(content) is hint:
        return content
    raise TypeError(f"{name}: got {content!r}")
