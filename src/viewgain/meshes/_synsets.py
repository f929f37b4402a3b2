"""The names of ShapeNetCore's categories, which its folders give as WordNet numbers."""

import json
from pathlib import Path

from viewgain.errors import ConfigError
from viewgain.meshes._file import one_line, printable

SYNSETS = {
    "02691156": "airplane",
    "02747177": "trash bin",
    "02773838": "bag",
    "02801938": "basket",
    "02808440": "bathtub",
    "02818832": "bed",
    "02828884": "bench",
    "02843684": "birdhouse",
    "02871439": "bookshelf",
    "02876657": "bottle",
    "02880940": "bowl",
    "02924116": "bus",
    "02933112": "cabinet",
    "02942699": "camera",
    "02946921": "can",
    "02954340": "cap",
    "02958343": "car",
    "02992529": "cellphone",
    "03001627": "chair",
    "03046257": "clock",
    "03085013": "keyboard",
    "03207941": "dishwasher",
    "03211117": "display",
    "03261776": "earphone",
    "03325088": "faucet",
    "03337140": "file cabinet",
    "03467517": "guitar",
    "03513137": "helmet",
    "03593526": "jar",
    "03624134": "knife",
    "03636649": "lamp",
    "03642806": "laptop",
    "03691459": "loudspeaker",
    "03710193": "mailbox",
    "03759954": "microphone",
    "03761084": "microwave",
    "03790512": "motorbike",
    "03797390": "mug",
    "03928116": "piano",
    "03938244": "pillow",
    "03948459": "pistol",
    "03991062": "pot",
    "04004475": "printer",
    "04074963": "remote control",
    "04090263": "rifle",
    "04099429": "rocket",
    "04225987": "skateboard",
    "04256520": "sofa",
    "04330267": "stove",
    "04379243": "table",
    "04401088": "telephone",
    "04460130": "tower",
    "04468005": "train",
    "04530566": "vessel",
    "04554684": "washer",
}
"""Of ShapeNetCore; the names of PC-NBV's sixteen classes are those of its paper."""


def synset_names(root: Path) -> dict[str, str]:
    """Return the name of each number: those of ``taxonomy.json`` in ``root``, its first word each, over the built-in ones.

    Raises:
        ConfigError: If there is a ``taxonomy.json`` that cannot be read.
    """
    file = root / "taxonomy.json"
    if not file.is_file():
        return SYNSETS
    try:
        listed = {str(one["synsetId"]): str(one["name"]).partition(",")[0].strip() for one in json.loads(file.read_bytes())}
    except (OSError, ValueError, TypeError, KeyError, RecursionError) as error:
        raise ConfigError(
            printable(
                f"{file}: cannot be read as a list of synsetId and name ({one_line(error)});"
                " take the file of ShapeNetCore, or remove it to use the built-in names"
            )
        ) from error
    return SYNSETS | {number: name for number, name in listed.items() if name}
