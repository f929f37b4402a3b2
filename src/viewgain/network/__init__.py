"""PC-NBV with and without the view state, and compact networks for the same question, in torch (extra: train)."""

from viewgain.errors import MissingExtraError

try:
    import torch as _torch  # noqa: F401
except ImportError as error:
    raise MissingExtraError("viewgain.network wants torch; pip install 'viewgain[train]'") from error

from viewgain.network._build import build as build
from viewgain.network._build import parameters_of as parameters_of
from viewgain.network._compact import Compact as Compact
from viewgain.network._compact import stations_of as stations_of
from viewgain.network._evenness import STATISTICS as STATISTICS
from viewgain.network._evenness import evenness as evenness
from viewgain.network._export import export_onnx as export_onnx
from viewgain.network._export import half_rounded as half_rounded
from viewgain.network._inputs import ScoreNetwork as ScoreNetwork
from viewgain.network._losses import LossKind as LossKind
from viewgain.network._losses import LossSettings as LossSettings
from viewgain.network._losses import RankingKind as RankingKind
from viewgain.network._losses import score_loss as score_loss
from viewgain.network._losses import weight_penalty as weight_penalty
from viewgain.network._neighbours import in_order as in_order
from viewgain.network._neighbours import unrepeated as unrepeated
from viewgain.network._output import Evidence as Evidence
from viewgain.network._output import evidence_of as evidence_of
from viewgain.network._output import log_variance_of as log_variance_of
from viewgain.network._output import scores_of as scores_of
from viewgain.network._output import sigma_of as sigma_of
from viewgain.network._pcnbv import PcNbv as PcNbv
from viewgain.network._pose_scores import PoseScores as PoseScores
from viewgain.network._settings import Kind as Kind
from viewgain.network._settings import NetworkSettings as NetworkSettings
from viewgain.network._settings import Uncertainty as Uncertainty
