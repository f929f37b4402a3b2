"""A program: the gradients of one step, by as many processes as the environment says; process 0 writes them.

Arguments: folder of the data set, file to write, ranking loss, kind of the loss.
"""

import sys
from pathlib import Path

import numpy as np
import torch
from safetensors.torch import save_file

from tests.training.conftest import changed
from viewgain.datasets import Dataset
from viewgain.training import Batches, Session, load_examples, ranks


def main(data: str, out: str, ranking: str, kind: str) -> None:
    torch.set_num_threads(1)
    recipe = changed(
        network={"kind": "compact_view"}, training={"batch": 8, "average": 0.0}, loss={"ranking": ranking, "kind": kind}
    )
    examples = load_examples(Dataset(Path(data)), recipe.data, views=16, seed=0)
    batches = Batches(
        examples, recipe.data, rows=np.arange(len(examples)), batch=8, points=recipe.network.points, uses_state=True, seed=1
    )
    group = ranks("cpu")
    try:
        session = Session(recipe, batches, device="cpu", ranks=group)
        session.advance(clock=0.0)
        if group.rank == 0:
            save_file({name: each.grad for name, each in session.model.named_parameters()}, out)
    finally:
        group.close()


if __name__ == "__main__":
    main(*sys.argv[1:])
