"""Entries of a trial: start conditions, manners, noticing, tracks, blackouts, commands."""

from __future__ import annotations

import math
import sys
import zlib
from dataclasses import KW_ONLY, field, fields, replace
from datetime import date
from random import Random
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, model_validator

from floorplan import Obstacle, Point, UserError
from floorplan.files.dataclass import dataclass
from floorplan.files.fields import (
    LARGEST,
    ComposedKeys,
    Constrained,
    Expected,
    Fits,
    Flag,
    Keyed,
    NotNegative,
    Number,
    Pair,
    Positive,
    Range,
    whole,
)
from floorplan.files.footprints import Bottom, Top
from floorplan.files.forms import Alias, Composed, Data, Written, written

from .schedule import Drawn, Duration

Pose = Annotated[tuple[Number, Number, Number], Expected("a pose [x, y, rotation]", list, tuple)]
"""Pose: x and y in metres, rotation in radians."""

Place = Annotated[
    Point | str,
    Written(Pair | str),
    Expected("a position [x, y] or the name of a station or door", list, tuple, str),
]
"""Position (x, y in metres), or the name of a station or a door."""


def is_number(value: Any) -> bool:
    """Return whether `value` is a finite number, but no bool."""
    number = isinstance(value, int | float) and not isinstance(value, bool)
    return number and abs(value) <= sys.float_info.max


def seed_of(seed: int, what: str) -> int:
    """Return the seed for `what` in a trial with this `seed`, independent of other entries."""
    # `hash` is salted in every process.
    return zlib.crc32(f"{seed} {what}".encode())


def _as_text(value: Any) -> Any:
    """Return text for a revision or date, which YAML may read as a number or a date."""
    return str(value) if isinstance(value, date) or is_number(value) else value


Text = Annotated[str, BeforeValidator(_as_text)]
"""Text that may look like a number or a date."""


@dataclass(frozen=True, kw_only=True)
class SignOff(Keyed):
    """Entries of the sign-off block of a report. Reports have lines to fill in for empty entries.

    Parameters
    ----------
    plant : str, optional
        Plant, line or cell.
    revision : str, optional
        Revision of the plant's layout or of the report.
    author : str, optional
        Author of the report.
    date : str, optional
        Date of the report.
    """

    plant: Text = ""
    revision: Text = ""
    author: Text = ""
    date: Text = ""

    def over(self, other: SignOff) -> SignOff:
        """Return these entries, with those of another block for empty ones.

        Parameters
        ----------
        other : SignOff
            The other block.
        """
        values = {one.name: getattr(self, one.name) for one in fields(self)}
        return replace(other, **{name: value for name, value in values.items() if value})


UNSIGNED = SignOff()
"""Sign-off block without entries."""


CONDITIONS = ("time", "part_placed", "order_submitted", "event")
"""Conditions of a start or a change of personality, of which one is given."""


@dataclass(frozen=True)
class Start(Keyed):
    """Condition of a start: a time or an event. Exactly one must be given.

    Parameters
    ----------
    time : float or None, optional
        Time in seconds, or None if another condition is given.
    part_placed : dict, optional
        Required fields of a placed part ("part", "agv").
    order_submitted : str, optional
        Name of a submitted order.
    event : str, optional
        Kind of an event.
    count : int, optional
        Number of times the event must occur.
    person : str, optional
        Person named by the event. The default is the waiting person.
    """

    time: NotNegative | None = 0.0
    _: KW_ONLY
    part_placed: dict[str, str] | None = None
    order_submitted: str | None = None
    event: str | None = None
    count: Annotated[int, whole(1)] = 1
    person: str | None = None

    def __post_init__(self) -> None:
        waits = (self.part_placed, self.order_submitted, self.event) != (None, None, None)
        if waits and self.time == 0.0:
            object.__setattr__(self, "time", None)

    @model_validator(mode="wrap")
    @classmethod
    def _one_condition(cls, keys: Any, read: Any) -> Any:
        made = read(keys)
        if isinstance(keys, dict):
            if len(keys.keys() & {*CONDITIONS}) != 1:
                raise UserError(f"give one of {', '.join(CONDITIONS)}")
            if "event" not in keys and keys.keys() & {"count", "person"}:
                raise UserError("count and person belong to an event")
        return made


AT_ONCE = Start()
"""Start at the beginning of the trial."""


