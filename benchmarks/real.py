"""The public real scans: what comes out, beside what is known of them."""

import argparse

import numpy as np

from benchmarks._data import data_folder
from benchmarks._tables import markdown
from viewgain.cli._text import plan_words
from viewgain.measure import measure
from viewgain.plan import next_view
from viewgain.scans import read_scan

SCANS = {
    "trai_tof/vedere1_small_box.ply": "volume 0.0169-0.0175 m3",
    "trai_tof/vedere1.pcd": "the same box",
    "trai_tof/vedere2.pcd": "the same box, other view",
    "trai_tof/vedere1_large_box.ply": "0.73 x 0.69 x 0.38 (measured by others)",
    "trai_tof/vedere1_large_box_down.ply": "the same box, lying",
    "trai_tof/vedere1_2boxes.ply": "both",
    "fau_kinect2/example1.npz": "0.445 x 0.353 x 0.192",
    "fau_kinect2/example2.npz": "the same box",
    "sick_visionary_t/static_scene.pcd": "unknown; a carton, a mug and a third object",
    "trai_blensor/1.pcd": "0.87 x 0.60 x 0.357 (synthetic)",
}
"""Public scans (sources and licences: docs/accuracy.md) and what is known of their boxes, metres."""


def run(options: argparse.Namespace) -> None:
    """Print one row per box, then the ranking of ring8 per scan."""
    del options
    folder = data_folder()
    if folder is None:
        print("The real scans are not there (set VIEWGAIN_DATA to their folder); nothing measured.\n")
        return
    rows, plans = [], []
    for name, known in SCANS.items():
        result = measure(read_scan(folder / "real_boxes" / name))
        for box in result.boxes:
            sizes = " x ".join(f"{d:.3f}{'+' if b == 'open' else ''}" for d, b in zip(box.dimensions, box.basis, strict=True))
            sigmas = ", ".join("open" if s is None else f"{1e3 * s:.1f}" for s in box.sigma)
            spread = "open" if box.volume_sigma is None else f"{box.volume_sigma:.5f}"
            rows.append((name, sizes, sigmas, f"{box.volume:.5f} ± {spread}", ", ".join(box.flags) or "-", known))
            known = ""
        if not result.boxes:
            rows.append((name, result.reason, "", "", "", known))
        plan = next_view(result)
        if plan.best is not None:
            best = plan.candidates[plan.best]
            faces = ", ".join(
                f"{s.name} {np.rad2deg(s.incidence):.0f}°" for s in best.assessment.prediction.sights if s.returns >= 25
            )  # type: ignore[union-attr]
            scores = " ".join(f"{c.assessment.score:.2f}" for c in plan.candidates)
            plans.append((name, scores, f"{plan.best}: {plan_words(plan, plan.best)}", faces, "yes" if plan.stop else "no"))
    print("## Real scans\n\nA + marks a lower bound. Fits are by default settings: camera unknown, noise from the scan.\n")
    print(markdown(("scan", "length x width x height [m]", "sigma [mm]", "volume [m3]", "flags", "known"), rows))
    print("\n## Next view on them, rig ring8\n")
    print(markdown(("scan", "scores of views 0-7", "best", "it would see", "stop at 5 %, 95 %"), plans))
    print()
