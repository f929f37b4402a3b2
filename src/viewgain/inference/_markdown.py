"""A model card as a page for people."""

from viewgain.inference._card import POSE_KIND, Metric, ModelCard

RULES = {
    "whole_box": "the bounding box of the whole object",
    "seen_box": "the bounding box of the points",
}
ORDERS = {
    "present_first": "the present view first, then the others in the order of the rig",
    "rig": "in the order of the rig",
}


def to_markdown(card: ModelCard) -> str:
    """Return the card as Markdown: use, input, training, figures, limits."""
    told = "and which views were visited" if card.with_view_state else "and nothing else: no camera pose"
    cloud = "a whole scan" if card.normalisation == "metres" else "the object without its floor"
    rig = f"rig `{card.rig}`, {card.views} views; scores come {ORDERS[card.order]}"
    if card.kind == POSE_KIND:
        told = "and the candidates' poses in the present camera"
        rig = f"any; trained on rig `{card.rig}`; scores come in the order in which they are given"
    lines = [
        f"# {card.name}",
        "",
        card.task,
        "",
        f"- Network: `{card.kind}`, {card.parameters:,} parameters, stored as half floats, computed in single precision",
        f"- Candidate views: {rig}",
        f"- Input: {card.points} points of {cloud}, {told}",
        f"- {_normalisation(card)}",
        f"- Clouds of more points are thinned ({card.sampling}), of fewer are padded with a mask",
        f"- Each score comes {'with' if card.uncertainty else 'without'} a standard deviation",
        f"- Licence of the weights: {card.licence}",
        "",
        "## Training",
        "",
        *([f"- Data: {each.name}, {each.licence}. {each.amount}".strip() for each in card.trained_on] or ["- Data: not said"]),
        *[f"- {key}: {value}" for key, value in card.training.items()],
        "",
        "## Figures",
        "",
        *_figures(card.metrics),
        "",
        "## Limits",
        "",
        *([f"- {limit}" for limit in card.limits] or ["- Not said."]),
    ]  # fmt: skip
    return "\n".join(lines) + "\n"


def _normalisation(card: ModelCard) -> str:
    if card.normalisation == "metres":
        near = f", points within {card.within:g} m of what the camera looks at" if card.within else ""
        return f"Frame: the present camera (x right, y down, z forward), metres{near}"
    box = RULES[card.normalisation]
    if card.frame == "object":
        return f"Frame: the object's (z up). The centre of {box} goes to the origin, its diagonal becomes 1"
    return (
        f"Frame: the present camera (x right, y down, z forward). {box[0].upper()}{box[1:]} is scaled to diagonal 1 and its"
        f" centre moved onto the axis, {card.distance:g} ahead"
    )


def _figures(metrics: tuple[Metric, ...]) -> list[str]:
    if not metrics:
        return ["None yet."]
    rows = ["| what | on | figure | 95 % interval | without learning |", "|---|---|---|---|---|"]
    for metric in metrics:
        interval = "" if metric.interval is None else f"{metric.interval[0]:.4g} to {metric.interval[1]:.4g}"
        floors = ", ".join(f"{name} {value:.4g}" for name, value in metric.floors.items())
        rows.append(f"| {metric.name} | {metric.split} | {metric.value:.4g} {metric.unit} | {interval} | {floors} |")
    return rows
