"""Worst-case search: samplers, evaluations, minimised cases, and the report."""

from .evaluations import Evaluation
from .objective import Objective, ObjectiveError, Situation
from .results import Case, SearchProgress, SearchResults
from .samplers import Sampler, SamplerError
from .searching import WorstCaseSearch, run_search, search
from .space import Dimension, Space

__all__ = [
    "Case",
    "Dimension",
    "Evaluation",
    "Objective",
    "ObjectiveError",
    "Sampler",
    "SamplerError",
    "SearchProgress",
    "SearchResults",
    "Situation",
    "Space",
    "WorstCaseSearch",
    "run_search",
    "search",
]
