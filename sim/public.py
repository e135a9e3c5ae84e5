"""The public names of `sim`; a package has them once one of them is used."""

from .core.body import Body, Machine, MachineShape
from .core.clock import Alarm, Clock, StandstillError, Turn
from .core.entries import (
    Blackout,
    Command,
    Duration,
    NoticingEntry,
    RecordedTrack,
    Start,
    WorkList,
    WorkTask,
)
from .core.events import EventKind
from .core.output import OutputError
from .core.recorder import Event, Figure, Listener, Scene
from .core.rules import ARIAC2023, PAPER, RULE_SETS, Notice, RuleSet, rule_set
from .core.scenario import (
    AgvMove,
    Drop,
    GantryEntry,
    Job,
    PersonalityChange,
    PersonEntry,
    Source,
    TrialError,
)
from .core.stage import MachineEntry, MachineModel, Stage
from .exports import export
from .live.live_run import LiveRun
from .machines.gantry.controllers import (
    CONTROLLERS,
    Caution,
    Controller,
    ControllerError,
    find_controller,
)
from .machines.gantry.drive import Steps
from .machines.gantry.robot import GantryRobot, Sighting
from .machines.gantry.tasks import Handling, Step, Task, Tasks
from .machines.kinds import KINDS, MachineError
from .people.actions import MindError
from .people.minds import Mind, Outside
from .people.perception import Percepts
from .people.person import Person
from .record.social_metrics import metrics
from .runs.recording import Recording, RecordingError, load_run
from .runs.run import Recorded, Run
from .safety.laws import LawError, OwnLaw
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
from .trials.rules_file import RulesError, find_rules, load_rules
from .trials.timeline import Verdict
from .trials.trial import Trial, builtin_trials

__all__ = [
    "ARIAC2023",
    "CONTROLLERS",
    "KINDS",
    "PAPER",
    "RULE_SETS",
    "AgvMove",
    "Alarm",
    "Blackout",
    "Body",
    "Caution",
    "Clock",
    "Command",
    "Controller",
    "ControllerError",
    "Drop",
    "Duration",
    "Event",
    "EventKind",
    "Figure",
    "GantryEntry",
    "GantryRobot",
    "Handling",
    "Job",
    "LawError",
    "Listener",
    "LiveRun",
    "Machine",
    "MachineEntry",
    "MachineError",
    "MachineModel",
    "MachineShape",
    "Mind",
    "MindError",
    "Notice",
    "NoticingEntry",
    "OutputError",
    "Outside",
    "OwnLaw",
    "Percepts",
    "Person",
    "PersonEntry",
    "PersonalityChange",
    "Recorded",
    "RecordedTrack",
    "Recording",
    "RecordingError",
    "Row",
    "RuleSet",
    "RulesError",
    "Run",
    "Scene",
    "Sighting",
    "Simulation",
    "Source",
    "Stage",
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
    "Turn",
    "Verdict",
    "WorkList",
    "WorkTask",
    "builtin_trials",
    "export",
    "find_controller",
    "find_rules",
    "load_rules",
    "load_run",
    "metrics",
    "rule_set",
    "run",
    "run_many",
    "run_study",
    "safety_report",
]
