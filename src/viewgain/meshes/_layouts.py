"""How folders of meshes are laid out: where the categories are, where the meshes in them, and what either is called."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from viewgain.errors import ConfigError, MeshError
from viewgain.meshes._entry import MeshEntry
from viewgain.meshes._file import printable
from viewgain.meshes._read import CHECKS
from viewgain.meshes._synsets import synset_names

_PARTS = ("train", "test")


@dataclass(frozen=True, slots=True)
class Layout:
    """One way to lay a folder out."""

    pattern: str
    """As told to the user."""
    entries: Callable[[Path], Iterator[MeshEntry]]


def find_entries(root: Path, layout: str) -> tuple[str, tuple[MeshEntry, ...]]:
    """Return the layout of a folder and what is in it, sorted; ``layout`` "auto" takes the only one that fits.

    Links are followed to a fixed depth and each folder of a category is entered once, so links in a circle do no harm.

    Raises:
        ConfigError: If there is no such layout, or several fit.
        MeshError: If the folder is missing or cannot be read, or holds no mesh where the layout has them.
    """
    if layout != "auto" and layout not in LAYOUTS:
        raise ConfigError(f"layout: got {layout!r}, wanted one of auto, {', '.join(LAYOUTS)}")
    if not root.is_dir():
        raise MeshError(printable(f"{root}: is not a folder" if root.exists() else f"{root}: no such folder; check the path"))
    tried = {layout: LAYOUTS[layout]} if layout != "auto" else LAYOUTS
    try:
        found = {name: tuple(sorted(one.entries(root), key=_order)) for name, one in tried.items()}
    except OSError as error:
        place = error.filename or root
        raise MeshError(printable(f"{place}: cannot be read ({error.strerror}); check its permissions")) from error
    found = {name: entries for name, entries in found.items() if entries}
    if len(found) == 1:
        return found.popitem()
    if found:
        counts = ", ".join(f"{len(entries)} as {name} ({LAYOUTS[name].pattern})" for name, entries in found.items())
        raise ConfigError(printable(f"{root}: holds meshes in several layouts: {counts}; name one with layout="))
    looked = ", ".join(f"{one.pattern} ({name})" for name, one in tried.items())
    raise MeshError(printable(f"{root}: holds no meshes; looked for {looked}, .ext being one of {' '.join(CHECKS)}"))


def _order(entry: MeshEntry) -> tuple[str, str, str, str]:
    return entry.category, entry.name, entry.part or "", str(entry.path)


def _seen(folder: Path) -> Iterator[Path]:
    """Yield what is in a folder, sorted, hidden things left out."""
    return iter(sorted(path for path in folder.iterdir() if not path.name.startswith(".")))


def _folders(root: Path) -> Iterator[Path]:
    """Yield the categories: each real folder once, under its own name rather than a link's, and never the root itself."""
    entered = {root.resolve()}
    folders = [path for path in _seen(root) if path.is_dir()]
    for path in sorted(folders, key=lambda path: (path.is_symlink(), path.name)):
        if path.resolve() not in entered:
            entered.add(path.resolve())
            yield path


def _meshes(folder: Path, *extensions: str) -> Iterator[Path]:
    return (path for path in _seen(folder) if path.suffix.lower() in extensions and path.is_file())


def _plain(root: Path) -> Iterator[MeshEntry]:
    for category in _folders(root):
        for path in _meshes(category, *CHECKS):
            yield MeshEntry(category=category.name, name=path.stem, path=path)


def _shapenet(file: str) -> Callable[[Path], Iterator[MeshEntry]]:
    def entries(root: Path) -> Iterator[MeshEntry]:
        models = [(category, model) for category in _folders(root) for model in _seen(category) if (model / file).is_file()]
        names = synset_names(root) if models else {}
        for category, model in models:
            yield MeshEntry(category=names.get(category.name, category.name), name=model.name, path=model / file)

    return entries


def _modelnet(root: Path) -> Iterator[MeshEntry]:
    for category in _folders(root):
        for part in _PARTS:
            if (category / part).is_dir():
                for path in _meshes(category / part, ".off"):
                    yield MeshEntry(category=category.name, name=path.stem, path=path, part=part)


LAYOUTS = {
    "folder": Layout("<category>/<name>.ext", _plain),
    "shapenet1": Layout("<synset>/<model>/model.obj", _shapenet("model.obj")),
    "shapenet2": Layout("<synset>/<model>/models/model_normalized.obj", _shapenet("models/model_normalized.obj")),
    "modelnet": Layout("<category>/train|test/<name>.off", _modelnet),
}
"""The layouts that a folder can have, by the name that the user gives."""
