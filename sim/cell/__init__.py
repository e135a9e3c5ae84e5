"""The cell: what other systems may read and command in a running simulation, without a protocol.

`Cell` lists signals, commands and tasks of all people and machines by name. Transports such as
`sim.bridge` translate them. `Pace` relates simulated time to real time, and `Admission` rejects
values that must not enter.
"""

from ..machines.gantry.trajectories import JointPoint, JointTrajectory
from .admission import Rejected
from .cell import Cell
from .pace import Pace
from .signals import Signal
from .tasks import CellCommand, CellTask, Running
from .values import Feedback, MonitorState, Pose, Scan, Velocity

__all__ = [
    "Cell",
    "CellCommand",
    "CellTask",
    "Feedback",
    "JointPoint",
    "JointTrajectory",
    "MonitorState",
    "Pace",
    "Pose",
    "Rejected",
    "Running",
    "Scan",
    "Signal",
    "Velocity",
]