def _view_fault(view: Any) -> str:
    """Return why a field of view (degrees) is too large, or an empty text."""
    widest = max(view) if isinstance(view, tuple) else view
    too_large = isinstance(widest, float | int) and widest > 360.0
    return f"must be at most 360 degrees, not {view!r}" if too_large else ""


@dataclass(frozen=True, kw_only=True)
class NoticingEntry(Keyed):
    """Perception of machines by a person. By default people see in all directions.

    Parameters
    ----------
    field_of_view : float or distribution, optional
        Field of view in degrees, centred on the direction of gaze.
    occlusion : bool, optional
        Whether walls, obstacles and machines block the view.
    reaction_time : float or distribution, optional
        Delay in seconds between seeing and perceiving.
    """

    field_of_view: Annotated[Drawn | None, Fits(_view_fault)] = None
    occlusion: Flag = False
    reaction_time: Drawn | None = None


ALL_ROUND = NoticingEntry()
"""Noticing by default: by distance alone, without delay."""


def drawn_figure(value: Drawn, seed: int, what: str) -> float:
    """Return a value, drawn for `what` from the `seed` of a trial unless it is fixed."""
    random = Random(seed_of(seed, what))
    if isinstance(value, Duration):
        return value.draw(random)
    return random.uniform(*value) if isinstance(value, tuple) else value


def _at_least(least: float) -> Fits:
    """Return the rule for a number of at least `least`, or a range of such numbers."""

    def fault(value: float | tuple[float, float]) -> str:
        low, high = value if isinstance(value, tuple) else (value, value)
        if least <= low <= high <= LARGEST:
            return ""
        return f"must be {least:g} or more, or [least, most] of that, not {value!r}"

    return Fits(fault)


Spread = Annotated[float | tuple[float, float], Written(NotNegative | Range), _at_least(0.0)]
"""Number, or range from which a number is drawn for each person."""

PositiveSpread = Annotated[float | tuple[float, float], Written(Positive | Range)]
"""The same in a file, for positive numbers."""

Side = Literal["right", "left"]


@dataclass(frozen=True, kw_only=True)
class MannersEntry(Keyed):
    """Manners of one or several people. None is the default.

    `comfort` is in metres, `time_gap`, `foresight`, `reaction_time` and `patience` in seconds. See
    `sim.people.crowd.parameters.Manners`.
    """

    comfort: Spread | None = None
    time_gap: Spread | None = None
    foresight: Annotated[PositiveSpread | None, _at_least(0.5)] = None
    reaction_time: Spread | None = None
    patience: Annotated[PositiveSpread | None, _at_least(0.0)] = None
    passing_side: Side | None = None
    steps_aside: Flag | None = None


AS_USUAL = MannersEntry()
"""Default manners."""


def _as_name(value: Any) -> Any:
    number = isinstance(value, int) and not isinstance(value, bool)
    return str(value) if number else value


@dataclass(frozen=True)
class RecordedTrack(Keyed):
    """Measured track of a body in a file, or of all its bodies.

    Parameters
    ----------
    file : str
        File, relative to the folder of the trial.
    body : str, optional
        Name or number of the body in the file. By default the name of the person, or the only body.
    since : float, optional
        Time in the file in seconds at which the person starts.
    longest_gap : float, optional
        Maximum time in seconds between two samples.
    top_speed : float, optional
        Maximum speed in m/s between two samples.
    frame_rate : float, optional
        Frames per second, for files that count frames. By default the file's.
    unit : {"m", "cm", "mm"}, optional
        Unit of positions. By default the file's.
    while_tracked : bool, optional
        Whether the person is absent before the first sample, after the last one, and in gaps longer
        than `longest_gap`.
    everybody : bool, optional
        Whether the entry adds all bodies of the file, each while it is tracked. Their names are the
        name of the entry with the name or number of the body.
    """

    file: Annotated[str, Constrained(min_length=1)]
    _: KW_ONLY
    body: Annotated[str | None, BeforeValidator(_as_name)] = None
    since: Number = 0.0
    longest_gap: Positive = 1.0
    top_speed: Positive = 4.0
    frame_rate: Positive | None = None
    unit: Literal["m", "cm", "mm"] | None = None
    while_tracked: Flag = False
    everybody: Flag = False

    @model_validator(mode="before")
    @classmethod
    def _read_name(cls, value: Any) -> Any:
        return {"file": value} if isinstance(value, str) else value


