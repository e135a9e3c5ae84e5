"""What happens: trials, their simulation, the referee, and what is left of a run.

Names are imported when they are first used, so that the command answers `--help` without
loading planners and geometry.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .clock import Clock
    from .controllers import CONTROLLERS, Caution, Controller, ControllerError, find_controller
    from .drive import Steps
    from .exports import export
    from .gantry import GantryRobot, Sighting
    from .live import LiveRun
    from .minds import Mind, Outside, Percepts
    from .outcome import Recorded, Run
    from .own_law import LawError, OwnLaw
    from .person import MindError
    from .recorder import Event, Listener
    from .recording import OutputError, Recording
    from .rules import ARIAC2023, PAPER, RULE_SETS, Notice, RuleSet, rule_set
    from .rules_file import RulesError, find_rules, load_rules
    from .run_folder import RecordingError, load_run
    from .scene import Figure, Scene
    from .simulation import Simulation, run
    from .social_metrics import metrics
    from .study import Study, StudyError, StudyResults, run_study
    from .tasks import Handling, Step, Task, Tasks
    from .trial import AgvMove, GantryEntry, Job, PersonEntry, Start, Trial, TrialError
    from .trial_file import builtin_trials
    from .verdict import Verdict

_HOMES = {
    "clock": ("Clock",),
    "exports": ("export",),
    "controllers": ("CONTROLLERS", "Caution", "Controller", "ControllerError", "find_controller"),
    "drive": ("Steps",),
    "gantry": ("GantryRobot", "Sighting"),
    "live": ("LiveRun",),
    "minds": ("Mind", "Outside", "Percepts"),
    "outcome": ("Recorded", "Run"),
    "person": ("MindError",),
    "recorder": ("Event", "Listener"),
    "recording": ("OutputError", "Recording"),
    "own_law": ("LawError", "OwnLaw"),
    "rules_file": ("RulesError", "find_rules", "load_rules"),
    "rules": ("ARIAC2023", "PAPER", "RULE_SETS", "Notice", "RuleSet", "rule_set"),
    "run_folder": ("RecordingError", "load_run"),
    "scene": ("Figure", "Scene"),
    "simulation": ("Simulation", "run"),
    "social_metrics": ("metrics",),
    "tasks": ("Handling", "Step", "Task", "Tasks"),
    "study": ("Study", "StudyError", "StudyResults", "run_study"),
    "trial": ("AgvMove", "GantryEntry", "Job", "PersonEntry", "Start", "Trial", "TrialError"),
    "trial_file": ("builtin_trials",),
    "verdict": ("Verdict",),
}

__all__ = [
    "ARIAC2023",
    "CONTROLLERS",
    "PAPER",
    "RULE_SETS",
    "AgvMove",
    "Caution",
    "Clock",
    "Controller",
    "ControllerError",
    "Event",
    "Figure",
    "GantryEntry",
    "GantryRobot",
    "Handling",
    "Job",
    "LawError",
    "Listener",
    "LiveRun",
    "Mind",
    "MindError",
    "Notice",
    "OutputError",
    "Outside",
    "OwnLaw",
    "Percepts",
    "PersonEntry",
    "Recorded",
    "Recording",
    "RecordingError",
    "RuleSet",
    "RulesError",
    "Run",
    "Scene",
    "Sighting",
    "Simulation",
    "Start",
    "Step",
    "Steps",
    "Study",
    "StudyError",
    "StudyResults",
    "Task",
    "Tasks",
    "Trial",
    "TrialError",
    "Verdict",
    "builtin_trials",
    "export",
    "find_controller",
    "find_rules",
    "load_rules",
    "load_run",
    "metrics",
    "rule_set",
    "run",
    "run_study",
]


def __getattr__(name: str) -> Any:
    for home, names in _HOMES.items():
        if name in names:
            value = getattr(import_module(f".{home}", __name__), name)
            globals()[name] = value
            return value
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
