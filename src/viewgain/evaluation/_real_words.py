"""Rankings on real scans as Markdown: a row for each scan and policy, and what could not be read."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from viewgain.evaluation._real_scans import RealRanking, stand
from viewgain.measure import BoxEstimate
from viewgain.plan import MIN_FACE_PIXELS, Candidate, NextView

_HEADER = ("scan", "box, mm", "policy", "best view", "why", "its predicted σ of the volume", "agreement")
_NAMES = ("length", "width", "height")


@dataclass(frozen=True, slots=True)
class Unread:
    """A file of a folder that is no scan."""

    source: str
    """Its name."""
    reason: str
    """One line."""


def real_markdown(rankings: Sequence[RealRanking], unread: Sequence[Unread], rig: str) -> str:
    """Return the table as Markdown."""
    rows = [row for ranking in rankings for row in _rows(ranking)]
    lines = ["| " + " | ".join(cells) + " |" for cells in (_HEADER, ["---"] * len(_HEADER), *rows)]
    return "\n".join([
        f"## Where next on {len(rankings)} real scans, rig {rig}",
        "",
        "The largest box in the image is planned for; camera and noise by the scan. Turns are from the present camera, to its"
        " right or left. Predicted: standard deviation of the volume after fusing the view, by the covariance, whoever chose it.",
        "Agreement: whether all policies take one view, and the mean rank correlation of their scores.",
        "",
        *lines,
        *_left_out(unread),
    ]) + "\n"  # fmt: skip


def why(ranking: RealRanking, place: int) -> str:
    """Return what a candidate would make certain: what is open now, the faces it would see, and the error bar that leaves."""
    prediction = ranking.foretold.candidates[place].assessment.prediction
    sights = [] if prediction is None else [sight for sight in prediction.sights if sight.returns >= MIN_FACE_PIXELS]
    seen = ", ".join(f"{sight.name} at {np.rad2deg(sight.incidence):.0f}°" for sight in sights) or "no face"
    cut = ", cut by the border" if prediction is not None and prediction.cut else ""
    return f"{_now(ranking)}; would see {seen}{cut}"


def _now(ranking: RealRanking) -> str:
    if not ranking.measured.boxes:
        return f"nothing measured ({ranking.measured.reason})"
    box = ranking.measured.boxes[0]
    loose = [name for name, basis in zip(_NAMES, box.basis, strict=True) if basis == "open"]
    if loose:
        return f"{' and '.join(loose)} open now"
    share = [(sigma or 0.0) / value for sigma, value in zip(box.sigma, box.dimensions, strict=True)]
    return f"least certain now: {_NAMES[int(np.argmax(share))]} (±{100 * max(share):.1f} %)"


def _rows(ranking: RealRanking) -> list[tuple[str, ...]]:
    rows: list[tuple[str, ...]] = []
    for number, (name, plan) in enumerate(ranking.plans.items()):
        own = (ranking.source, _sizes(ranking)) if number == 0 else ("", "")
        rows.append((*own, name, *_choice(ranking, plan), _agreement(ranking) if number == 0 else ""))
    return rows


def _choice(ranking: RealRanking, plan: NextView) -> tuple[str, str, str]:
    if plan.best is None:
        return ("none", plan.reason or "", "")
    after = ranking.sigma_after(plan.best)
    return (_view(plan, plan.candidates[plan.best]), why(ranking, plan.best), _sigma(ranking, after))


def _view(plan: NextView, candidate: Candidate) -> str:
    where = stand(plan, candidate)
    side = "right" if where.turn_deg > 0 else "left"
    turn = f"{abs(where.turn_deg):.0f}° {side}"
    if abs(where.turn_deg) < 0.5:
        turn = "no turn"
    elif abs(where.turn_deg) > 179.5:
        turn = "opposite side"
    return f"{candidate.index}: {turn}, elevation {where.elevation_deg:.0f}°, {where.distance:.2f} m"


def _sizes(ranking: RealRanking) -> str:
    """Return the dimensions of the box that is planned for, or why there is none."""
    if not ranking.measured.boxes:
        return f"none: {ranking.measured.reason}"
    more = len(ranking.measured.boxes) - 1
    return _size(ranking.measured.boxes[0]) + (f" (and {more} more)" if more else "")


def _size(box: BoxEstimate) -> str:
    words = []
    for value, sigma, basis in zip(box.dimensions, box.sigma, box.basis, strict=True):
        is_open = sigma is None or basis == "open"
        words.append(f"≥ {1e3 * value:.0f}" if is_open else f"{1e3 * value:.0f} ± {1e3 * (sigma or 0.0):.1f}")
    return " × ".join(words)


def _sigma(ranking: RealRanking, after: float | None) -> str:
    if after is None:
        return ""
    now = ranking.measured.boxes[0].volume_sigma if ranking.measured.boxes else None
    return f"{1e3 * after:.2f} l (now {'unbounded' if now is None else f'{1e3 * now:.2f} l'})"


def _agreement(ranking: RealRanking) -> str:
    if ranking.same_best is None:
        return ""
    agreed = "" if ranking.correlation is None else f", {ranking.correlation:.2f}"
    return f"{'one view' if ranking.same_best else 'different views'}{agreed}"


def _left_out(unread: Sequence[Unread]) -> list[str]:
    return ["", f"Not read ({len(unread)}):", "", *(f"- {each.source}: {each.reason}" for each in unread)] if unread else []