@dataclass(frozen=True)
class Blackout(Keyed):
    """Time span in which a machine does not detect people.

    Parameters
    ----------
    machine : str
        Name of the machine.
    start : Start
        Condition for the begin.
    seconds : float
        Duration in seconds.
    """

    machine: str
    start: Start
    seconds: Positive

    @model_validator(mode="before")
    @classmethod
    def _starts_at_once(cls, value: Any) -> Any:
        return {"start": AT_ONCE, **value} if isinstance(value, dict) else value


COMMANDS = ("send", "block", "clear", "hold", "release")
"""Fields of a command, of which it has one unless it is a `call`."""


@dataclass(frozen=True, kw_only=True)
class BlockKeys(Obstacle):
    """Keys of an obstacle that a command adds."""

    name: Annotated[str, Constrained(min_length=1), Alias("block")]
    bottom: Bottom = 0.0
    top: Top = 1.0

    def obstacle(self) -> Obstacle:
        """Return the obstacle."""
        parts = {"footprint": self.footprint, "bottom": self.bottom, "top": self.top}
        return Obstacle(name=self.name, **parts)


def _block_keys(command: Command) -> Data:
    block = command.block
    return {} if block is None else {"block": block.name, **written(block)}


@dataclass(frozen=True)
class Command(ComposedKeys, Keyed):
    """External command during a trial, carried out after all other events of its time.

    Exactly one of `send`, `block`, `clear`, `hold`, `release` and `call` must be given. A `call` is
    carried out as soon as the simulation gets to its time, as by a program that advances it.

    Parameters
    ----------
    time : float or None, optional
        Time in seconds. `Simulation.command` takes None for now.
    send : str, optional
        Name of a person who walks to `to`.
    to : str or (float, float), optional
        Name of a station or door, or position in metres. If it is occupied, the person walks as
        near as possible.
    block : Obstacle, optional
        Obstacle to add.
    clear : str, optional
        Name of an added obstacle to remove.
    hold, release : str, optional
        Name of a machine that brakes and stays stationary, or continues.
    call : str, optional
        Method of a machine or person, such as "move_to", "twist" or "act".
    machine, person : str, optional
        Name of the machine or person of the call.
    arguments : dict, optional
        Arguments of the method by name. A motion is the list of its pieces, an action its text.
    decision : int, optional
        Number of the decision of an external person right after which a call is carried out.
    """

    time: NotNegative | None = None
    _: KW_ONLY
    send: str | None = None
    to: Place | None = None
    block: Annotated[
        Obstacle | None,
        Alias("\0block"),
        Composed(BlockKeys, BlockKeys.obstacle, _block_keys, only_with="block"),
    ] = None
    clear: str | None = None
    hold: str | None = None
    release: str | None = None
    call: str | None = None
    machine: str | None = None
    person: str | None = None
    arguments: dict[str, Any] | None = None
    decision: int | None = None

    @model_validator(mode="before")
    @classmethod
    def _one_command(cls, keys: Any) -> Any:
        if isinstance(keys, dict) and len(keys.keys() & {*COMMANDS, "call"}) != 1:
            raise UserError(
                f"give a time and one of {', '.join(COMMANDS)}; or a machine and a call"
            )
        return keys

    @property
    def at(self) -> float:
        """Time in seconds, or infinity without a time."""
        return math.inf if self.time is None else float(self.time)


@dataclass(frozen=True)
class Drop(Keyed):
    """Loss of a `part` by the gripper, `delay` seconds after the pick.

    It is the next part of this name after `after` of them were picked.
    """

    part: str = "part"
    after: Annotated[int, whole(0)] = 0
    delay: NotNegative = 0.0


@dataclass(frozen=True, kw_only=True)
class OrderedWork:
    """Orders of a trial from another file. See `sim.orders.workload`.

    `blackouts` are those of the orders. `source` is the name of the file in the trial.
    """

    blackouts: tuple[Blackout, ...] = ()
    source: str = field(default="", compare=False)

    @property
    def ids(self) -> tuple[str, ...]:
        """Names of the orders."""
        return ()

    @property
    def parts(self) -> tuple[str, ...]:
        """Names of all parts that the orders may need."""
        return ()
