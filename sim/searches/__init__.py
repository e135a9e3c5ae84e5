"""Worst-case search: the trials of a study that break a controller, minimised."""

from .evaluations import Evaluation
from .objective import Objective, ObjectiveError, Situation
from .samplers import Sampler, SamplerError
from .searching import Case, Progress, Search, SearchResults, run_search, search
from .space import Dimension, Space

__all__ = [
    "Case",
    "Dimension",
    "Evaluation",
    "Objective",
    "ObjectiveError",
    "Progress",
    "Sampler",
    "SamplerError",
    "Search",
    "SearchResults",
    "Situation",
    "Space",
    "run_search",
    "search",
]
