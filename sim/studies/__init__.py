"""Studies: variations of trials, run on all cores or a cluster, and their statistics."""

from ..core.wording import figure
from .comparison import Comparison, Contrast, Effect, Measure, RowGroup, Spread, StudyResults
from .design import Choice, Distribution, Normal, Row, Shuffled, Study, StudyError, Uniform
from .folder import save_trial
from .running import WorkerError, run_many, run_study
from .safety import safety_report
from .variables import KINDS, Variable, variable

__all__ = [
    "KINDS",
    "Choice",
    "Comparison",
    "Contrast",
    "Distribution",
    "Effect",
    "Measure",
    "Normal",
    "Row",
    "RowGroup",
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
