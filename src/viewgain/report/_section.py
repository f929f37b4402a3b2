"""One step of an episode as the page shows it: sentences and two tables, every number already a text."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from viewgain.box import Box
from viewgain.episodes import Episode, Step
from viewgain.measure import Measurement
from viewgain.plan import Candidate, NextView
from viewgain.report import _words as words
from viewgain.report._embedded import Picture, view_pictures
from viewgain.report._truth import Compared, compared
from viewgain.report._units import MILLIMETRES, Unit, percent, probability, signed_percent, volume_unit
from viewgain.report._wire import reported_box


@dataclass(frozen=True, slots=True, kw_only=True)
class Section:
    """One step of the episode."""

    number: int
    """Of the view, from 1."""
    source: str
    """Where the scan came from."""
    measured: str
    """What is known after it, one sentence."""
    rows: tuple[dict[str, object], ...]
    """The table of dimensions; empty if nothing was measured."""
    flags: tuple[tuple[str, str], ...]
    """Name and explanation of each flag."""
    remarks: tuple[str, ...]
    """Sentences about the measurement."""
    stop: str
    """Whether the volume is known well enough."""
    decision: str
    """Why the winner won."""
    candidates: tuple[dict[str, object], ...]
    """The table of candidates, the winner first."""
    pictures: tuple[Picture, Picture]
    """The range image and the view in space."""


def section(episode: Episode, index: int, pngs: Mapping[str, bytes]) -> Section:
    """Return the section of step ``index``, from 0."""
    step, truth, last = episode.steps[index], episode.world.box, index == len(episode.steps) - 1
    unit, rows = volume_unit(truth.volume), compared(step.fused, truth)
    flags = step.fused.boxes[0].flags if step.fused.boxes else ()
    foretold = words.foretold_sentence(episode.steps[index - 1].plan, step.fused, unit) if index else None
    return Section(
        number=index + 1,
        source=step.scan.source,
        measured=words.measured_sentence(step.fused, rows, index + 1, unit),
        rows=tuple(_row(row, unit if row.name == "Volume" else MILLIMETRES) for row in rows),
        flags=tuple((flag, words.FLAGS.get(flag, "")) for flag in flags),
        remarks=(*_remarks(step, truth), *([foretold] if foretold else []), *step.fused.notes),
        stop=words.stop_sentence(step.plan, moved=not last),
        decision=words.decision_sentence(step.plan, unit, moved=not last),
        candidates=_candidates(step.plan, unit),
        pictures=view_pictures(pngs, index + 1, rows, step.plan),
    )


def error_text(row: Compared, unit: Unit) -> str:
    """Return how far an estimate is off, absolute and relative; a lower bound has no error."""
    if row.is_open:
        return "lower bound"
    return f"{unit.signed(row.value - row.true)} {unit.name} ({signed_percent(row.relative_error)})"


def _remarks(step: Step, truth: Box) -> list[str]:
    boxes, advice = step.fused.boxes, words.advice(step.fused.reason)
    found = [words.faces_sentence(boxes[0])] if boxes else []
    if boxes and _is_other_box(step.fused, truth):
        found.append("Attention: this box stands elsewhere than the true one; another box was taken for it.")
    if len(boxes) > 1:
        found.append(f"{len(boxes)} boxes were measured; table and plan are about the one with the most returns.")
    if not boxes and step.fused.rejected:
        found.append("The plan takes the largest object for a box of unknown size; −y then names the side that faces the camera.")
    return [*found, advice] if advice and not boxes else found


def _is_other_box(measurement: Measurement, truth: Box) -> bool:
    """Return whether the measured box stands beside the true one rather than in its place."""
    centre = reported_box(measurement.boxes[0]).in_frame(measurement.world).centre
    return float(np.linalg.norm(centre - truth.centre)) > 0.75 * float(truth.extents.max())


def _row(row: Compared, unit: Unit) -> dict[str, object]:
    return {
        "name": f"{row.name} (upright)" if row.upright else row.name,
        "value": f"{'≥ ' if row.is_open else ''}{unit.number(row.value)}",
        "sigma": "–" if row.sigma is None or row.is_open else unit.finer().number(row.sigma),
        "interval": f"{unit.number(row.low)} to {'∞' if row.high is None else unit.number(row.high)}",
        "unit": unit.name,
        "basis": row.basis or "–",
        "true": unit.number(row.true),
        "error": error_text(row, unit),
        "covered": row.covered,
    }


def _candidates(plan: NextView, unit: Unit) -> tuple[dict[str, object], ...]:
    ranked = sorted(plan.candidates, key=lambda c: (c.index != plan.best, not c.reachable, -c.assessment.score))
    return tuple(_candidate(plan, candidate, unit) for candidate in ranked)


def _candidate(plan: NextView, candidate: Candidate, unit: Unit) -> dict[str, object]:
    after = candidate.assessment.outlook
    return {
        "index": candidate.index,
        "best": candidate.index == plan.best,
        "move": words.move_in_words(plan, candidate),
        "faces": "–" if candidate.assessment.prediction is None else words.faces_in_words(candidate),
        "sigma": "–" if after is None else f"{unit.finer().number(after.volume_sigma)} {unit.name}",
        "chance": probability(None if after is None else after.within_tolerance),
        "score": f"{candidate.assessment.score:.3f}" if after is None else percent(candidate.assessment.score),
        "reachable": candidate.reachable,
    }
