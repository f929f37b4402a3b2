"""The package as a whole: what importing it costs, how fast its help answers, and that it knows its version."""

import importlib
import importlib.metadata
import importlib.resources
import pkgutil
import subprocess
import sys
import time

import pytest

import viewgain

HEAVY = {"torch", "matplotlib", "jinja2"}
DRAWING_ROOMS = {"report", "cli"}
TORCH_ROOMS = {"network", "training"}
"""They are made of torch; every other room may load it inside a function only."""
ROOMS = sorted({module.name for module in pkgutil.iter_modules(viewgain.__path__)} - DRAWING_ROOMS - TORCH_ROOMS - {"__main__"})

# Each of these runs in a fresh interpreter and prints, as its last line, the top-level modules that it has loaded.
REPORT_MODULES = "\nimport sys\nprint()\nprint(*{name.partition('.')[0] for name in sys.modules})"
RUN_HELP = """
import runpy, sys
sys.argv = ["viewgain", "--help"]
try:
    runpy.run_module("viewgain", run_name="__main__", alter_sys=True)
except SystemExit as exit:
    assert exit.code in (0, None), exit.code
"""


def run_python(*arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([sys.executable, *arguments], capture_output=True, text=True, timeout=120, check=False)


def modules_loaded_by(code: str) -> set[str]:
    done = run_python("-c", code + REPORT_MODULES)
    assert done.returncode == 0, done.stderr
    return set(done.stdout.splitlines()[-1].split())


def test_the_probe_of_loaded_modules_sees_a_module() -> None:
    assert "colorsys" in modules_loaded_by("import colorsys")
    assert "colorsys" not in modules_loaded_by("pass")


@pytest.mark.parametrize("code", ["import viewgain", RUN_HELP], ids=["import", "help"])
def test_import_and_help_load_nothing_heavy(code: str) -> None:
    assert not modules_loaded_by(code) & (HEAVY | {"trimesh"})


def test_no_room_below_the_report_loads_drawing_or_training_libraries() -> None:
    loaded = modules_loaded_by("".join(f"import viewgain.{room}\n" for room in ROOMS))
    assert not loaded & HEAVY


def test_help_names_the_program_and_its_demo() -> None:
    done = run_python("-m", "viewgain", "--help")
    assert done.returncode == 0, done.stderr
    assert "viewgain" in done.stdout
    assert "demo" in done.stdout


def test_help_answers_within_a_second() -> None:
    """TIMING TEST, the only one here: the best of three runs, so that a busy machine does not fail it by itself."""
    seconds = []
    for _ in range(3):
        start = time.perf_counter()
        done = run_python("-m", "viewgain", "--help")
        seconds.append(time.perf_counter() - start)
        assert done.returncode == 0, done.stderr
    assert min(seconds) < 1.0, seconds


def test_main_takes_arguments_and_returns_an_exit_code(capsys: pytest.CaptureFixture[str]) -> None:
    main = importlib.import_module("viewgain.cli").main
    assert main(["--help"]) == 0
    assert "demo" in capsys.readouterr().out


def test_the_version_is_said_in_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    main = importlib.import_module("viewgain.cli").main
    assert main(["--version"]) == 0
    assert capsys.readouterr().out == f"viewgain {viewgain.__version__}\n"


def test_an_unknown_command_is_refused_without_a_traceback() -> None:
    done = run_python("-m", "viewgain", "no-such-command")
    assert done.returncode == 2
    assert "no-such-command" in done.stdout + done.stderr
    assert "Traceback" not in done.stderr


def test_the_console_script_is_the_main_of_the_cli() -> None:
    (script,) = importlib.metadata.entry_points(group="console_scripts", name="viewgain")
    assert script.value == "viewgain.cli:main"


def test_version_is_the_installed_one() -> None:
    assert viewgain.__version__ == importlib.metadata.version("viewgain")


def test_type_information_is_shipped() -> None:
    assert (importlib.resources.files("viewgain") / "py.typed").is_file()
