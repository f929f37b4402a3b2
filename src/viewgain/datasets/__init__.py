"""Training data from a recipe, on one core or a cluster, the same bits either way; and reading it at full speed."""

from viewgain.datasets._build import Progress as Progress
from viewgain.datasets._build import build as build
from viewgain.datasets._dataset import Dataset as Dataset
from viewgain.datasets._engine import Engine as Engine
from viewgain.datasets._engine import LocalEngine as LocalEngine
from viewgain.datasets._engine import engine as engine
from viewgain.datasets._estimators import ESTIMATORS as ESTIMATORS
from viewgain.datasets._estimators import volume_error as volume_error
from viewgain.datasets._export import export_hf as export_hf
from viewgain.datasets._manifest import Manifest as Manifest
from viewgain.datasets._manifest import read_manifest as read_manifest
from viewgain.datasets._plan import Plan as Plan
from viewgain.datasets._plan import plan_of as plan_of
from viewgain.datasets._recipe_file import RECIPES as RECIPES
from viewgain.datasets._recipe_file import recipe as recipe
from viewgain.datasets._sample import Frame as Frame
from viewgain.datasets._sample import Sample as Sample
from viewgain.datasets._settings import BoxSettings as BoxSettings
from viewgain.datasets._settings import CoverageSettings as CoverageSettings
from viewgain.datasets._settings import MeshSettings as MeshSettings
from viewgain.datasets._settings import PointRules as PointRules
from viewgain.datasets._settings import Recipe as Recipe
from viewgain.datasets._settings import RecordedSettings as RecordedSettings
from viewgain.datasets._verify import estimators_of as estimators_of
from viewgain.datasets._verify import verify as verify
from viewgain.datasets._volume_errors import add_volume_errors as add_volume_errors
