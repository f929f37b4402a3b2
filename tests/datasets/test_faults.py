"""What goes wrong in a long build: kill -9, a full disk, a folder that cannot be written, damage, bad meshes, dying processes."""

import os
import resource
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from tests.datasets.engines import Deadly, Inline, squared_unless_thirteen
from tests.oracles.shapes import box_mesh
from viewgain.cli import main
from viewgain.datasets import Dataset, LocalEngine, add_volume_errors, build, plan_of, recipe, verify
from viewgain.datasets._engine import Dead
from viewgain.errors import ConfigError, DataError, StorageError
from viewgain.scenes import standing_box

TINY = "boxes_paper_tiny"


def command(folder: Path, *more: str) -> list[str]:
    return [sys.executable, "-m", "viewgain", "dataset", "build", TINY, "--out", str(folder), *more]


def files(folder: Path) -> dict[str, bytes]:
    """Return every file of a data set but the volume errors."""
    paths = sorted(path for path in folder.rglob("*") if path.is_file() and "errors" not in path.parts)
    return {str(path.relative_to(folder)): path.read_bytes() for path in paths}


def test_a_build_killed_at_any_moment_goes_on_to_the_same_bytes(tmp_path: Path, boxes: Dataset) -> None:
    process = subprocess.Popen(command(tmp_path), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    shards, deadline = tmp_path / "shards", time.monotonic() + 120
    while len(list(shards.glob("*.safetensors"))) < 3 and time.monotonic() < deadline:
        time.sleep(0.01)
    process.send_signal(signal.SIGKILL)
    process.wait()
    assert not (tmp_path / "manifest.json").exists()
    (shards / ".shard-00015.safetensors.beef.tmp").write_bytes(b"half a shard")  # what a kill in the middle of writing leaves
    with pytest.raises(DataError, match="not finished"):
        Dataset(tmp_path)
    build(plan_of(recipe(TINY)), tmp_path, engine=Inline(), resume=True)
    assert files(tmp_path) == files(boxes.folder)


def test_a_full_disk_is_one_line_exit_code_4_and_no_half_shard(tmp_path: Path) -> None:
    def little_room() -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (9000, 9000))  # a shard has 11,000 bytes

    done = subprocess.run(command(tmp_path), capture_output=True, text=True, check=False, preexec_fn=little_room)
    assert done.returncode == 4, done.stderr
    assert "File too large" in done.stderr
    assert done.stderr.count("viewgain: error") == 1
    assert "Traceback" not in done.stderr
    assert list((tmp_path / "shards").iterdir()) == []


def test_after_a_full_disk_the_build_goes_on(tmp_path: Path, boxes: Dataset, monkeypatch: pytest.MonkeyPatch) -> None:
    real, left = os.replace, iter(range(5))

    def full_after_five(*arguments: object) -> None:
        if next(left, None) is None:
            raise OSError(28, "No space left on device")
        real(*arguments)  # type: ignore[arg-type]

    monkeypatch.setattr(os, "replace", full_after_five)
    with pytest.raises(StorageError, match="No space left"):
        build(plan_of(recipe(TINY)), tmp_path, engine=Inline())
    monkeypatch.undo()
    assert len(list((tmp_path / "shards").iterdir())) == 4  # and recipe.json
    build(plan_of(recipe(TINY)), tmp_path, engine=Inline(), resume=True)
    assert files(tmp_path) == files(boxes.folder)


def test_a_folder_that_cannot_be_made_is_exit_code_4(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "file").write_text("in the way")
    assert main(["dataset", "build", TINY, "--out", str(tmp_path / "file" / "below")]) == 4
    assert [line for line in capsys.readouterr().err.splitlines() if "error" in line] == [
        f"viewgain: error: {tmp_path}/file/below/shards: cannot be made (Not a directory); name a folder that can be written"
    ]


@pytest.mark.parametrize("damage", ["flip", "cut", "gone", "other"])
def test_a_damaged_shard_is_found_and_made_anew(
    damage: str, tmp_path: Path, boxes: Dataset, capsys: pytest.CaptureFixture[str]
) -> None:
    build(plan_of(recipe(TINY)), tmp_path, engine=Inline())
    whole = files(tmp_path)
    assert main(["dataset", "verify", str(tmp_path)]) == 0
    capsys.readouterr()
    victim = tmp_path / "shards" / "shard-00007.safetensors"
    content = bytearray(victim.read_bytes())
    if damage == "gone":
        victim.unlink()
    elif damage == "other":
        victim.write_bytes((tmp_path / "shards" / "shard-00009.safetensors").read_bytes())
    elif damage == "cut":
        victim.write_bytes(content[:-1])
    else:
        content[-100] ^= 1
        victim.write_bytes(content)
    assert main(["dataset", "verify", str(tmp_path)]) == 3
    assert "shard-00007.safetensors" in capsys.readouterr().out
    build(plan_of(recipe(TINY)), tmp_path, engine=Inline(), resume=True)
    assert files(tmp_path) == whole == files(boxes.folder)


def test_a_word_changed_in_the_header_is_found_too(tmp_path: Path, boxes: Dataset) -> None:
    build(plan_of(recipe(TINY)), tmp_path, engine=Inline())
    victim = tmp_path / "shards" / "shard-00002.safetensors"
    victim.write_bytes(victim.read_bytes().replace(b'"skipped":"[]"', b'"skipped":"{}"'))
    assert [problem.split(":")[0] for problem in verify(tmp_path)] == ["shards/shard-00002.safetensors"]
    build(plan_of(recipe(TINY)), tmp_path, engine=Inline(), resume=True)
    assert files(tmp_path) == files(boxes.folder)


