"""Random trials, and what must hold of each run: `python -m tests.random_trials --trials 1000`.

A trial follows from its number alone. What must hold is worked out anew from the motions and
events of the finished run, with shapely and NumPy, and without the parts that made them.
"""

from .contact import contact_faults
from .floors import random_floor
from .movement import movement_faults
from .rules import rule_faults
from .separation import separation_faults
from .trials import random_trial

CHECKS = (movement_faults, separation_faults, contact_faults, rule_faults)
"""Each yields, of a run, all that should not be."""


def faults(run):
    """All that is wrong with a run, in words."""
    return [fault for check in CHECKS for fault in check(run)]


__all__ = ["CHECKS", "faults", "random_floor", "random_trial"]
