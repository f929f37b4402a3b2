"""The scatter of simulated flat targets, all effects on, against the published formulas of two cameras: table and picture."""

import argparse
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks._tables import bootstrap, markdown
from viewgain.camera import sensor
from viewgain.geometry import Plane, fit_plane
from viewgain.scenes import Scene
from viewgain.simulate import capture

Array = NDArray[np.float64]
WINDOW = 24
"""Half width of the square of pixels about the image's middle that is looked at."""
SCANS = 6


def nguyen(z: Array, theta: float) -> Array:
    """Return the axial noise of Kinect v1 / PrimeSense, metres (Nguyen et al. 2012)."""
    return 0.0012 + 0.0019 * (z - 0.4) ** 2 + 0.0001 / np.sqrt(z) * (theta / (np.pi / 2 - theta)) ** 2


def fankhauser(z: Array, theta: float) -> Array:
    """Return the axial noise of Kinect v2, metres (Fankhauser et al. 2015)."""
    return 1e-3 * (1.5 - 0.5 * z + 0.3 * z**2 + 0.1 * z**1.5 * (theta / (np.pi / 2 - theta)) ** 2)


CASES: dict[str, tuple[str, Callable[[Array, float], Array], tuple[float, ...]]] = {
    "xtion": ("Nguyen et al. 2012", nguyen, (0.6, 1.0, 1.5, 2.0, 3.0)),
    "kinect_v2": ("Fankhauser et al. 2015", fankhauser, (0.8, 1.0, 1.5, 2.0, 3.0)),
}
ANGLES_DEG = (0, 20, 40, 60)


def flat_target(distance: float, theta: float) -> Scene:
    """Return a wall before a camera at the world's origin (z forward), tilted about the image's vertical."""
    normal = np.array([np.sin(theta), 0.0, -np.cos(theta)])
    return Scene(planes=(Plane(normal, distance * float(np.cos(theta))),))


def residuals(camera_name: str, distance: float, theta: float, seed: int) -> tuple[Array, Array]:
    """Return depth residuals about the fitted plane and the true depths of the middle of one scan, metres."""
    camera = sensor(camera_name)
    rng = np.random.default_rng([seed, int(100 * distance), int(1000 * theta), 1])
    scan = capture(flat_target(distance, theta), np.eye(4), camera, rng=rng)
    height, width = camera.intrinsics.height, camera.intrinsics.width
    rows, columns = slice(height // 2 - WINDOW, height // 2 + WINDOW), slice(width // 2 - WINDOW, width // 2 + WINDOW)
    points = scan.organised()[rows, columns].reshape(-1, 3)
    points = points[np.isfinite(points[:, 2])]
    plane = fit_plane(points)
    # Along the optical axis, as depth cameras are measured: the plane's height divided by the normal's share of the axis.
    return plane.height(points) / abs(plane.normal[2]), points[:, 2]


def ratios(camera_name: str) -> list[tuple[float, int, float, float, tuple[float, float]]]:
    """Return (distance, angle, published, simulated, 95 % interval of their ratio) for each target of one camera."""
    _, formula, distances = CASES[camera_name]
    rows = []
    for distance in distances:
        for degrees in ANGLES_DEG:
            theta = float(np.deg2rad(degrees))
            parts = [residuals(camera_name, distance, theta, seed) for seed in range(SCANS)]
            found, depth = (np.concatenate([part[k] for part in parts]) for k in (0, 1))
            published = float(np.sqrt(np.mean(formula(depth, theta) ** 2)))
            low, high = bootstrap(found, lambda values: float(np.std(values)), draws=200)
            rows.append((distance, degrees, published, float(np.std(found)), (low / published, high / published)))
    return rows


def run(options: argparse.Namespace) -> None:
    """Print the table; with --pictures also draw it."""
    print("## Scatter of flat targets, all effects on, against the published axial noise\n")
    window = f"{2 * WINDOW} x {2 * WINDOW} pixels about the middle of {SCANS} scans each"
    print(f"Depth residuals about the fitted plane, {window}; goal: within 5 %.\n")
    found = {name: ratios(name) for name in CASES}
    for name, rows in found.items():
        print(f"{name}: {CASES[name][0]}\n")
        print(
            markdown(
                ("distance [m]", "incidence [°]", "published [mm]", "simulated [mm]", "ratio (95 %)"),
                [
                    (f"{d:.1f}", a, f"{1e3 * p:.2f}", f"{1e3 * s:.2f}", f"{s / p:.3f} ({i[0]:.3f} to {i[1]:.3f})")
                    for d, a, p, s, i in rows
                ],
            )
        )
        worst = max(abs(s / p - 1) for _, _, p, s, _ in rows)
        print(f"\nFarthest from the formula: {100 * worst:.1f} %.\n")
    if options.pictures is not None:
        draw(found, options.pictures / "sensors-published-noise.png")


def draw(found: dict[str, list[tuple[float, int, float, float, tuple[float, float]]]], path: Path) -> None:
    """Draw simulated scatter with its interval over the published curves, a panel per camera."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(1, len(found), figsize=(10, 4.2), layout="constrained")
    colours = ("#0072B2", "#009E73", "#E69F00", "#D55E00")
    for axis, (name, rows) in zip(axes, found.items(), strict=True):
        source, formula, distances = CASES[name]
        depth = np.linspace(distances[0], distances[-1], 100)
        for angle, colour in zip(ANGLES_DEG, colours, strict=True):
            axis.plot(depth, 1e3 * formula(depth, float(np.deg2rad(angle))), color=colour, lw=1.5)
            own = [row for row in rows if row[1] == angle]
            middle = np.array([1e3 * row[3] for row in own])
            low, high = (np.array([1e3 * row[2] * row[4][k] for row in own]) for k in (0, 1))
            axis.errorbar(
                [row[0] for row in own],
                middle,
                yerr=[middle - low, high - middle],
                fmt="o",
                ms=4,
                color=colour,
                label=f"{angle}°",
            )
        axis.set(title=f"{name}: {source}", xlabel="distance [m]", ylabel="axial noise [mm]", ylim=(0, None))
        axis.grid(alpha=0.3)
        axis.legend(title="incidence", frameon=False, loc="upper left")
    figure.suptitle("Lines: published formula. Dots: scatter of simulated flat targets, all effects on (bars: 95 %)", fontsize=10)
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=110)
