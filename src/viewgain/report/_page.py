"""The page: every text and number of an episode laid out for the template, and the template filled in."""

import base64
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.resources import files

import jinja2
import numpy as np

from viewgain.episodes import Episode, Step
from viewgain.measure import Measurement
from viewgain.plan import Candidate, NextView
from viewgain.report import _words as words
from viewgain.report._truth import Compared, compared
from viewgain.report._units import MILLIMETRES, Unit, percent, probability, signed_percent, volume_unit
from viewgain.report._wire import reported_box


@dataclass(frozen=True, slots=True, kw_only=True)
class Picture:
    """One picture of the page."""

    file: str
    """Name of the file beside the page."""
    data: str
    """The same picture as a data URL."""
    alt: str
    """What it shows, for those who cannot see it."""
    caption: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Section:
    """One step of the episode."""

    number: int
    source: str
    measured: str
    """What is known after it, one sentence."""
    rows: tuple[dict[str, object], ...]
    """The table of dimensions; empty if nothing was measured."""
    remarks: tuple[str, ...]
    """Sentences about the measurement."""
    flags: tuple[tuple[str, str], ...]
    """Name and explanation of each flag."""
    stop: str
    decision: str
    candidates: tuple[dict[str, object], ...]
    """The table of candidates, the winner first."""
    pictures: tuple[Picture, ...]


