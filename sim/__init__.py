"""What happens: trials, their simulation, the referee, and what is left of a run.

Names are imported when they are first used, so that the command answers `--help` without
loading planners and geometry.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .body import Body
    from .clock import Clock, StandstillError
    from .controllers import CONTROLLERS, Caution, Controller, ControllerError, find_controller
    from .drive import Steps
    from .exports import export
    from .gantry import GantryRobot, Sighting
    from .minds import Mind, Outside, Percepts
    from .pages.live import LiveRun
    from .person import MindError, Person
    from .recordings.outcome import Recorded, Run
    from .recordings.output import OutputError
    from .recordings.recorder import Event, Listener
    from .recordings.recording import Recording
    from .recordings.run_folder import RecordingError, load_run
    from .recordings.scene import Figure, Scene
    from .recordings.social_metrics import metrics
    from .rules import ARIAC2023, PAPER, RULE_SETS, Notice, RuleSet, rule_set
    from .simulation import Simulation, run
    from .study import Row, Study, StudyError, StudyResults, run_study
    from .tasks import Handling, Step, Task, Tasks
    from .trials.own_law import LawError, OwnLaw
    from .trials.rules_file import RulesError, find_rules, load_rules
    from .trials.trial import (
        AgvMove,
        GantryEntry,
        Job,
        PersonalityChange,
        PersonEntry,
        Start,
        Trial,
        TrialError,
    )
    from .trials.trial_file import builtin_trials
    from .trials.verdict import Verdict

_HOMES = {
    "body": ("Body",),
    "clock": ("Clock", "StandstillError"),
    "exports": ("export",),
    "controllers": ("CONTROLLERS", "Caution", "Controller", "ControllerError", "find_controller"),
    "drive": ("Steps",),
    "gantry": ("GantryRobot", "Sighting"),
    "pages.live": ("LiveRun",),
    "minds": ("Mind", "Outside", "Percepts"),
    "recordings.outcome": ("Recorded", "Run"),
    "person": ("MindError", "Person"),
    "recordings.recorder": ("Event", "Listener"),
    "recordings.output": ("OutputError",),
    "recordings.recording": ("Recording",),
    "trials.own_law": ("LawError", "OwnLaw"),
    "trials.rules_file": ("RulesError", "find_rules", "load_rules"),
    "rules": ("ARIAC2023", "PAPER", "RULE_SETS", "Notice", "RuleSet", "rule_set"),
    "recordings.run_folder": ("RecordingError", "load_run"),
    "recordings.scene": ("Figure", "Scene"),
    "simulation": ("Simulation", "run"),
    "recordings.social_metrics": ("metrics",),
    "tasks": ("Handling", "Step", "Task", "Tasks"),
    "study": ("Row", "Study", "StudyError", "StudyResults", "run_study"),
    "trials.trial": (
        "AgvMove",
        "GantryEntry",
        "Job",
        "PersonalityChange",
        "PersonEntry",
        "Start",
        "Trial",
        "TrialError",
    ),
    "trials.trial_file": ("builtin_trials",),
    "trials.verdict": ("Verdict",),
}

__all__ = [
    "ARIAC2023",
    "CONTROLLERS",
    "PAPER",
    "RULE_SETS",
    "AgvMove",
    "Body",
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
    "Person",
    "PersonEntry",
    "PersonalityChange",
    "Recorded",
    "Recording",
    "RecordingError",
    "Row",
    "RuleSet",
    "RulesError",
    "Run",
    "Scene",
    "Sighting",
    "Simulation",
    "StandstillError",
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
