"""Topics and services of the human challenge of ARIAC 2023, for each transport with ROS messages.

`CompetitionTopics` publishes through a `Transport`, and passes what clients publish to the cell.
"""

from .machine_topics import add_gantry
from .topics import CompetitionTopics, driven_person
from .transport import RefusedError, Transport, Values

__all__ = [
    "CompetitionTopics",
    "RefusedError",
    "Transport",
    "Values",
    "add_gantry",
    "driven_person",
]
