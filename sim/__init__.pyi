"""The public names of `sim`, each loaded with its module when it is first used."""

from .core.body import Body as Body, Machine as Machine, MachineShape as MachineShape
from .core.clock import Alarm as Alarm, Turn as Turn
from .core.entries import (
    Blackout as Blackout,
    Command as Command,
    Duration as Duration,
    NoticingEntry as NoticingEntry,
    RecordedTrack as RecordedTrack,
    Start as Start,
    WorkList as WorkList,
    WorkTask as WorkTask,
)
from .core.events import EventKind as EventKind
from .core.output import OutputError as OutputError
from .core.recorder import Listener as Listener
from .core.rules import (
    PAPER as PAPER,
    RULE_SETS as RULE_SETS,
    RuleSet as RuleSet,
)
from .core.scenario import (
    AgvMove as AgvMove,
    GantryEntry as GantryEntry,
    Job as Job,
    PersonalityChange as PersonalityChange,
    PersonEntry as PersonEntry,
    Source as Source,
    TrialError as TrialError,
)
from .core.stage import MachineEntry as MachineEntry, MachineModel as MachineModel, Stage as Stage
from .exports import export as export
from .live.live_run import LiveRun as LiveRun
from .machines.gantry.controllers import (
    Caution as Caution,
    Controller as Controller,
    ControllerError as ControllerError,
)
from .machines.gantry.robot import GantryRobot as GantryRobot
from .machines.kinds import KINDS as KINDS
from .record.social_metrics import metrics as metrics
from .runs.recording import (
    Recording as Recording,
    RecordingError as RecordingError,
    load_run as load_run,
)
from .runs.run import Run as Run
from .simulation import Simulation as Simulation, run as run
from .studies import (
    Study as Study,
    StudyError as StudyError,
    StudyResults as StudyResults,
    run_many as run_many,
    run_study as run_study,
    safety_report as safety_report,
)
from .trials.loading import Trial as Trial, builtin_trials as builtin_trials
from .trials.rules_file import load_rules as load_rules
from .views import plots as plots
