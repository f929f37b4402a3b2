"""A depth camera looks at a scene: what comes back to each pixel, and what the camera makes of it."""

from viewgain.simulate._capture import capture as capture
from viewgain.simulate._capture import true_hits as true_hits
from viewgain.simulate._effects import ALL_EFFECTS as ALL_EFFECTS
from viewgain.simulate._effects import EFFECTS as EFFECTS
from viewgain.simulate._effects import NO_EFFECTS as NO_EFFECTS
from viewgain.simulate._effects import Effects as Effects
from viewgain.simulate._receive import NO_ERROR as NO_ERROR
from viewgain.simulate._receive import RangeError as RangeError
from viewgain.simulate._receive import draw_range_error as draw_range_error
from viewgain.simulate._recording import FORMATS as FORMATS
from viewgain.simulate._recording import Recording as Recording
from viewgain.simulate._recording import Shot as Shot
from viewgain.simulate._recording import blocked as blocked
from viewgain.simulate._recording import record as record
from viewgain.simulate._recording import single_threads as single_threads
from viewgain.simulate._recording import truth as truth
