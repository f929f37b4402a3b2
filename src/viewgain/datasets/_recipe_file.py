"""Recipes as TOML files: those that come with the package by name, and the user's own by path. What is read is checked."""

import tomllib
from collections.abc import Collection, Mapping
from dataclasses import fields
from importlib import resources
from pathlib import Path
from types import UnionType
from typing import Any, Literal, TypeVar, get_args, get_origin, get_type_hints

from viewgain.datasets._settings import CONTENTS, PointRules, Recipe
from viewgain.errors import ConfigError

T = TypeVar("T")
RECIPES = (
    *(
        f"{name}{tiny}"
        for name in ("coverage_paper", "coverage_pcnbv", "boxes_paper", "boxes_recorded", "boxes_random", "meshes_random")
        for tiny in ("", "_tiny")
    ),
    "boxes_paper_tenth",
    "boxes_recorded_paper",
    "coverage_learn_tiny",
    "coverage_table1",
    "coverage_nine",
    "coverage_pcnbv_learn",
    "volume_irregular",
    "volume_irregular_tiny",
    "volume_random",
    "volume_random_tiny",
)
"""Names of the recipes that come with the package."""
_WORDS = {float: "a number", int: "a whole number", str: "text", bool: "true or false", type(None): "nothing"}
"""What types are called in errors."""
_TOP = ("makes", "takes", "seed", "units_per_shard", "points", *CONTENTS)


def recipe(name: str | Path) -> Recipe:
    """Return a shipped recipe by name, or the recipe of a TOML file by its path (docs/data.md).

    Raises:
        ConfigError: If the name is none of :data:`RECIPES` and no readable recipe file; one line that names the key.
    """
    return recipe_from_table(*recipe_table(name, "recipe", RECIPES, "viewgain.datasets"))


def recipe_table(name: str | Path, kind: str, shipped: Collection[str], package: str) -> tuple[Mapping[str, Any], str]:
    """Return the table of a recipe file and the recipe's name.

    Args:
        name: A shipped name, or the path of a TOML file.
        kind: What errors call it.
        shipped: Names that come with the package.
        package: Whose folder ``recipes`` they lie in.

    Raises:
        ConfigError: If the name is not shipped and no readable TOML file.
    """
    if name in shipped:
        text = (resources.files(package) / "recipes" / f"{name}.toml").read_text(encoding="utf-8")
        return _parsed(text, f"{kind} {name}"), str(name)
    path = Path(name)
    if path.suffix != ".toml":
        raise ConfigError(f"{kind} {str(name)!r} is not known; choose one of {', '.join(shipped)}, or give a .toml file")
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, ValueError) as error:
        raise ConfigError(f"{path}: cannot be read as a {kind}: {error}") from error
    return _parsed(text, f"{kind} {path}"), path.stem


def recipe_from_table(table: Mapping[str, Any], name: str) -> Recipe:
    """Return the recipe that a table describes; JSON's lists and TOML's are the same to it.

    Raises:
        ConfigError: If a key is unknown or a value is not what its field is.
    """
    unknown = sorted(set(table) - set(_TOP))
    kinds = [kind for kind in CONTENTS if kind in table]
    if unknown or len(kinds) != 1:
        raise ConfigError(f"recipe {name}: got the keys {sorted(table)}, wanted one table of {', '.join(CONTENTS)}, and of the"
                          f" others only {', '.join(key for key in _TOP if key not in CONTENTS)}")  # fmt: skip
    where = f"recipe {name}"
    content = record(CONTENTS[kinds[0]], table[kinds[0]], f"{where}, {kinds[0]}")
    points = record(PointRules, table.get("points", {}), f"{where}, points")
    top = {key: value for key, value in table.items() if key in ("makes", "takes", "seed", "units_per_shard")}
    values = {key: _value(get_type_hints(Recipe)[key], value, f"{where}, {key}") for key, value in top.items()}
    if "makes" not in values:
        raise ConfigError(f"{where}: got no key makes, wanted a sentence about what comes out")
    return Recipe(name=name, content=content, points=points, **values)


def record(cls: type[T], table: object, where: str) -> T:
    """Return a dataclass of plain fields from a table of the same keys.

    Raises:
        ConfigError: If a key is unknown or missing, or a value is of another type.
    """
    if not isinstance(table, Mapping):
        raise ConfigError(f"{where}: got {table!r}, wanted a table")
    hints = get_type_hints(cls)
    known = [each.name for each in fields(cls)]  # type: ignore[arg-type]  # every caller gives a dataclass
    unknown = sorted(set(table) - set(known))
    if unknown:
        raise ConfigError(f"{where}: got unknown keys {unknown}, wanted {', '.join(known)}")
    try:
        return cls(**{key: _value(hints[key], value, f"{where}, {key}") for key, value in table.items()})
    except TypeError as error:  # a field without default is missing
        raise ConfigError(f"{where}: {error}") from error


def _parsed(text: str, where: str) -> Mapping[str, Any]:
    try:
        return tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        raise ConfigError(f"{where}: is not TOML: {error}") from error


def _value(hint: Any, value: object, where: str) -> Any:
    """Return a value as its field's type: whole numbers pass for floats, lists for tuples."""
    origin, inside = get_origin(hint), get_args(hint)
    if hint is Any:
        return value
    if origin is tuple and isinstance(value, list | tuple):
        each = [inside[0]] * len(value) if inside[-1] is Ellipsis else list(inside)
        if len(each) == len(value):
            return tuple(_value(kind, item, where) for kind, item in zip(each, value, strict=True))
    elif origin is UnionType:
        return None if value is None else _value(inside[0], value, where)
    elif origin is dict and isinstance(value, Mapping):
        return {str(key): _value(inside[1], item, where) for key, item in value.items()}
    elif origin is Literal and value in inside:
        return value
    elif hint is float and isinstance(value, int | float) and not isinstance(value, bool):
        return float(value)
    elif isinstance(hint, type) and origin is None:
        if hasattr(hint, "__dataclass_fields__"):
            return record(hint, value, where)
        if isinstance(value, hint) and (hint is bool or not isinstance(value, bool)):
            return value
    raise ConfigError(f"{where}: got {value!r}, wanted {_in_words(hint)}")


def _in_words(hint: Any) -> str:
    """Return what a field's type asks for, as the writer of a recipe would say it."""
    origin, inside = get_origin(hint), get_args(hint)
    if origin is tuple and inside[-1] is Ellipsis:
        return f"a list, of each {_in_words(inside[0])}"
    if origin is tuple:
        return f"a list of {len(inside)}: {', '.join(map(_in_words, inside))}"
    if origin is Literal:
        return f"one of {', '.join(map(str, inside))}"
    if origin is UnionType:
        return " or ".join(map(_in_words, inside))
    return _WORDS.get(hint, getattr(hint, "__name__", str(hint)))
