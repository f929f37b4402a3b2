"""What a view is worth when the truth is known: coverage, histograms of volume error, and the constraints of time of flight."""

from viewgain.gain._bits import packed as packed
from viewgain.gain._bits import size as size
from viewgain.gain._bits import unpacked as unpacked
from viewgain.gain._clouds import model_clouds as model_clouds
from viewgain.gain._clouds import normalised as normalised
from viewgain.gain._clouds import surface_samples as surface_samples
from viewgain.gain._compiled import Search as Search
from viewgain.gain._cover import Cover as Cover
from viewgain.gain._cover import cover as cover
from viewgain.gain._coverage import CoverageLabels as CoverageLabels
from viewgain.gain._coverage import Rule as Rule
from viewgain.gain._coverage import coverage_auc as coverage_auc
from viewgain.gain._coverage import coverage_labels as coverage_labels
from viewgain.gain._coverage import greedy_labels as greedy_labels
from viewgain.gain._greedy import UnionGreedy as UnionGreedy
from viewgain.gain._greedy import greedy_union as greedy_union
from viewgain.gain._protocol import COVERAGE_PROTOCOLS as COVERAGE_PROTOCOLS
from viewgain.gain._protocol import PAPER as PAPER
from viewgain.gain._protocol import PCNBV as PCNBV
from viewgain.gain._protocol import CoverageProtocol as CoverageProtocol