def render_page(episode: Episode, pngs: Mapping[str, bytes]) -> bytes:
    """Return the page as UTF-8 HTML.

    Args:
        episode: The run.
        pngs: Name and content of every picture: ``dimensions.png``, ``view1_range.png``, ``view1_scene.png``, ...
    """
    environment = jinja2.Environment(autoescape=True, undefined=jinja2.StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    template = environment.from_string((files("viewgain.report") / "page.html.j2").read_text(encoding="utf-8"))
    unit = volume_unit(episode.world.box.volume)
    sections = [_section(episode, index, pngs, unit) for index in range(len(episode.steps))]
    overview = _picture(pngs, "dimensions.png", "Estimates of length, width, height and volume after each view, with 90 % intervals, beside the truth.", _overview_caption())  # fmt: skip
    return template.render(
        summary=_summary(episode, unit), overview=overview, sections=sections, setting=_setting(episode)
    ).encode()


def _summary(episode: Episode, unit: Unit) -> dict[str, object]:
    last, truth = episode.steps[-1], episode.world.box
    rows = compared(last.fused, truth)
    true_size = " × ".join(MILLIMETRES.number(side) for side in np.sort(truth.extents)[::-1])
    views = "1 view" if len(episode.steps) == 1 else f"{len(episode.steps)} views"
    return {
        "views": views,
        "done": episode.stopped,
        "why": words.why_it_ended(episode),
        "truth": f"{true_size} mm, {unit.number(truth.volume)} {unit.name}",
        "measured": bool(rows),
        "reason": words.reason_in_words(last.fused.reason),
        "dimensions": [
            {"name": row.name, "text": words.plus_minus(row, MILLIMETRES), "error": _error(row, MILLIMETRES)} for row in rows[:3]
        ],
        "volume": words.plus_minus(rows[3], unit) if rows else "",
        "error": words.off_truth(rows[3]) if rows and not rows[3].is_open else "",
    }


def _setting(episode: Episode) -> dict[str, str]:
    """Return the terms of the run, among them what the planner did not know."""
    world, plan = episode.world, episode.steps[0].plan
    metres, radians = world.pose_sigma
    return {
        "Camera": world.sensor.name,
        "Rig": plan.rig,
        "Policy": plan.policy,
        "Asked for": f"volume right to ±{percent(plan.tolerance, 0)} with probability {plan.confidence:g}",
        "Where the camera arrives": f"off by {MILLIMETRES.number(metres)} mm and {np.rad2deg(radians):.2f}° per axis (standard deviation)",
        "Hidden range error": f"scale {signed_percent(world.scale)}, offset {MILLIMETRES.signed(world.offset)} mm",
    }


def _section(episode: Episode, index: int, pngs: Mapping[str, bytes], unit: Unit) -> Section:
    step, number, last = episode.steps[index], index + 1, index == len(episode.steps) - 1
    rows = compared(step.fused, episode.world.box)
    flags = step.fused.boxes[0].flags if step.fused.boxes else ()
    before = episode.steps[index - 1].plan if index else None
    return Section(
        number=number,
        source=step.scan.source,
        measured=words.measured_sentence(step.fused, rows, number, unit),
        rows=tuple(_row(row, unit if row.name == "Volume" else MILLIMETRES) for row in rows),
        remarks=_remarks(episode, step, before, unit),
        flags=tuple((flag, words.FLAGS.get(flag, "")) for flag in flags),
        stop=words.stop_sentence(step.plan, moved=not last),
        decision=words.decision_sentence(step.plan, unit, moved=not last),
        candidates=_candidates(step.plan, unit),
        pictures=_pictures(step, rows, number, pngs),
    )


def _remarks(episode: Episode, step: Step, before: NextView | None, unit: Unit) -> tuple[str, ...]:
    found = [words.faces_sentence(step.fused.boxes[0])] if step.fused.boxes else []
    if step.fused.boxes and _is_other_box(step.fused, episode):
        found.append("Attention: this box stands elsewhere than the true one; the planner has taken another box for it.")
    if len(step.fused.boxes) > 1:
        found.append(
            f"{len(step.fused.boxes)} boxes were measured; the table is about the one with the most returns, which the plan is for."
        )
    if not step.fused.boxes and step.fused.rejected:
        found.append("The plan takes the largest object for a blob of unknown size; names of faces then refer to it as the camera sees it (−y is the front).")  # fmt: skip
    if not step.fused.boxes and (advice := words.advice(step.fused.reason)):
        found.append(advice)
    if before is not None and (foretold := words.foretold_sentence(before, step.fused, unit)):
        found.append(foretold)
    return (*found, *step.fused.notes)


def _is_other_box(measurement: Measurement, episode: Episode) -> bool:
    """Return whether the measured box stands beside the true one rather than in its place."""
    truth = episode.world.box
    centre = reported_box(measurement.boxes[0]).in_frame(measurement.world).centre
    return float(np.linalg.norm(centre - truth.centre)) > 0.75 * float(truth.extents.max())


def _row(row: Compared, unit: Unit) -> dict[str, object]:
    bounded = row.sigma is not None and not row.is_open
    return {
        "name": f"{row.name} (upright)" if row.upright else row.name,
        "value": f"{'≥ ' if row.is_open else ''}{unit.number(row.value)}",
        "sigma": unit.finer().number(row.sigma) if bounded and row.sigma is not None else "–",
        "interval": f"{unit.number(row.low)} to {'∞' if row.high is None else unit.number(row.high)}",
        "unit": unit.name,
        "basis": row.basis or "–",
        "true": unit.number(row.true),
        "error": _error(row, unit),
        "covered": row.covered,
    }


def _error(row: Compared, unit: Unit) -> str:
    return (
        "lower bound"
        if row.is_open
        else f"{unit.signed(row.value - row.true)} {unit.name} ({signed_percent(row.relative_error)})"
    )


def _candidates(plan: NextView, unit: Unit) -> tuple[dict[str, object], ...]:
    ranked = sorted(plan.candidates, key=lambda c: (c.index != plan.best, not c.reachable, -c.assessment.score))
    return tuple(_candidate(plan, candidate, unit) for candidate in ranked)


def _candidate(plan: NextView, candidate: Candidate, unit: Unit) -> dict[str, object]:
    after = candidate.assessment.outlook
    return {
        "index": candidate.index,
        "best": candidate.index == plan.best,
        "move": words.move_in_words(plan, candidate),
        "faces": words.faces_in_words(candidate) if candidate.assessment.prediction is not None else "–",
        "sigma": "–" if after is None else f"{unit.finer().number(after.volume_sigma)} {unit.name}",
        "chance": probability(None if after is None else after.within_tolerance),
        "score": f"{candidate.assessment.score:.3f}" if after is None else percent(candidate.assessment.score),
        "reachable": candidate.reachable,
    }


def _pictures(step: Step, rows: tuple[Compared, ...], number: int, pngs: Mapping[str, bytes]) -> tuple[Picture, ...]:
    fitted = f"the fitted box of {words.size(rows)}" if rows else "no fitted box"
    winner = "no candidate is chosen" if step.plan.best is None else f"candidate {step.plan.best} is ringed as the best next view"
    return (
        _picture(pngs, f"view{number}_range.png", f"Range image of view {number} with {fitted} and, dashed, the true box.",
                 "What the camera measured. The true box is drawn where the camera believes to be, so it may be off by its pose error."),
        _picture(pngs, f"view{number}_scene.png", f"View {number} in space: returns, {fitted} and {len(step.plan.candidates)} candidate cameras; {winner}.",
                 "The same scan in space with the cameras that the plan compared; their numbers are those of the table."),
    )  # fmt: skip


def _overview_caption() -> str:
    return "What is known after each view. An arrow is an end that lies outside the panel or that nothing bounds."


def _picture(pngs: Mapping[str, bytes], file: str, alt: str, caption: str) -> Picture:
    data = "data:image/png;base64," + base64.b64encode(pngs[file]).decode()
    return Picture(file=file, data=data, alt=alt, caption=caption)
