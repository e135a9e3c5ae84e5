"""Random trials and the properties of their runs: `python -m tests.random_trials --trials 1000`.

A trial follows from its number alone. There are five families of trials (`--family`). The
properties are recomputed from the motions and events of the finished run with shapely, NumPy and
FCL, without the parts that made them.
"""

from .contact import contact_faults
from .doors import door_faults
from .expectations import slack_faults
from .fcl_judge import judge_faults
from .floors import random_floor
from .guarded import field_faults, random_trial_with_fields
from .movement import movement_faults
from .oracle import vehicle_faults
from .rules import rule_faults
from .separation import separation_faults
from .tracks import tracked_trial
from .trials import random_trial, random_trial_with_doors
from .vehicles import random_trial_of_vehicles

CHECKS = (
    movement_faults,
    separation_faults,
    contact_faults,
    door_faults,
    rule_faults,
    judge_faults,
    slack_faults,
)
"""Checks of all runs. Each yields the faults of a run, in words."""

CHECKS_OF_TRACKS = (separation_faults, judge_faults, slack_faults)
"""Checks of runs with recorded people and machines of any kind."""


def faults(run):
    """Return all faults of a run, in words."""
    if run.trial.fields:
        return [*field_faults(run)]
    tracked = any(entry.recorded is not None for entry in run.trial.people)
    checks = CHECKS_OF_TRACKS if tracked else CHECKS
    # The rules are recomputed only for the machines of the floor.
    checks = [check for check in checks if check is not rule_faults or not run.trial.machines]
    return [fault for check in checks for fault in check(run)]


__all__ = [
    "CHECKS",
    "CHECKS_OF_TRACKS",
    "faults",
    "judge_faults",
    "movement_faults",
    "random_floor",
    "random_trial",
    "random_trial_of_vehicles",
    "random_trial_with_doors",
    "random_trial_with_fields",
    "rule_faults",
    "separation_faults",
    "tracked_trial",
    "vehicle_faults",
]
