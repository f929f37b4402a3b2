"""The page: every text and number of an episode laid out for the template, and the template filled in."""

from collections.abc import Mapping
from importlib.resources import files

import jinja2
import numpy as np

from viewgain.episodes import Episode
from viewgain.report import _words as words
from viewgain.report._embedded import overview_picture
from viewgain.report._section import error_text, section
from viewgain.report._truth import compared, true_dimensions
from viewgain.report._units import MILLIMETRES, signed_percent, volume_unit


def render_page(episode: Episode, pngs: Mapping[str, bytes]) -> bytes:
    """Return the page as UTF-8 HTML.

    Args:
        episode: The run.
        pngs: Name and content of every picture.
    """
    environment = jinja2.Environment(autoescape=True, undefined=jinja2.StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    template = environment.from_string((files("viewgain.report") / "page.html.j2").read_text(encoding="utf-8"))
    page = template.render(
        summary=_summary(episode),
        overview=overview_picture(pngs),
        sections=[section(episode, index, pngs) for index in range(len(episode.steps))],
        setting=_setting(episode),
    )
    return page.encode()


def _summary(episode: Episode) -> dict[str, object]:
    """Return what stands at the top: how many views, the result, the truth, and why it ended."""
    measured, truth = episode.steps[-1].fused, episode.world.box
    unit, rows = volume_unit(truth.volume), compared(measured, truth)
    true_size = " × ".join(MILLIMETRES.number(side) for side in true_dimensions(truth))
    cards = [(row, unit if row.name == "Volume" else MILLIMETRES) for row in rows]
    return {
        "title": f"{'A box' if rows else 'No box'} measured in {words.views_in_words(len(episode.steps))}",
        "why": words.why_it_ended(episode),
        "truth": f"{true_size} mm, {unit.number(truth.volume)} {unit.name}",
        "measured": bool(rows),
        "reason": words.reason_in_words(measured.reason),
        "cards": [{"name": row.name, "text": words.plus_minus(row, own), "error": error_text(row, own)} for row, own in cards],
        "volume": words.plus_minus(rows[3], unit) if rows else "",
        "error": words.off_truth(rows[3]) if rows and not rows[3].is_open else "",
    }


def _setting(episode: Episode) -> dict[str, str]:
    """Return the terms of the run, among them what the planner did not know."""
    world, plan = episode.world, episode.steps[0].plan
    metres, radians = world.pose_sigma
    arrival = f"off by {MILLIMETRES.number(metres)} mm and {np.rad2deg(radians):.2f}° per axis (standard deviation)"
    return {
        "Camera": world.sensor.name,
        "Rig": plan.rig,
        "Policy": plan.policy,
        "Asked for": f"volume right to ±{100 * plan.tolerance:g} % with probability {plan.confidence:g}",
        "Where the camera arrives": arrival,
        "Hidden range error": f"scale {signed_percent(world.scale)}, offset {MILLIMETRES.signed(world.offset)} mm",
    }