def test_damaged_errors_are_found_and_worked_out_anew(tmp_path: Path, boxes: Dataset) -> None:
    plan = plan_of(recipe(TINY))
    build(plan, tmp_path, engine=Inline())
    add_volume_errors(plan, tmp_path, ["lines_mended"], engine=Inline())
    victim = tmp_path / "errors" / "lines_mended" / "shard-00003.safetensors"
    whole = victim.read_bytes()
    assert whole == (boxes.folder / "errors" / "lines_mended" / victim.name).read_bytes()
    victim.write_bytes(whole[:-1] + bytes([whole[-1] ^ 1]))
    assert [problem.split(":")[0] for problem in verify(tmp_path)] == ["errors/lines_mended/shard-00003.safetensors"]
    add_volume_errors(plan, tmp_path, ["lines_mended"], engine=Inline())
    assert victim.read_bytes() == whole
    assert verify(tmp_path) == []


def test_another_data_set_in_the_folder_is_left_alone(boxes: Dataset) -> None:
    before = files(boxes.folder)
    for plan, resume, says in (
        (plan_of(recipe(TINY)), False, "add --resume"),
        (plan_of(recipe("coverage_paper_tiny")), True, "another data set"),
    ):
        with pytest.raises(DataError, match=says):
            build(plan, boxes.folder, engine=Inline(), resume=resume)
    assert files(boxes.folder) == before


def test_a_folder_with_other_things_in_it_is_refused(tmp_path: Path) -> None:
    (tmp_path / "shards").mkdir()
    (tmp_path / "shards" / "mine").write_text("mine")
    with pytest.raises(DataError, match="something else"):
        build(plan_of(recipe(TINY)), tmp_path, engine=Inline())


def test_a_bad_mesh_is_skipped_with_its_reason(tmp_path: Path) -> None:
    mesh = box_mesh(standing_box(np.array([2.0, 1.0, 1.0])))
    lines = [f"v {x} {y} {z}" for x, y, z in mesh.vertices] + [f"f {a} {b} {c}" for a, b, c in mesh.faces + 1]
    for name, content in {
        "chair/good.obj": "\n".join(lines),
        "chair/empty.obj": "",
        "mug/broken.obj": "v 0 0\nf 1 2 9",
        "mug/flat.obj": "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3",
    }.items():
        (tmp_path / "meshes" / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / "meshes" / name).write_text(content)
    manifest = build(plan_of(recipe("meshes_random_tiny"), meshes=tmp_path / "meshes"), tmp_path / "out", engine=Inline())
    assert [each.name for each in manifest.skipped] == ["chair/empty", "mug/broken", "mug/flat"]
    assert all(each.reason for each in manifest.skipped)
    assert len((tmp_path / "out" / "skipped.jsonl").read_text().splitlines()) == 3
    data = Dataset(tmp_path / "out")
    assert len(data) >= 3
    assert {sample.category for sample in data} == {"chair"}
    assert verify(tmp_path / "out") == []


def test_nothing_but_bad_meshes_is_an_error(tmp_path: Path) -> None:
    (tmp_path / "meshes" / "mug").mkdir(parents=True)
    (tmp_path / "meshes" / "mug" / "broken.obj").write_text("v 0 0\nf 1 2 9")
    (tmp_path / "meshes" / "chair").mkdir()
    (tmp_path / "meshes" / "chair" / "broken.obj").write_text("")
    with pytest.raises(DataError, match="no sample could be made"):
        build(plan_of(recipe("meshes_random_tiny"), meshes=tmp_path / "meshes"), tmp_path / "out", engine=Inline())


def test_a_unit_that_kills_its_process_is_left_out_and_nothing_else(tmp_path: Path, boxes: Dataset) -> None:
    manifest = build(plan_of(recipe(TINY)), tmp_path, engine=Deadly(unit=4))
    (skipped,) = manifest.skipped
    assert skipped.unit == 4
    assert "killed its worker process" in skipped.reason
    data = Dataset(tmp_path)
    kept = {sample.seed for sample in data}
    assert len(data) == 22
    assert {sample.seed for sample in boxes} - kept == {(0, 2, 2, 0), (0, 2, 2, 1)}


def test_the_local_engine_outlives_its_processes() -> None:
    results = dict(LocalEngine(1).run(squared_unless_thirteen, [11, 13, 14]))
    assert isinstance(results.pop(13), Dead)
    assert results == {number: number * number for number in (11, 14)}


def test_an_engine_wants_a_worker() -> None:
    with pytest.raises(ConfigError, match="0 workers"):
        LocalEngine(0)


def test_scans_that_come_out_otherwise_are_not_measured(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As after a change of the simulator: the errors would be those of other scans."""
    plan = plan_of(recipe(TINY))
    build(plan, tmp_path, engine=Inline())
    from viewgain.datasets import _boxes

    real = _boxes.kept
    monkeypatch.setattr(_boxes, "kept", lambda points, rules, *, rng: real(points + 1e-3, rules, rng=rng))
    with pytest.raises(DataError, match="do not come out as they are stored"):
        add_volume_errors(plan, tmp_path, ["lines_mended"], engine=Inline())
    assert list((tmp_path / "errors" / "lines_mended").iterdir()) == []


def test_errors_are_only_of_boxes_and_by_known_estimators(coverage: Dataset, boxes: Dataset) -> None:
    with pytest.raises(ConfigError, match="has none"):
        add_volume_errors(plan_of(recipe("coverage_pcnbv_tiny")), coverage.folder, ["default"], engine=Inline())
    with pytest.raises(ConfigError, match="lines_mended"):
        add_volume_errors(plan_of(recipe(TINY)), boxes.folder, ["magic"], engine=Inline())
