"""Random trials, and what must hold of each run: `python -m tests.random_trials --trials 1000`.

A trial follows from its number alone; with `--doors` it is one of a second family. What must hold
is worked out anew from the motions and events of the finished run, with shapely and NumPy, and
without the parts that made them.
"""

from .contact import contact_faults
from .doors import door_faults
from .floors import random_floor
from .movement import movement_faults
from .rules import rule_faults
from .separation import separation_faults
from .trials import random_trial, random_trial_with_doors

CHECKS = (movement_faults, separation_faults, contact_faults, door_faults, rule_faults)
"""Each yields, of a run, all that should not be."""


def faults(run):
    """All that is wrong with a run, in words."""
    # The rules are worked out for the machines of the floor alone.
    checks = [check for check in CHECKS if check is not rule_faults or not run.trial.machines]
    return [fault for check in checks for fault in check(run)]


__all__ = ["CHECKS", "faults", "random_floor", "random_trial", "random_trial_with_doors"]
