"""What happened in an episode, in sentences: measurements, flags, decisions and why it stopped."""

from viewgain.episodes import Episode
from viewgain.measure import REASONS, BoxEstimate, Measurement
from viewgain.plan import MODEL, Candidate, NextView, directions_in_words
from viewgain.report._truth import Compared
from viewgain.report._units import MILLIMETRES, Unit, percent, probability

FLAGS = {
    "cut": "The outline leaves the image or touches its border: a side that runs out of it may be longer than what is seen.",
    "open": "The scans do not bound every dimension: the open one is given as a lower bound.",
    "grazing": "A face is seen at more than 72° from head-on: its returns are few and noisy.",
    "bent": "A face is bent by more than 4 mm: a soft or bulging side, or light that bounced twice.",
    "few_points": "Fewer than 300 returns lie on the box: move closer.",
    "touching": "Another object touches the box: the border between them is inferred.",
    "flaps": "Something floats beside or over the top of the box, such as open flaps: close them.",
    "ambiguous": "Which sides correspond between the scans is open: the interval covers both readings.",
    "stacked": "The box stands on another one: its height counts from there.",
}
"""Every flag of a measurement, explained."""
NO_PLAN = {"no_reachable_view": "no candidate of the rig can be reached"}
"""Reasons of planning that measuring does not have."""


def size(rows: tuple[Compared, ...]) -> str:
    """Return length × width × height in millimetres."""
    return " × ".join(f"{'≥ ' if row.is_open else ''}{MILLIMETRES.number(row.value)}" for row in rows[:3]) + " mm"


def size_with_sigma(estimate: BoxEstimate) -> str:
    """Return the dimensions of a box in millimetres, each with its standard deviation or as a lower bound."""
    words = []
    for value, sigma, basis in zip(estimate.dimensions, estimate.sigma, estimate.basis, strict=True):
        number = MILLIMETRES.number(value)
        words.append(f"≥ {number}" if sigma is None or basis == "open" else f"{number} ± {MILLIMETRES.number(sigma)}")
    return " × ".join(words) + " mm"


def plus_minus(row: Compared, unit: Unit) -> str:
    """Return an estimate with its standard deviation, or as a lower bound."""
    if row.is_open or row.sigma is None:
        return f"at least {unit.number(row.value)} {unit.name}"
    return f"{unit.number(row.value)} ± {unit.number(row.sigma)} {unit.name}"


def off_truth(row: Compared) -> str:
    """Return how far an estimate lies from the truth: 0.7 % over it."""
    error = row.relative_error
    return f"{percent(abs(error))} {'over' if error > 0 else 'under'} the truth"


def measured_sentence(measurement: Measurement, rows: tuple[Compared, ...], number: int, volume: Unit) -> str:
    """Return what is known after view ``number``."""
    views = views_in_words(number)
    if not rows:
        return f"After {views} no box is measured: {reason_in_words(measurement.reason)}."
    error = "" if rows[3].is_open else f", {off_truth(rows[3])}"
    return f"After {views} the box is {size(rows)} and {plus_minus(rows[3], volume)}{error}."


def faces_sentence(estimate: BoxEstimate) -> str:
    """Return which faces were seen and at which angle."""
    faces = [face for face in estimate.quality.faces if face.seen]
    seen = ", ".join(f"{_face(face.name)} at {_degrees(face.incidence)} ({face.returns:,} returns)" for face in faces)
    share = percent(estimate.quality.explained, 0)
    return f"Faces seen: {seen or 'none'}; 0° is head-on. The box explains {share} of its returns."


def foretold_sentence(before: NextView, now: Measurement, volume: Unit) -> str | None:
    """Return what the plan before this view expected of it beside what came; None where there was no expectation."""
    after = None if before.best is None else before.candidates[before.best].assessment.outlook
    if after is None:
        return None
    came = now.boxes[0].volume_sigma if now.boxes else None
    result = "nothing bounds it" if came is None else f"it is {volume.finer().number(came)} {volume.name}"
    expected = f"{volume.finer().number(after.volume_sigma)} {volume.name}"
    return f"The plan expected a standard deviation of the volume of {expected} after this view; {result}."


