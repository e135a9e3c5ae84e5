"""The public names of `sim`, each loaded with its module when it is first used."""

from .core.body import Body, Machine, MachineShape
from .core.clock import Alarm, Turn
from .core.entries import (
    Blackout,
    Command,
    NoticingEntry,
    RecordedTrack,
    SignOff,
    Start,
)
from .core.events import EventKind
from .core.fields import MachineFields, Muting
from .core.recorder import Listener
from .core.rules import (
    PAPER,
    RULE_SETS,
    RuleSet,
)
from .core.scenario import (
    AgvMove,
    GantryEntry,
    Job,
    PersonalityChange,
    PersonEntry,
    Source,
    TrialError,
)
from .core.schedule import Duration, WorkList, WorkTask
from .core.stage import MachineEntry, MachineModel, Stage
from .exports import export
from .live.live_run import LiveRun
from .machines.caution import Caution
from .machines.gantry.controllers import Controller
from .machines.gantry.robot import GantryRobot
from .machines.kinds import KINDS
from .machines.supervision import ControllerError
from .record.output import OutputError
from .record.social_metrics import metrics
from .runs.recording import (
    Recording,
    RecordingError,
    load_run,
)
from .runs.run import Run
from .searches import SearchResults, search
from .simulation import Simulation, run
from .studies import (
    Study,
    StudyError,
    StudyResults,
    run_many,
    run_study,
    safety_report,
)
from .trials.rules_file import load_rules
from .trials.trial import Trial, builtin_trials
from .views import plots

__all__ = [
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
    "MachineFields",
    "MachineModel",
    "MachineShape",
    "Muting",
    "NoticingEntry",
    "OutputError",
    "PersonEntry",
    "PersonalityChange",
    "RecordedTrack",
    "Recording",
    "RecordingError",
    "RuleSet",
    "Run",
    "SearchResults",
    "SignOff",
    "Simulation",
    "Source",
    "Stage",
    "Start",
    "Study",
    "StudyError",
    "StudyResults",
    "Trial",
    "TrialError",
    "Turn",
    "WorkList",
    "WorkTask",
    "builtin_trials",
    "export",
    "load_rules",
    "load_run",
    "metrics",
    "plots",
    "run",
    "run_many",
    "run_study",
    "safety_report",
    "search",
]
