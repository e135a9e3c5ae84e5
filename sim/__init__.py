"""What happens: trials, their simulation, the referee, and what is left of a run.

Names are imported when they are first used, so that the command answers `--help` without
loading planners and geometry.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .clock import Clock
    from .controllers import CONTROLLERS, Controller, ControllerError, find_controller
    from .exports import export
    from .gantry import GantryRobot, Steps
    from .minds import Mind, Outside, Percepts
    from .outcome import Recorded, Run
    from .person import MindError
    from .recorder import Event, Listener
    from .recording import OutputError, Recording
    from .rules import ARIAC2023, PAPER, RULE_SETS, Notice, RuleSet, rule_set
    from .run_folder import RecordingError, load_run
    from .scene import Figure, Scene
    from .simulation import Simulation, run
    from .social_metrics import metrics
    from .trial import AgvMove, GantryEntry, Job, PersonEntry, Start, Trial, TrialError
    from .trial_file import builtin_trials

_HOMES = {
    "clock": ("Clock",),
    "controllers": ("CONTROLLERS", "Controller", "ControllerError", "find_controller"),
    "exports": ("export",),
    "gantry": ("GantryRobot", "Steps"),
    "minds": ("Mind", "Outside", "Percepts"),
    "outcome": ("Recorded", "Run"),
    "person": ("MindError",),
    "recorder": ("Event", "Listener"),
    "recording": ("OutputError", "Recording"),
    "rules": ("ARIAC2023", "PAPER", "RULE_SETS", "Notice", "RuleSet", "rule_set"),
    "run_folder": ("RecordingError", "load_run"),
    "scene": ("Figure", "Scene"),
    "simulation": ("Simulation", "run"),
    "social_metrics": ("metrics",),
    "trial": ("AgvMove", "GantryEntry", "Job", "PersonEntry", "Start", "Trial", "TrialError"),
    "trial_file": ("builtin_trials",),
}

__all__ = [
    "ARIAC2023",
    "CONTROLLERS",
    "PAPER",
    "RULE_SETS",
    "AgvMove",
    "Clock",
    "Controller",
    "ControllerError",
    "Event",
    "Figure",
    "GantryEntry",
    "GantryRobot",
    "Job",
    "Listener",
    "Mind",
    "MindError",
    "Notice",
    "OutputError",
    "Outside",
    "Percepts",
    "PersonEntry",
    "Recorded",
    "Recording",
    "RecordingError",
    "RuleSet",
    "Run",
    "Scene",
    "Simulation",
    "Start",
    "Steps",
    "Trial",
    "TrialError",
    "builtin_trials",
    "export",
    "find_controller",
    "load_run",
    "metrics",
    "rule_set",
    "run",
]


def __getattr__(name: str) -> Any:
    for home, names in _HOMES.items():
        if name in names:
            value = getattr(import_module(f".{home}", __name__), name)
            globals()[name] = value
            return value
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