def decision_sentence(plan: NextView, volume: Unit, *, moved: bool) -> str:
    """Return why the winner won, or why there is none.

    Args:
        plan: The ranking.
        volume: Unit of volumes.
        moved: Whether the camera went there.
    """
    if plan.best is None:
        return f"There is no next view: {plan.abstention or reason_in_words(plan.reason)}."
    best = plan.candidates[plan.best]
    verb = "wins" if moved else "would be next"
    way = f"Candidate {best.index} {verb} ({move_in_words(plan, best)})"
    if plan.policy != MODEL:
        return f"{way}: the policy “{plan.policy}” gave it the highest score."
    return f"{way}: {_gain(best, volume)}{_contest(plan, best)}."


def stop_sentence(plan: NextView, *, moved: bool) -> str:
    """Return whether the volume is known well enough; ``moved`` if the camera went on."""
    if plan.within_tolerance is None:
        return "There is no volume to be certain of yet."
    chance = f"The chance that the volume is right to {_tolerance(plan)} is {probability(plan.within_tolerance)}"
    if plan.stop:
        verdict = "was needed, but this run went on" if moved else "is needed"
        return f"{chance}, over the {plan.confidence:g} asked for: no further view {verdict}."
    bounded = "" if plan.within_tolerance <= plan.confidence else ", and every dimension bounded"
    return f"{chance}; {plan.confidence:g} was asked for{bounded}."


def why_it_ended(episode: Episode) -> str:
    """Return why there was no further view, as a clause."""
    plan = episode.steps[-1].plan
    if plan.stop:
        return f"the volume is known as well as asked for (chance {probability(plan.within_tolerance)} of {_tolerance(plan)})"
    if plan.best is None:
        return plan.abstention or reason_in_words(plan.reason)
    return f"the limit of {views_in_words(len(episode.steps))} was reached before the volume was certain"


def views_in_words(count: int) -> str:
    """Return a number of views: 1 view, 2 views."""
    return "1 view" if count == 1 else f"{count} views"


def move_in_words(plan: NextView, candidate: Candidate) -> str:
    """Return how to get from the present camera to a candidate."""
    return directions_in_words(candidate.camera_to_current, plan.target, plan.up)


def faces_in_words(candidate: Candidate) -> str:
    """Return the faces that a candidate would see, with their angles."""
    faces = candidate.to_dict()["faces"]
    assert isinstance(faces, list)
    words = [f"{_face(face['name'])} {face['incidence_deg']:.0f}°" for face in faces]
    cut = candidate.assessment.prediction is not None and candidate.assessment.prediction.cut
    return (", ".join(words) or "none") + (", cut by the border" if cut else "")


def reason_in_words(reason: str | None) -> str:
    """Return a machine-readable reason as a clause."""
    return NO_PLAN.get(reason or "", REASONS.get(reason or "", "no reason was given")).partition("; ")[0]


def advice(reason: str | None) -> str | None:
    """Return what to do about a reason as a sentence, where there is something."""
    text = REASONS.get(reason or "", "").partition("; ")[2]
    return f"{text[0].upper()}{text[1:]}{'' if text.endswith('?') else '.'}" if text else None


def _gain(best: Candidate, volume: Unit) -> str:
    outlook, score = best.assessment.outlook, best.assessment.score
    assert outlook is not None
    after = f"{volume.finer().number(outlook.volume_sigma)} {volume.name}"
    if not 0 < score < 1:
        return f"it leaves the standard deviation of the volume at {after}"
    now = volume.finer().number(outlook.volume_sigma / (1 - score))
    return f"it is expected to take the standard deviation of the volume from {now} to {after}, {percent(score)} less"


def _contest(plan: NextView, best: Candidate) -> str:
    """Return how the winner compares with the others."""
    score = best.assessment.score
    rivals = [candidate for candidate in plan.candidates if candidate.index != best.index]
    if not rivals:
        return ""
    reachable = [candidate.assessment.score for candidate in rivals if candidate.reachable]
    if max(reachable, default=-1.0) > score:
        text = ", within one point of the best and the shortest way"
    elif max(reachable, default=-1.0) == score:
        text = ", as good as any and the shortest way"
    else:
        text = ", the most of all that can be reached"
    beyond = [candidate for candidate in rivals if not candidate.reachable and candidate.assessment.score > score]
    return text + (f" ({len(beyond)} better {'one is' if len(beyond) == 1 else 'ones are'} out of reach)" if beyond else "")


def _tolerance(plan: NextView) -> str:
    return f"±{plan.tolerance * 100:g} %"


def _face(name: str) -> str:
    return name.replace("-", "−")


def _degrees(radians: float) -> str:
    return f"{radians * 57.29577951308232:.0f}°"
