"""The shipped networks that fit what is judged."""

from viewgain.inference import POSE_KIND, FrameName, Scorer, shipped_models


def shipped_scorers(rig: str) -> dict[str, Scorer]:
    """Return the networks in the package for a rig, of every frame, by name, each opened with one thread; none if none fits.

    Raises:
        ModelError: If one is damaged.
    """
    fixed = [name for name in shipped_models() if not name.startswith(f"{POSE_KIND}-")]  # those have no rig
    opened = {name: Scorer.load(name, threads=1) for name in fixed}
    return {name: scorer for name, scorer in opened.items() if scorer.refusal(rig=rig) is None}


def of_frame(scorers: dict[str, Scorer], frame: FrameName) -> dict[str, Scorer]:
    """Return the networks that want points in a frame."""
    return {name: scorer for name, scorer in scorers.items() if scorer.card.frame == frame}
