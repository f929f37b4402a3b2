"""Which rig a data set is of."""

from viewgain.datasets._manifest import Manifest
from viewgain.gain import COVERAGE_PROTOCOLS


def rig_of(manifest: Manifest) -> str:
    """Return the name of the rig that a data set was made with; ``irregular`` where each object has its own or none is named."""
    recipe = manifest.recipe
    if "coverage" in recipe:
        return COVERAGE_PROTOCOLS[recipe["coverage"]["protocol"]].rig
    return str(recipe.get("boxes", {}).get("rig", "irregular"))
