"""Rule sets: which distances are kept between people and machines, and what follows if not."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Annotated, Literal

from pydantic import AfterValidator

from floorplan import Point, UserError
from floorplan.files.fields import LARGEST, Judged, Keyed, NotNegative, Number, Positive
from floorplan.files.problems import suggestion
from navigation import Condition, FixedDistance, Moving, Scaled, SeparationLaw, TooClose
from navigation.separation import AnyLaw

from .body import MachineShape

MachineMeasure = Literal["none", "stop", "disable"]
"""Consequence of a violation for the machine."""

PersonMeasure = Literal["none", "teleport"]
"""Consequence of a violation for the person."""

NO_TIME = "must be more than 0; for violations that leave the machine alone say machine: none"
"""The fault of a rule set that disables the gantry for no time."""


def _lasting(seconds: float) -> float:
    if seconds == 0:
        raise UserError(NO_TIME)
    return seconds


Lasting = Annotated[
    NotNegative, AfterValidator(_lasting), Judged(lambda seconds: "" if seconds else NO_TIME)
]
"""Time for which a machine is disabled, seconds."""

Offset = Annotated[
    Number,
    Judged(lambda x: "" if abs(x) <= LARGEST else f"must be a length in metres, not {x!r}"),
]
"""Place along a lane, metres; it may lie behind."""

Parting = Annotated[float, Judged(lambda x: "" if x > 0 else f"must be more than 0, not {x!r}")]
"""Distance at which two have parted, metres; it may be infinite."""


@dataclass(frozen=True, kw_only=True)
class Notice(Keyed):
    """Rule of noticing: a person notices the gantry inside `law` and approaching.

    A person notices once per approach. The approach is over when the two have parted by
    `parting` metres again, or, if `every` is given, that many seconds after the noticing. For
    `silent` seconds after the person's start and after being teleported nothing is noticed.
    """

    law: Scaled
    parting: Parting = 1.0
    every: Positive | None = None
    silent: NotNegative = 0.0


@dataclass(frozen=True, kw_only=True)
class RuleSet(Keyed):
    """The figures of a competition or a standard; times in seconds, lengths in metres.

    A violation is a person nearer to a robot than `gantry_law` requires, or nearer to a vehicle
    that moves than `agv_law` requires. What it does to the `machine` is one of

    - "none";
    - "stop": the machine stops at once and stands until the distance is enough for its top
      speed (a protective stop);
    - "disable": the gantry is disabled for `gantry_disabled` seconds, and the violation is a
      penalty. In the `grace` after that a violation neither disables nor is a penalty; while the
      gantry is still disabled it does both, and the time starts anew. AGVs drive on.

    What it does to the `person` is "none" or "teleport": they are put into the safe zone and wait
    there, `pause_after_violation` or `pause_after_agv`. With `report_every`, a person
    is notified of violations and teleported at most every so many seconds; one that still lasts
    then counts anew.

    Distances to an AGV are measured to the point that lies `agv_offset` along its lane from its
    centre. `laws` holds other laws for some machines, by their names or kinds.

    `reactions` are the times that people of a personality, by its name, wait between noticing the
    gantry and their next motion. Programs believe them as `reaction(Personality, Ms)`. A
    personality that is not among them waits as long as its program says.

    With `between_people` it is recorded where the bodies of two people are nearer to each other.
    """

    name: str
    summary: str = field(default="", compare=False)
    gantry_law: AnyLaw
    agv_law: AnyLaw
    agv_offset: Offset = 0.0
    notice: Notice
    machine: MachineMeasure = "disable"
    person: PersonMeasure = "teleport"
    gantry_disabled: Lasting = 8.0
    grace: NotNegative = 0.0
    report_every: Positive | None = None
    pause_after_violation: NotNegative = 8.0
    pause_after_agv: NotNegative = 8.0
    laws: Mapping[str, AnyLaw] = field(default_factory=dict, hash=False)
    between_people: Positive | None = None
    reactions: Mapping[str, NotNegative] = field(default_factory=dict, hash=False)

    def law_of(self, machine: MachineShape) -> AnyLaw:
        """Return the law that holds between people and `machine`.

        The one of its name in `laws`, else the one of its kind; else the one of its category,
        `gantry_law` for robots and `agv_law` for vehicles.
        """
        return self.law_and_key_of(machine)[1]

    def law_and_key_of(self, machine: MachineShape) -> tuple[str, AnyLaw]:
        """Return the law that holds between people and `machine`, and its key in a rules file."""
        for name in (machine.name, machine.kind):
            if name in self.laws:
                return f"laws.{name}", self.laws[name]
        if machine.category == "robot":
            return "gantry_law", self.gantry_law
        return "agv_law", self.agv_law

    def condition_of(self, machine: MachineShape) -> Condition:
        """Return the condition under which a person and `machine` violate the rules.

        A vehicle that stands violates nothing.
        """
        too_close = TooClose(self.law_of(machine))
        return Moving() & too_close if machine.category == "vehicle" else too_close

    def measured_at(self, machine: MachineShape) -> Point:
        """Return the point (x, y in metres from its axis) to which distances are measured."""
        if machine.category == "robot" or machine.direction is None:
            return (0.0, 0.0)
        along_x, along_y = machine.direction
        return (self.agv_offset * along_x, self.agv_offset * along_y)


_ARIAC_LAW = SeparationLaw(t1=1.0, t2=1.5, stopping=0.0, intrusion=1.0)

PAPER = RuleSet(
    name="paper",
    summary="ISO/TS 15066 distances for gantry and AGVs; noticed at twice the distance",
    gantry_law=_ARIAC_LAW,
    agv_law=_ARIAC_LAW,
    notice=Notice(law=Scaled(_ARIAC_LAW, 2.0)),
    gantry_disabled=8.0,
    pause_after_violation=8.0,
    pause_after_agv=8.0,
)
"""The rules as the paper on the competition has them."""

ARIAC2023 = RuleSet(
    name="ariac2023",
    summary="as the ARIAC 2023 competition ran it: 15 s disabled, AGVs at 2.1 m",
    gantry_law=_ARIAC_LAW,
    agv_law=FixedDistance(2.1),
    agv_offset=-0.2,  # the frame of its tray
    notice=Notice(
        law=Scaled(SeparationLaw(t1=1.0, t2=1.5, stopping=0.0, intrusion=1.2), 1.75, cap=5.0),
        parting=math.inf,
        every=20.0,
        silent=20.0,
    ),
    gantry_disabled=15.0,
    grace=10.0,
    report_every=10.0,
    pause_after_violation=10.0,
    pause_after_agv=5.0,
    # Both programs wait 1.5 s. Before `move_to_gantry` the competition waits another second.
    reactions={"helpful": 1.5, "antagonistic": 2.5},
)
"""The rules as the competition's software had them."""

OBSERVE = replace(
    PAPER,
    name="observe",
    summary="the distances of paper; violations are recorded and have no consequence",
    machine="none",
    person="none",
)
"""The distances of `PAPER`, without consequences."""

PROTECTIVE_STOP = replace(
    PAPER,
    name="protective_stop",
    summary="the distances of paper; a machine stops while somebody is too close",
    machine="stop",
    person="none",
)
"""Speed and separation monitoring as industry applies it: the machine stops, then goes on."""

RULE_SETS = {rules.name: rules for rules in (PAPER, ARIAC2023, OBSERVE, PROTECTIVE_STOP)}
"""The built-in rule sets by name."""


def rule_set(name: str) -> RuleSet:
    """Return the built-in rule set `name`; `ValueError` that names those there are."""
    try:
        return RULE_SETS[name]
    except KeyError:
        raise UserError(
            f"no rule set and no file is called {name!r}; {suggestion(name, RULE_SETS)}"
        ) from None
