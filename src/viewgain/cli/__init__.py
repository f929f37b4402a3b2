"""The command line: ``viewgain measure``, ``viewgain next``, ``viewgain demo``. Heavy imports happen inside the commands."""

from viewgain.cli._main import main as main
