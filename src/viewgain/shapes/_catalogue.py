"""The categories by name, and making one object of them."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from viewgain.errors import ConfigError
from viewgain.meshes import TriangleMesh
from viewgain.shapes._airplane import airplane
from viewgain.shapes._assemble import Parts, assemble
from viewgain.shapes._boat import boat
from viewgain.shapes._bottle import bottle
from viewgain.shapes._dice import Dice
from viewgain.shapes._drill import drill
from viewgain.shapes._guitar import guitar
from viewgain.shapes._hammer import hammer
from viewgain.shapes._house import house
from viewgain.shapes._lamp import lamp
from viewgain.shapes._motorbike import motorbike
from viewgain.shapes._mug import mug
from viewgain.shapes._plant import plant
from viewgain.shapes._road import bus, car
from viewgain.shapes._seating import bench, chair, sofa
from viewgain.shapes._skateboard import skateboard
from viewgain.shapes._storage import bookshelf, cabinet
from viewgain.shapes._tables import bed, table
from viewgain.shapes._teapot import teapot
from viewgain.shapes._tower import tower
from viewgain.shapes._vase import vase
from viewgain.shapes._wrench import wrench


@dataclass(frozen=True, slots=True)
class Category:
    """A kind of object: how it is built, and between which sizes it comes out."""

    build: Callable[[Dice], Parts]
    """The recipe; its docstring gives the distributions."""
    lowest: tuple[float, float, float]
    """Extents along x, y, z that its objects keep above, metres; those of 8,000 draws with a margin of 5 %."""
    highest: tuple[float, float, float]
    """Extents that they keep below, likewise."""


CATEGORIES: Mapping[str, Category] = MappingProxyType(
    {
        "chair": Category(chair, (0.36, 0.36, 0.38), (0.8, 0.78, 1.21)),
        "table": Category(table, (0.47, 0.47, 0.36), (1.22, 2.12, 0.85)),
        "bench": Category(bench, (0.287, 0.85, 0.38), (0.66, 2.2, 1.04)),
        "sofa": Category(sofa, (0.68, 0.49, 0.59), (1.75, 3.4, 0.99)),
        "bed": Category(bed, (1.82, 0.8, 0.62), (2.42, 2.15, 2.28)),
        "cabinet": Category(cabinet, (0.33, 0.47, 0.52), (0.79, 2.02, 2.3)),
        "bookshelf": Category(bookshelf, (0.209, 0.47, 0.76), (0.56, 1.62, 2.21)),
        "lamp": Category(lamp, (0.119, 0.105, 0.238), (1.58, 1.14, 1.99)),
        "car": Category(car, (3.3, 1.77, 1.13), (5.4, 2.28, 1.96)),
        "bus": Category(bus, (5.2, 2.13, 2.46), (20.9, 3.4, 4.8)),
        "motorbike": Category(motorbike, (1.71, 0.54, 0.82), (2.51, 0.91, 1.61)),
        "skateboard": Category(skateboard, (0.52, 0.157, 0.095), (1.16, 0.28, 0.236)),
        "airplane": Category(airplane, (5.8, 5.6, 0.88), (47.0, 47.0, 12.9)),
        "boat": Category(boat, (2.37, 0.84, 0.43), (63.0, 12.1, 27.2)),
        "bottle": Category(bottle, (0.045, 0.0285, 0.133), (0.191, 0.117, 0.4)),
        "vase": Category(vase, (0.041, 0.042, 0.142), (0.71, 0.59, 0.83)),
        "mug": Category(mug, (0.053, 0.049, 0.071), (0.24, 0.194, 0.206)),
        "teapot": Category(teapot, (0.135, 0.076, 0.084), (0.42, 0.193, 0.4)),
        "hammer": Category(hammer, (0.252, 0.086, 0.0246), (1.01, 0.47, 0.095)),
        "wrench": Category(wrench, (0.133, 0.0129, 0.0046), (0.57, 0.132, 0.076)),
        "drill": Category(drill, (0.176, 0.044, 0.151), (0.48, 0.168, 0.256)),
        "guitar": Category(guitar, (0.049, 0.176, 0.52), (0.155, 0.51, 1.18)),
        "house": Category(house, (4.9, 5.7, 3.0), (13.9, 20.5, 15.6)),
        "tower": Category(tower, (3.1, 3.2, 12.5), (20.1, 26.2, 73.0)),
        "plant": Category(plant, (0.095, 0.089, 0.076), (1.32, 1.33, 1.56)),
    }
)
"""Every category by its name: furniture, vehicles, vessels and tools and an instrument, then buildings and plants."""


def procedural(category: str, *, rng: np.random.Generator) -> TriangleMesh:
    """Return a new object of a category, drawn from ``rng``: standing on z = 0, front towards +x, metres.

    It has 80 to 6,500 triangles. Its parts are closed, wound outwards and share no vertices; they may run through
    each other. The same state of ``rng`` gives the same bits.

    Raises:
        ConfigError: If there is no such category.
    """
    if category not in CATEGORIES:
        raise ConfigError(f"got the category {category!r}, wanted one of: {', '.join(sorted(CATEGORIES))}")
    return assemble(CATEGORIES[category].build(Dice(rng)), f"procedural/{category}")


def random_object(*, rng: np.random.Generator) -> TriangleMesh:
    """Return an object of a category that is itself drawn uniformly."""
    return procedural(tuple(CATEGORIES)[rng.integers(len(CATEGORIES))], rng=rng)
