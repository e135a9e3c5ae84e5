"""The public names of `sim`, each loaded with its module when it is first used."""

from .core.body import Body, Machine, MachineShape
from .core.clock import Alarm, StandstillError, Turn
from .core.entries import (
    Blackout,
    Command,
    NoticingEntry,
    RecordedTrack,
    Start,
)
from .core.events import EventKind
from .core.output import OutputError
from .core.recorder import Listener
from .core.rules import (
    ARIAC2023,
    PAPER,
    RULE_SETS,
    RuleSet,
    rule_set,
)
from .core.scenario import (
    AgvMove,
    GantryEntry,
    Job,
    PersonalityChange,
    PersonEntry,
    TrialError,
)
from .core.schedule import Duration, WorkList, WorkTask
from .core.stage import MachineEntry, MachineModel, Stage
from .exports import export
from .live.live_run import LiveRun
from .machines.gantry.controllers import (
    Caution,
    Controller,
    ControllerError,
)
from .machines.gantry.robot import GantryRobot
from .machines.gantry.tasks import Task
from .machines.kinds import KINDS
from .people.minds import Mind
from .people.perception import Percepts
from .record.social_metrics import metrics
from .runs.recording import (
    Recording,
    RecordingError,
    load_run,
)
from .runs.run import Run
from .safety.laws import OwnLaw
from .simulation import Simulation, run
from .studies import (
    Row,
    Study,
    StudyError,
    StudyResults,
    run_many,
    run_study,
    safety_report,
)
from .trials.rules_file import load_rules
from .trials.timeline import Verdict
from .trials.trial import Trial, builtin_trials
from .views import plots

__all__ = [
    "ARIAC2023",
    "KINDS",
    "PAPER",
    "RULE_SETS",
    "AgvMove",
    "Alarm",
    "Blackout",
    "Body",
    "Caution",
    "Command",
    "Controller",
    "ControllerError",
    "Duration",
    "EventKind",
    "GantryEntry",
    "GantryRobot",
    "Job",
    "Listener",
    "LiveRun",
    "Machine",
    "MachineEntry",
    "MachineModel",
    "MachineShape",
    "Mind",
    "NoticingEntry",
    "OutputError",
    "OwnLaw",
    "Percepts",
    "PersonEntry",
    "PersonalityChange",
    "RecordedTrack",
    "Recording",
    "RecordingError",
    "Row",
    "RuleSet",
    "Run",
    "Simulation",
    "Stage",
    "StandstillError",
    "Start",
    "Study",
    "StudyError",
    "StudyResults",
    "Task",
    "Trial",
    "TrialError",
    "Turn",
    "Verdict",
    "WorkList",
    "WorkTask",
    "builtin_trials",
    "export",
    "load_rules",
    "load_run",
    "metrics",
    "plots",
    "rule_set",
    "run",
    "run_many",
    "run_study",
    "safety_report",
]
