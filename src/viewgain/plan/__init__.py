"""Where the camera should go next: what each candidate of a rig would teach, policies, and the stop rule."""

from viewgain.plan._adapters import OnBelief as OnBelief
from viewgain.plan._adapters import OnScans as OnScans
from viewgain.plan._belief import Belief as Belief
from viewgain.plan._belief import Outlook as Outlook
from viewgain.plan._explorers import FarthestPolicy as FarthestPolicy
from viewgain.plan._explorers import UniformPolicy as UniformPolicy
from viewgain.plan._explorers import spread_order as spread_order
from viewgain.plan._network import NetworkPolicy as NetworkPolicy
from viewgain.plan._next import Candidate as Candidate
from viewgain.plan._next import NextView as NextView
from viewgain.plan._next import next_view as next_view
from viewgain.plan._policy import Assessment as Assessment
from viewgain.plan._policy import CovariancePolicy as CovariancePolicy
from viewgain.plan._policy import Policy as Policy
from viewgain.plan._policy import RandomPolicy as RandomPolicy
from viewgain.plan._predict import Prediction as Prediction
from viewgain.plan._predict import predict as predict
from viewgain.plan._views import Seen as Seen
from viewgain.plan._views import ViewPolicy as ViewPolicy
from viewgain.plan._views import choose as choose
from viewgain.plan._views import unique as unique
from viewgain.plan._views import visited_among as visited_among
from viewgain.plan._volumetric import Mapper as Mapper
from viewgain.plan._volumetric import VolumetricPolicy as VolumetricPolicy
from viewgain.plan._words import directions_in_words as directions_in_words
