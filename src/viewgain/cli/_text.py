"""Results as tables and sentences for a terminal. Degrees and millimetres appear here, at the edge, and nowhere deeper."""

import numpy as np
from rich.console import Console
from rich.table import Table

from viewgain.measure import REASONS, BoxEstimate, Measurement
from viewgain.plan import MODEL, NEARLY, NextView, directions_in_words

NAMES = ("length", "width", "height")


def to_stdout(table: Table) -> None:
    """Print a table, at least 100 columns wide when the output is not a terminal."""
    console = Console()
    if not console.is_terminal:
        console = Console(width=120)
    console.print(table)


def measurement_table(result: Measurement) -> Table:
    """Return the boxes of a measurement, one row per dimension and one for the volume."""
    table = Table(title=" + ".join(result.scans), title_justify="left", title_style="bold")
    for column in ("box", "quantity", "value", "± sigma", "90 % interval", "how"):
        table.add_column(column, justify="right" if column in ("value", "± sigma") else "left")
    if not result.boxes:
        table.add_row("none", result.reason or "", "", "", "", REASONS.get(result.reason or "", ""))
    for index, box in enumerate(result.boxes):
        _add_box(table, index, box)
    return table


def _add_box(table: Table, index: int, box: BoxEstimate) -> None:
    for k, name in enumerate(NAMES):
        low, high = box.interval90[k]
        table.add_row(
            str(index) if k == 0 else "",
            f"{name}{' (vertical)' if k == box.vertical else ''}",
            f"{'>= ' if box.basis[k] == 'open' else ''}{1000 * box.dimensions[k]:.1f} mm",
            "open" if box.sigma[k] is None else f"{1000 * (box.sigma[k] or 0):.1f} mm",
            f"{1000 * low:.1f} to {'?' if high is None else f'{1000 * high:.1f}'} mm",
            box.basis[k],
        )
    low, high = box.volume_interval90
    table.add_row(
        "",
        "volume",
        f"{'>= ' if any(box.is_open) else ''}{1000 * box.volume:.2f} l",
        "open" if box.volume_sigma is None else f"{1000 * box.volume_sigma:.2f} l",
        f"{1000 * low:.2f} to {'?' if high is None else f'{1000 * high:.2f}'} l",
        f"flags: {', '.join(box.flags) or 'none'}",
        end_section=True,
    )


def decider_in_words(plan: NextView) -> str:
    """Return in a sentence who decided where nobody was named, and why."""
    if plan.policy == MODEL:
        return "Decided by the model: every dimension is bounded, so the view that leaves the volume most certain wins."
    if not plan.current.boxes and not plan.current.rejected:
        return (
            "Decided by model and network together: nothing could be measured, so the view wins that is to err least of the boxes"
            " that would look like this and stand at the place."
        )
    if not plan.current.boxes and all(blob.estimate is None for blob in plan.current.rejected[:1]):
        return "Decided by the network: nothing could be measured, and it has seen what usually stands behind such a scan."
    return "Decided by model and network together: a dimension is open, so the view that is to err least wins."


def ranking_table(plan: NextView) -> Table:
    """Return the candidates of a plan, best first."""
    table = Table(title=f"next view, rig {plan.rig}, policy {plan.policy}", title_justify="left", title_style="bold")
    for column in (
        "view",
        "how to get there",
        "would see (incidence)",
        "sigma of volume",
        f"P(error < {100 * plan.tolerance:.3g}%)",
        "score",
    ):
        table.add_column(column, justify="right" if column.startswith(("sigma", "P(", "score")) else "left")
    for candidate in sorted(plan.candidates, key=lambda c: (c.index != plan.best, not c.reachable, -c.assessment.score)):
        after, prediction = candidate.assessment.outlook, candidate.assessment.prediction
        sights = [] if prediction is None else [s for s in prediction.sights if s.returns >= 25]
        seen = ", ".join(f"{s.name} {np.rad2deg(s.incidence):.0f}°" for s in sights) or ("" if prediction is None else "nothing")
        table.add_row(
            f"{candidate.index}{' *' if candidate.index == plan.best else ''}",
            plan_words(plan, candidate.index) if candidate.reachable else "out of reach",
            seen + (", cut" if prediction is not None and prediction.cut else ""),
            "" if after is None else f"{1000 * after.volume_sigma:.2f} l",
            "" if after is None else f"{after.within_tolerance:.3f}",
            f"{candidate.assessment.score:+.3f}",
        )
    return table


def plan_words(plan: NextView, index: int) -> str:
    """Return how to get to one candidate of a plan."""
    return directions_in_words(plan.candidates[index].camera_to_current, plan.target, plan.up)


def decision_in_words(plan: NextView) -> str:
    """Return the decision as one or two sentences."""
    chance = f"P(volume error < {100 * plan.tolerance:.3g}%) is {plan.within_tolerance or 0:.3f}"
    if plan.stop:
        return f"Stop: {chance}, over the {plan.confidence:.2f} asked for."
    if plan.abstention is not None:
        return f"No view is named: {plan.abstention}."
    if plan.best is None:
        return f"{chance}; no candidate of the rig can be reached."
    way, chosen = f"View {plan.best}: {plan_words(plan, plan.best)}", plan.candidates[plan.best].assessment
    if plan.objective == "coverage":
        return f"{way}. It scores highest for surface newly covered, {chosen.score:+.3f}. {chance}, which decides nothing here."
    known = f"under the {plan.confidence:.2f} asked for"
    if (plan.within_tolerance or 0) > plan.confidence:
        known = "but a dimension is open"
    gain = "" if chosen.outlook is None else f": that lifts it to {chosen.outlook.within_tolerance:.3f}"
    sure = "" if plan.nearly_best is None else (
        f" Chance that no other view is better by {100 * NEARLY:g} points of volume error: {100 * plan.nearly_best:.0f} %."
    )  # fmt: skip
    return f"{chance}, {known}. {way}{gain}.{sure}"
