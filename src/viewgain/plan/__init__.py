"""Where the camera should go next: what each candidate of a rig would teach, policies, and the stop rule."""

from viewgain.plan._belief import Belief as Belief
from viewgain.plan._belief import Outlook as Outlook
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
from viewgain.plan._words import directions_in_words as directions_in_words
