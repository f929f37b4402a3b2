"""Run the benchmarks: all of them, or those that are named."""

import argparse
from pathlib import Path

from benchmarks import (
    accuracy,
    calibration,
    closed_loop,
    confidence,
    coverage_policies,
    data,
    data_labels,
    data_statistics,
    decision,
    enclosing,
    error_model,
    fusion,
    lines,
    multipath,
    network,
    not_a_box,
    present_view,
    published_noise,
    real,
    real_tof,
    rehearsal,
    rounding,
    run_episodes,
    simulation,
    stacks,
    surrogate,
    trust,
    volume,
)

BENCHMARKS = {
    "volume": volume.run,
    "accuracy": accuracy.run,
    "lines": lines.run,
    "closed-loop": closed_loop.run,
    "coverage-policies": coverage_policies.run,
    "fusion": fusion.run,
    "real": real.run,
    "calibration": calibration.run,
    "multipath": multipath.run,
    "simulation": simulation.run,
    "published-noise": published_noise.run,
    "real-tof": real_tof.run,
    "stacks": stacks.run,
    "not-a-box": not_a_box.run,
    "enclosing": enclosing.run,
    "data": data.run,
    "data-labels": data_labels.run,
    "data-statistics": data_statistics.run,
    "network": network.run,
    "present-view": present_view.run,
    "rehearsal": rehearsal.run,
    "rounding": rounding.run,
    "run-episodes": run_episodes.run,
    "surrogate": surrogate.run,
    "decision": decision.run,
    "error-model": error_model.run,
    "trust": trust.run,
    "confidence": confidence.run,
}


def main() -> None:
    """Parse the names and run them in order."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"any of {', '.join(BENCHMARKS)}; default all")
    parser.add_argument(
        "--scenes",
        type=int,
        help="scenes of accuracy, volume (of 128), closed-loop, calibration, fusion (pairs; default 200), stacks (60), not-a-box"
        " (504), enclosing (500), error-model and trust (boxes; 1000), surrogate (boxes; 160), decision (scans; 32),"
        " data-labels (meshes; 20), coverage-policies (objects; 30) and present-view (objects of a category; 6)",
    )
    parser.add_argument(
        "--workers",
        type=int,
        default=2,
        help="processes of all but accuracy, decision, volume, lines, stacks and real (default 2)",
    )
    parser.add_argument("--cameras", nargs="*", help="calibration: presets (default all)")
    parser.add_argument(
        "--captures", type=int, default=50, help="simulation: scans per position of the paper's set, of 1000 (default 50)"
    )
    parser.add_argument(
        "--oracle", action="store_true", help="closed-loop: also the best of the eight views, by the truth (slow)"
    )
    parser.add_argument(
        "--pictures", type=Path, help="volume, calibration, confidence, published-noise, real-tof: also draw, into this folder"
    )
    parser.add_argument(
        "--data",
        nargs="*",
        type=Path,
        help="folders: data sets of data-statistics, rounding, run-episodes; results of confidence",
    )
    parser.add_argument("--runs", nargs="*", type=Path, help="present-view, rounding, run-episodes: folders of training runs")
    parser.add_argument("--kept", type=Path, help="error-model, trust: folder that keeps what was measured, and gives it back")
    parser.add_argument("--out", type=Path, help="error-model, confidence: also write the fit to all boxes, into this file")
    options = parser.parse_args()
    unknown = set(options.names) - set(BENCHMARKS)
    if unknown:
        parser.error(f"unknown benchmark {sorted(unknown)}; choose from {', '.join(BENCHMARKS)}")
    for name in options.names or BENCHMARKS:
        BENCHMARKS[name](options)


if __name__ == "__main__":
    main()
