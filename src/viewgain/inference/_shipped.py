"""The networks that come with the package, by name."""

from pathlib import Path

from viewgain.errors import ModelError
from viewgain.inference._card import POSE_KIND

FOLDER = Path(__file__).parent / "weights"
"""Where they lie: ``NAME.onnx``, each with its card as ``NAME.md``."""
VOLUME_MODEL = f"{POSE_KIND}-irregular-camera"
"""The one that decides for the volume where none is named: trained on random rigs, for the candidates of any."""


def shipped_models() -> tuple[str, ...]:
    """Return the names of the networks in the package, sorted; KIND-RIG-FRAME."""
    return tuple(sorted(path.stem for path in FOLDER.glob("*.onnx")))


def model_name(kind: str, rig: str, frame: str) -> str:
    """Return the name that a shipped network of this kind, rig and frame has."""
    return f"{kind}-{rig}-{frame}"


def find_model(model: str | Path) -> Path:
    """Return the file of a shipped name, or the path itself where it ends in ``.onnx``.

    Raises:
        ModelError: If there is no such file or name.
    """
    path = Path(model)
    if path.suffix == ".onnx":
        if not path.is_file():
            raise ModelError(f"{path}: no such file; wanted a network made by viewgain export")
        return path
    shipped = FOLDER / f"{model}.onnx"
    if path.name != str(model) or not shipped.is_file():
        known = ", ".join(shipped_models()) or "none in this build"
        raise ModelError(f"network {str(model)!r} is not shipped (there are: {known}); give the path of an .onnx file")
    return shipped
