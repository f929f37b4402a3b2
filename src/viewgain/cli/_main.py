"""Entry point: parse, run one command, and turn every expected error into one line and an exit code."""

import os
import sys
from collections.abc import Sequence
from importlib import import_module

import viewgain
from viewgain.cli._commands import Calibrate, Dataset, Demo, Measure, Next, Simulate
from viewgain.cli._evaluate_commands import Evaluate
from viewgain.cli._exit import BAD_INPUT, NOT_WRITTEN, print_error
from viewgain.cli._training_commands import Export, Train
from viewgain.errors import MissingExtraError, StorageError, ViewgainError

_RUNNERS = {
    Measure: ("_measure", "run_measure"),
    Next: ("_next", "run_next"),
    Calibrate: ("_calibrate", "run_calibrate"),
    Simulate: ("_simulate", "run_simulate"),
    Dataset: ("_dataset", "run_dataset"),
    Train: ("_train", "run_train"),
    Export: ("_export", "run_export"),
    Evaluate: ("_evaluate", "run_evaluate"),
    Demo: ("_demo", "run_demo"),
}
"""Where the work of each command is done; loaded only when it is asked for."""
_EXTRAS = {"torch": "train", "safetensors": "train", "onnx": "train"}
"""Packages that a whole command stands on, and the extra that brings each; rooms name those that they need for a part."""
_DESCRIPTION = """How big is the box, how sure are we, and where should the depth camera move next?

  viewgain measure scan.ply             length, width, height and volume with error bars
  viewgain next scan.ply --rig ring8    where to move the camera, and whether to stop
  viewgain calibrate scan.png --dims .. what a known box says about this very camera
  viewgain simulate --out DIR           scans of a simulated scene, with the truth
  viewgain dataset build RECIPE         training data, the same bits on one core or a cluster
  viewgain train RECIPE                 a network from training data, and go on with it to the bit
  viewgain export RUN --out FILE.onnx   its best weights, with a model card
  viewgain evaluate table1 --fresh 10   how often networks choose the best view, beside floors
  viewgain evaluate coverage --fresh 10 how much policies cover, view after view
  viewgain evaluate table2 --data DIR   how often it names a box's best position
  viewgain evaluate labels --data DIR   which positions its labels choose, and what those are worth
  viewgain evaluate volume              planners for a box's volume, on fresh boxes
  viewgain evaluate shapes              planners for the volume of objects of any shape
  viewgain evaluate map                 what each position around a box is worth, as a picture
  viewgain evaluate real SCANS          where policies would go next on real scans, and why
  viewgain demo                         the whole loop on a simulated scene, with a report
  viewgain --version                    which version this is

Exit codes: 0 measured, 2 bad input or usage, 3 nothing measurable (with its reason), 4 cannot be written."""


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command and return its exit code; never raises for bad input, and never prints a traceback for it.

    Args:
        argv: Arguments without the program's name; default the process's own.
    """
    import tyro

    arguments = list(sys.argv[1:] if argv is None else argv)
    if arguments == ["--version"]:
        print(f"viewgain {viewgain.__version__}")
        return 0
    try:
        command = tyro.cli(
            Measure | Next | Calibrate | Simulate | Dataset | Train | Export | Evaluate | Demo,
            prog="viewgain",
            description=_DESCRIPTION,
            args=arguments or ["--help"],
        )
    except SystemExit as exit_:
        return exit_.code if isinstance(exit_.code, int) else 0 if exit_.code is None else BAD_INPUT
    try:
        module, runner = _RUNNERS[type(command)]
        return int(getattr(import_module(f"viewgain.cli.{module}"), runner)(command))
    except StorageError as error:
        print_error(error)
        return NOT_WRITTEN
    except ViewgainError as error:
        print_error(error)
        return BAD_INPUT
    except ModuleNotFoundError as error:
        if error.name not in _EXTRAS:
            raise
        print_error(MissingExtraError(f'this command needs {error.name}: pip install "viewgain[{_EXTRAS[error.name]}]"'))
        return BAD_INPUT
    except BrokenPipeError:
        # The reader of our output has gone (a pager, head); what it wanted it has got.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except KeyboardInterrupt:
        print("viewgain: interrupted", file=sys.stderr)
        return 130
