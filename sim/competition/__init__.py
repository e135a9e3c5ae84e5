"""Topics and services of the human challenge of ARIAC 2023, for each transport with ROS messages.

`CompetitionTopics` publishes through a `Transport`, and passes what clients publish to the cell.
"""

from .machine_topics import GantryTopics
from .topics import CompetitionTopics, driven_person
from .transport import RefusedError, Transport, Values, take

__all__ = [
    "CompetitionTopics",
    "GantryTopics",
    "RefusedError",
    "Transport",
    "Values",
    "driven_person",
    "take",
]
