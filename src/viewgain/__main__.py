"""Run the command line with ``python -m viewgain``."""

import sys

from viewgain.cli import main

sys.exit(main())
