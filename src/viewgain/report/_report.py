"""What this room offers. Drawing and page writing are imported when they are called, so importing the room costs nothing."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from viewgain.arrays import Pose
from viewgain.box import Box
from viewgain.episodes import Episode
from viewgain.errors import ConfigError
from viewgain.evaluation import CoverageTable, GainMap, LoopTable, RealRanking, Selective, Table1
from viewgain.geometry import inverse
from viewgain.measure import Measurement
from viewgain.plan import NextView
from viewgain.report._embedded import OVERVIEW, range_file, scene_file
from viewgain.report._extra import require_extra
from viewgain.report._files import make_folder, to_json, write_whole
from viewgain.report._numbers import numbers
from viewgain.report._truth import compared, true_dimensions
from viewgain.report._units import MILLIMETRES, volume_unit
from viewgain.scans import Scan

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def write_report(episode: Episode, folder: Path) -> Path:
    """Write a report of a closed loop: pictures, ``numbers.json`` and ``index.html``, which needs nothing but itself.

    Files are written one by one, each whole or not at all, the page last; older files of the same names are replaced.

    Args:
        episode: The run.
        folder: Where to; created if it is missing.

    Returns:
        The path of ``index.html``.

    Raises:
        MissingExtraError: If matplotlib or jinja2 is not installed.
        StorageError: If the folder cannot be written.
    """
    require_extra()
    from viewgain.report._page import render_page

    folder = Path(folder)
    make_folder(folder)
    content = to_json(numbers(episode))
    pngs = _pictures(episode)
    for name, png in pngs.items():
        write_whole(folder / name, png)
    write_whole(folder / "numbers.json", content)
    write_whole(folder / "index.html", render_page(episode, pngs))
    return folder / "index.html"


def save_scan_picture(scan: Scan, measurement: Measurement, path: Path, next_view: NextView | None = None) -> Path:
    """Save the picture of one scan with what was measured in it and, beside it, the candidate cameras of ``next_view``.

    Args:
        scan: The scan; an unorganised cloud is drawn on a grid of its own angular pitch.
        measurement: What was measured, in the frame of this scan's camera.
        path: A .png file; one that exists is replaced.
        next_view: The ranking made after it.

    Returns:
        The path.

    Raises:
        MissingExtraError: If matplotlib or jinja2 is not installed.
        ConfigError: If ``path`` is no .png file.
        StorageError: If it cannot be written.
    """
    path = Path(path)
    if path.suffix.lower() != ".png":
        raise ConfigError(f"{path}: cannot draw '{path.suffix}' files; give a file name that ends in .png")
    require_extra()
    from viewgain.report._style import side_by_side, to_png

    figures = [draw_scan(scan, measurement, sizes=True)]
    if next_view is not None and next_view.candidates:
        figures.append(draw_scene(scan, measurement, next_view, heading="Where next?"))
    write_whole(path, side_by_side([to_png(figure) for figure in figures]))
    return path


def write_ranking_picture(scan: Scan, ranking: RealRanking, path: Path) -> Path:
    """Save the range image of a real scan with its boxes and, beside it, where each policy would go next.

    Args:
        scan: The scan.
        ranking: What was made of it.
        path: A .png file; one that exists is replaced.

    Returns:
        The path.

    Raises:
        MissingExtraError: If matplotlib or jinja2 is not installed.
        StorageError: If ``path`` cannot be written.
    """
    require_extra()
    from viewgain.report._style import side_by_side, to_png

    figures = [draw_scan(scan, ranking.measured, sizes=True)]
    figures += [
        draw_scene(scan, ranking.measured, plan, heading=f"Where next? {name.partition(':')[0]}")
        for name, plan in ranking.plans.items()
        if plan.candidates
    ]
    write_whole(path, side_by_side([to_png(figure) for figure in figures]))
    return path


def write_training_picture(lines: Sequence[Mapping[str, Any]], path: Path) -> Path:
    """Save the curves of a training run: losses by step, and how often its choice was the best view.

    Args:
        lines: The lines of its metrics, ``{"step": ..., "loss": ...}`` and ``{"step": ..., "validation": {...}}``.
        path: A .png file; one that exists is replaced.

    Returns:
        The path.

    Raises:
        MissingExtraError: If matplotlib or jinja2 is not installed.
        StorageError: If ``path`` cannot be written.
    """
    require_extra()
    from viewgain.report._training_picture import training_figure

    return _saved(training_figure(lines), path)


def write_coverage_picture(tables: Sequence[CoverageTable], path: Path) -> Path:
    """Save the picture of some coverage tables: coverage by union view after view, a curve per policy.

    Args:
        tables: At least one; one panel each.
        path: A .png file; one that exists is replaced.

    Returns:
        The path.

    Raises:
        MissingExtraError: If matplotlib or jinja2 is not installed.
        ConfigError: If there is no table.
        StorageError: If ``path`` cannot be written.
    """
    _require_tables(tables)
    from viewgain.report._coverage_picture import coverage_figure

    return _saved(coverage_figure(tables), path)


def write_table1_picture(tables: Sequence[Table1], path: Path) -> Path:
    """Save the picture of some tables: shares of networks as bars with their 95 % intervals, floors as dashed lines.

    Args:
        tables: At least one; one panel each.
        path: A .png file; one that exists is replaced.

    Returns:
        The path.

    Raises:
        MissingExtraError: If matplotlib or jinja2 is not installed.
        ConfigError: If there is no table.
        StorageError: If ``path`` cannot be written.
    """
    _require_tables(tables)
    from viewgain.report._table1_picture import table1_figure

    return _saved(table1_figure(tables), path)


def write_loop_picture(table: LoopTable, path: Path) -> Path:
    """Save the picture of a closed loop: mean volume error by number of views with 95 % intervals, a curve per policy.

    Args:
        table: The table; the oracle, which has no errors view after view, is not in the picture.
        path: A .png file; one that exists is replaced.

    Returns:
        The path.

    Raises:
        MissingExtraError: If matplotlib or jinja2 is not installed.
        ConfigError: If no policy has errors view after view.
        StorageError: If ``path`` cannot be written.
    """
    _require_tables([row for row in table.rows if row.errors is not None])
    from viewgain.report._loop_picture import loop_figure

    return _saved(loop_figure(table), path)


def write_confidence_picture(worth: Selective, what: str, path: Path) -> Path:
    """Save the picture of what a confidence is worth: risk by the share of decisions kept, and said against found.

    Args:
        worth: Of one policy.
        what: Whose decisions on which boxes.
        path: A .png file; one that exists is replaced.

    Returns:
        The path.

    Raises:
        MissingExtraError: If matplotlib or jinja2 is not installed.
        StorageError: If ``path`` cannot be written.
    """
    require_extra()
    from viewgain.report._confidence_picture import confidence_figure

    return _saved(confidence_figure(worth, what), path)


def write_map_picture(drawn: GainMap, path: Path) -> Path:
    """Save the maps of what every position around a box is worth, the truth first and what each policy believes beside it.

    Args:
        drawn: The maps.
        path: A .png file; one that exists is replaced.

    Returns:
        The path.

    Raises:
        MissingExtraError: If matplotlib or jinja2 is not installed.
        StorageError: If ``path`` cannot be written.
    """
    require_extra()
    from viewgain.report._map_picture import map_figure

    return _saved(map_figure(drawn), path)


def _require_tables(tables: Sequence[object]) -> None:
    if not tables:
        raise ConfigError("picture: got no table, wanted at least one")
    require_extra()


def _saved(figure: "Figure", path: Path) -> Path:
    from viewgain.report._style import to_png

    write_whole(path, to_png(figure))
    return path


def draw_scan(
    scan: Scan, measurement: Measurement, *, truth: Box | None = None, heading: str = "Range image", sizes: bool = False
) -> "Figure":
    """Return the picture of a scan's ranges with the measured boxes over it.

    Args:
        scan: The scan; an unorganised cloud is drawn on a grid of its own angular pitch.
        measurement: What was measured, in the frame of this scan's camera.
        truth: The true box in the same frame, where it is known.
        heading: First words of the title.
        sizes: Whether to write the dimensions under the title.

    Raises:
        MissingExtraError: If matplotlib or jinja2 is not installed.
    """
    require_extra()
    from viewgain.report._range_picture import range_figure

    return range_figure(scan, measurement, truth=truth, heading=heading, sizes=sizes)


def draw_scene(
    scan: Scan,
    measurement: Measurement,
    next_view: NextView | None = None,
    *,
    truth: Box | None = None,
    earlier: Sequence[Pose] = (),
    heading: str = "In space",
) -> "Figure":
    """Return the picture of a scan in space with the measured boxes and, after planning, the candidate cameras.

    Args:
        scan: The scan.
        measurement: What was measured, in the frame of this scan's camera.
        next_view: The ranking made after it.
        truth: The true box in the world, where it is known.
        earlier: (4, 4) poses ``camera_to_world`` of the views before this one.
        heading: Title.

    Raises:
        MissingExtraError: If matplotlib or jinja2 is not installed.
    """
    require_extra()
    from viewgain.report._scene_picture import scene_figure

    return scene_figure(scan, measurement, next_view, truth=truth, earlier=earlier, heading=heading)


def _pictures(episode: Episode) -> dict[str, bytes]:
    """Return name and content of every picture of an episode; all views in space are seen from one place."""
    from viewgain.report._dimensions_picture import dimensions_figure
    from viewgain.report._range_picture import range_figure
    from viewgain.report._scene import viewpoint
    from viewgain.report._scene_picture import scene_figure
    from viewgain.report._style import to_png

    truth, steps = episode.world.box, episode.steps
    view = viewpoint(steps[0].fused, steps[0].plan)
    rows = [compared(step.fused, truth) for step in steps]
    truths, units = [*true_dimensions(truth), truth.volume], [*[MILLIMETRES] * 3, volume_unit(truth.volume)]
    pngs = {OVERVIEW: to_png(dimensions_figure(rows, truths, units))}
    for number, step in enumerate(steps, start=1):
        own = truth.in_frame(inverse(step.fused.world))
        earlier = [before.fused.world for before in steps[: number - 1]]
        pngs[range_file(number)] = to_png(range_figure(step.scan, step.fused, truth=own, heading=f"View {number}"))
        pngs[scene_file(number)] = to_png(
            scene_figure(
                step.scan, step.fused, step.plan, truth=truth, earlier=earlier, view=view, heading=f"View {number}: where next?"
            )
        )
    return pngs
