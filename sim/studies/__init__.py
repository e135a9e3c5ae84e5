"""Many trials: which, in which variations, run on all cores or a cluster, and what came of it."""

from .comparison import Comparison, Group, Measure, Spread
from .definition import Row, StudyError
from .draws import Choice, Distribution, Normal, Shuffled, Uniform
from .effects import Contrast, Effect
from .folder import save_trial
from .many import WorkerError, run_many
from .report import figure
from .results import StudyResults
from .running import run_study
from .safety import safety_report
from .study import Study
from .variables import KINDS, Variable, variable

__all__ = [
    "KINDS",
    "Choice",
    "Comparison",
    "Contrast",
    "Distribution",
    "Effect",
    "Group",
    "Measure",
    "Normal",
    "Row",
    "Shuffled",
    "Spread",
    "Study",
    "StudyError",
    "StudyResults",
    "Uniform",
    "Variable",
    "WorkerError",
    "figure",
    "run_many",
    "run_study",
    "safety_report",
    "save_trial",
    "variable",
]
