"""From a run to an ONNX file with its card: what it was trained on and how, and what it was worth on objects it had not seen."""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from viewgain.datasets import record
from viewgain.errors import TrainingError
from viewgain.gain import POSITION_LIMITS
from viewgain.inference import Metric, ModelCard, Source
from viewgain.network import export_onnx
from viewgain.training._load import Trained, load_trained
from viewgain.training._settings import TrainingRecipe

VOLUME_TASK = (
    "How well a box's volume would be measured from each candidate view, from one scan: minus the expected |relative error|, or"
    " the share of a histogram of errors that lies near zero (see target)."
)
"""What the scores of networks for volume mean."""
TASK = "How much of an object's surface each of the rig's views would newly cover, from the partial cloud seen so far."
"""What the scores mean."""
LIMITS = (
    "One object alone, without floor or walls around it, of the kinds it was trained on.",
    "Trained on clouds without noise; the candidate views are those of its rig and no others.",
)
"""What a network of coverage is not for."""
FROM_ONE_VIEW = (
    "The cloud of one scan, as its pixels sample it: by that it tells from where it was seen. Of several scans joined, or of a"
    " cloud whose density a filter has evened out, it may take a wrong view for the present one."
)
"""What one is not for that has to find out the present view."""
VOLUME_LIMITS = (
    "A box that stands on a floor in view; of several the one that the candidates look at.",
    "Trained on simulated scans; what a view is worth was worked out from the true box, without what hides it from there.",
)
"""What a network of volumes is not for."""
COUNTED_LIMITS = (
    "A box that stands on a floor in view, from positions like those of its scans.",
    "What a view is worth was counted over scans of that very box: it need say nothing of boxes that were not trained on.",
)
"""What a network is not for whose targets were counted, or drawn, box by box."""


def export_run(
    run: Path, out: Path, *, sources: Sequence[Source] = (), metrics: Sequence[Metric] = (), limits: Sequence[str] | None = None
) -> ModelCard:
    """Write the best weights of a run as ONNX, with a card, and return the card.

    Standard deviations are multiplied by the ``sigma_ratio`` of the run's validation objects.

    Args:
        run: Folder of the run.
        out: File to write, .onnx.
        sources: Training data and its licences; none to name the data recipe, licence not stated.
        metrics: Figures beside those on the run's validation objects, for instance of an evaluation on other objects.
        limits: What it is not for; None for what holds of all networks of its task.

    Raises:
        TrainingError: If there is no run, or it has no sound best weights.
        ConfigError: If the weights do not fit half floats, or ``out`` is no .onnx file.
        MissingExtraError: If onnx is not installed.
    """
    trained = load_trained(run)
    card = card_of(trained, sources, metrics, limits)
    ratio = trained.figures.get("sigma_ratio", 1.0)
    export_onnx(trained.module, trained.record.recipe.network, card, out, sigma_scale=ratio)
    return card


def read_metrics(path: Path) -> tuple[Metric, ...]:
    """Return the figures of a JSON file: a list of objects with the fields of :class:`viewgain.inference.Metric`.

    Raises:
        TrainingError: If it cannot be read as such a list.
    """
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        return tuple(record(Metric, each, f"{path}, figure {number}") for number, each in enumerate(content))
    except (OSError, ValueError, TypeError) as error:
        raise TrainingError(f"{path}: cannot be read as a list of figures ({error})") from error


def card_of(
    trained: Trained, sources: Sequence[Source] = (), metrics: Sequence[Metric] = (), limits: Sequence[str] | None = None
) -> ModelCard:
    """Return the card of a trained network; arguments as :func:`export_run`."""
    recipe, facts = trained.record.recipe, trained.record.facts
    network = recipe.network
    return ModelCard(
        name=recipe.name,
        task=TASK if recipe.data.target.startswith("gain") else VOLUME_TASK,
        kind=network.kind,
        rig=str(facts["rig"]),
        views=network.views,
        points=network.points,
        frame=recipe.data.frame,
        normalisation="metres" if recipe.data.whole_scan else "whole_box",
        within=recipe.data.within,
        order="rig" if network.with_view_state else "present_first",
        with_view_state=network.with_view_state,
        uncertainty=network.uncertainty != "none",
        trained_on=tuple(sources) or (_source(facts),),
        training=_training(trained),
        metrics=(*_validation(trained), *metrics),
        limits=tuple(limits if limits is not None else _limits(recipe)),
    )


def _limits(recipe: TrainingRecipe) -> tuple[str, ...]:
    data, network = recipe.data, recipe.network
    if not data.whole_scan:
        return (*LIMITS, FROM_ONE_VIEW) if network.rig and not network.with_view_state else LIMITS
    return COUNTED_LIMITS if data.target.startswith(("histogram:", "tally:")) else VOLUME_LIMITS


def _source(facts: Any) -> Source:
    counts = facts["training"]
    return Source(
        name=f"data recipe {facts['data_recipe']}",
        licence="not stated",
        amount=f"{counts['objects']:,} objects, {counts['samples']:,} samples",
    )


def _training(trained: Trained) -> dict[str, str]:
    recipe, facts = trained.record.recipe, trained.record.facts
    taught = {} if recipe.distil is None else {"teacher": f"{facts['teacher']['name']}, weight {recipe.distil.weight:g}"}
    ratio = trained.figures.get("sigma_ratio")
    scaled = f"{recipe.network.uncertainty}, standard deviations times {ratio or 1:.3g}, as the validation objects showed"
    return {
        "recipe": recipe.name,
        "data": f"recipe {facts['data_recipe']}, seed {facts.get('data_seed', 'not noted')}, plan {trained.record.plan[:12]}",
        **taught,
        **({} if ratio is None else {"uncertainty": scaled}),
        "target": recipe.data.target,
        "steps": f"{trained.figures['step']} of {recipe.training.iterations}, batch {recipe.training.batch}",
        "seed": str(recipe.training.seed),
        "device": str(facts["device_name"] or facts["device"]),
        "versions": ", ".join(f"{name} {value}" for name, value in facts["versions"].items() if value),
    }


def _validation(trained: Trained) -> tuple[Metric, ...]:
    """Return the figures on the run's validation objects, which chose the weights and so flatter them a little."""
    figures, floors = trained.figures, trained.record.facts["floors"]
    split = f"{trained.record.facts['validation']['objects']} validation objects, which chose the weights"
    names = {"exact": "exact position"} | {f"within_{limit}": f"within {limit} of the best view" for limit in POSITION_LIMITS[1:]}
    return tuple(
        Metric(
            name=words,
            split=split,
            value=100 * figures[name],
            floors={floor: 100 * shares[name] for floor, shares in floors.items()},
            unit="%",
        )
        for name, words in names.items()
    )
