"""Scores from a network file through onnxruntime; torch is not needed."""

from viewgain.inference._card import POSE_KIND as POSE_KIND
from viewgain.inference._card import FrameName as FrameName
from viewgain.inference._card import Metric as Metric
from viewgain.inference._card import ModelCard as ModelCard
from viewgain.inference._card import Source as Source
from viewgain.inference._ensemble import Ensemble as Ensemble
from viewgain.inference._markdown import to_markdown as to_markdown
from viewgain.inference._model_file import CARD_KEY as CARD_KEY
from viewgain.inference._normalise import Bounds as Bounds
from viewgain.inference._normalise import around_middle as around_middle
from viewgain.inference._normalise import bounds_of as bounds_of
from viewgain.inference._normalise import normalised as normalised
from viewgain.inference._normalise import thinned as thinned
from viewgain.inference._pose_scorer import POSE_INPUTS as POSE_INPUTS
from viewgain.inference._pose_scorer import PoseScorer as PoseScorer
from viewgain.inference._pose_scorer import volume_scorer as volume_scorer
from viewgain.inference._scorer import INPUTS as INPUTS
from viewgain.inference._scorer import Scorer as Scorer
from viewgain.inference._scores import CloudScorer as CloudScorer
from viewgain.inference._scores import Scores as Scores
from viewgain.inference._shipped import VOLUME_MODEL as VOLUME_MODEL
from viewgain.inference._shipped import find_model as find_model
from viewgain.inference._shipped import model_name as model_name
from viewgain.inference._shipped import shipped_models as shipped_models
