"""Rule sets: required distances between people and machines, and consequences of violations."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import field, replace
from typing import Annotated, Literal

from floorplan import Point, UserError
from floorplan.files.dataclass import dataclass
from floorplan.files.fields import LARGEST, Fits, Keyed, NotNegative, Number, Positive
from floorplan.files.problems import suggestion
from navigation import (
    Condition,
    Cylinder,
    FixedDistance,
    Moving,
    Scaled,
    SeparationLaw,
    Shapes,
    TooClose,
)
from navigation.encounter import PERSON_RADIUS
from navigation.separation import AnyLaw

from .body import FLAT, MachineShape

MachineMeasure = Literal["none", "stop", "disable"]
"""Consequence of a violation for the machine."""

Between = Literal["centres", "surfaces"]
"""Where distances between people and machines begin and end."""

PersonMeasure = Literal["none", "teleport"]
"""Consequence of a violation for the person."""

NO_TIME = "must be more than 0; for violations that leave the machine alone say machine: none"
"""Error message of a rule set that disables the gantry for no time."""


Lasting = Annotated[NotNegative, Fits(lambda seconds: "" if seconds else NO_TIME)]
"""Duration in seconds for which a machine is disabled."""

Offset = Annotated[
    Number,
    Fits(lambda x: "" if abs(x) <= LARGEST else f"must be a length in metres, not {x!r}"),
]
"""Offset along a lane in metres. Negative is backwards."""

Parting = Annotated[float, Fits(lambda x: "" if x > 0 else f"must be more than 0, not {x!r}")]
"""Distance in metres at which an approach ends. It may be infinite."""


@dataclass(frozen=True, kw_only=True)
class Notice(Keyed):
    """Rule of noticing: a person notices the gantry that approaches and is inside `law`.

    A person notices it once per approach. An approach ends when the distance has grown by `parting`
    (m), or `every` (s) after it was noticed. For `silent` (s) after the start and after a teleport,
    nothing is noticed.
    """

    law: Scaled
    parting: Parting = 1.0
    every: Positive | None = None
    silent: NotNegative = 0.0


@dataclass(frozen=True, kw_only=True)
class RuleSet(Keyed):
    """Separation rules of a competition or standard, with their consequences.

    A violation is a distance less than `gantry_law` requires from a robot, or less than `agv_law`
    requires from a moving vehicle.

    Parameters
    ----------
    name : str
        Name.
    summary : str, optional
        Description in one line.
    gantry_law, agv_law : SeparationLaw or other law
        Laws for robots and for vehicles.
    agv_offset : float, optional
        Distances to an AGV are measured to the point this far (m) from its centre along its lane.
    between : {"centres", "surfaces"}, optional
        Whether distances are measured between centres, or between the surfaces of machines and
        people on the floor. Then a vehicle that turns on the spot moves, and `agv_offset` is
        ignored.
    notice : Notice
        Condition under which people notice the gantry.
    machine : {"none", "stop", "disable"}, optional
        Consequence for the machine. "stop" is a protective stop until the distance suffices for its
        top speed. "disable" is a penalty that disables the gantry. AGVs continue.
    person : {"none", "teleport"}, optional
        Consequence for the person. "teleport" puts the person into the safe zone to wait there.
    gantry_disabled : float, optional
        Duration in seconds for which the gantry is disabled. A violation in this time is another
        penalty, and the duration starts again.
    grace : float, optional
        Duration in seconds after that in which violations have no consequences for the gantry.
    report_every : float, optional
        Minimum time in seconds between two notifications and teleports of a person. A violation
        that lasts longer counts again.
    pause_after_violation, pause_after_agv : float, optional
        Waiting time in seconds of a person after a violation with a robot or vehicle.
    laws : mapping, optional
        Laws for some machines, by their names or kinds.
    between_people : float, optional
        Distance in metres between the bodies of two people below which encounters are recorded.
    reactions : mapping, optional
        Time in seconds between noticing the gantry and the next motion, by personality. Programs
        believe it as `reaction(Personality, Ms)`. By default it is defined by the program.
    """

    name: str
    summary: str = field(default="", compare=False)
    gantry_law: AnyLaw
    agv_law: AnyLaw
    agv_offset: Offset = 0.0
    between: Between = "centres"
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
        """Return the law that applies between people and a machine.

        It is the law in `laws` for its name or its kind, or otherwise that for its category.

        Parameters
        ----------
        machine : MachineShape
            The machine.
        """
        return self.law_and_key_of(machine)[1]

    def law_and_key_of(self, machine: MachineShape) -> tuple[str, AnyLaw]:
        """Return the key in a rules file of the law for a machine, and the law.

        Parameters
        ----------
        machine : MachineShape
            The machine.
        """
        for name in (machine.name, machine.kind):
            if name in self.laws:
                return f"laws.{name}", self.laws[name]
        if machine.category == "robot":
            return "gantry_law", self.gantry_law
        return "agv_law", self.agv_law

    def condition_of(self, machine: MachineShape) -> Condition:
        """Return the condition under which a person and a machine violate the rules.

        Stationary vehicles cause no violation. Between surfaces, vehicles that turn do.

        Parameters
        ----------
        machine : MachineShape
            The machine.
        """
        too_close = TooClose(self.law_of(machine))
        if machine.category != "vehicle":
            return too_close
        shapes = self.shapes_of(machine, PERSON_RADIUS)
        return Moving(reach=0.0 if shapes is None else shapes.reach) & too_close

    def shapes_of(self, machine: MachineShape, radius: float) -> Shapes | None:
        """Return the solids between which distances are measured, or None between centres.

        Parameters
        ----------
        machine : MachineShape
            The machine.
        radius : float
            Radius of the person in metres.
        """
        if self.between == "centres":
            return None
        person = Cylinder(radius=radius, top=FLAT)
        return Shapes(person=person, machine=machine.silhouette)

    def measured_at(self, machine: MachineShape) -> Point:
        """Return the point (x, y), in metres from the axis, to which distances are measured.

        Parameters
        ----------
        machine : MachineShape
            The machine.
        """
        if self.between == "surfaces" or machine.category == "robot" or machine.direction is None:
            return (0.0, 0.0)
        along_x, along_y = machine.direction
        return (self.agv_offset * along_x, self.agv_offset * along_y)


_ARIAC_LAW = SeparationLaw(t1=1.0, t2=1.5, stopping=0.0, intrusion=1.0)

PAPER = RuleSet(
    name="paper",
    summary="ISO/TS 15066 distances for gantry and AGVs, which people notice at twice the distance",
    gantry_law=_ARIAC_LAW,
    agv_law=_ARIAC_LAW,
    notice=Notice(law=Scaled(_ARIAC_LAW, 2.0)),
    gantry_disabled=8.0,
    pause_after_violation=8.0,
    pause_after_agv=8.0,
)
"""Rules of the paper on the competition."""

ARIAC2023 = RuleSet(
    name="ariac2023",
    summary="ARIAC 2023 software: gantry disabled for 15 s, 2.1 m from AGVs",
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
"""Rules of the competition's software."""

OBSERVE = replace(
    PAPER,
    name="observe",
    summary="distances of paper, but violations are only recorded",
    machine="none",
    person="none",
)
"""Distances of `PAPER` without consequences."""

PROTECTIVE_STOP = replace(
    PAPER,
    name="protective_stop",
    summary="distances of paper, but a machine stops while a person is too close",
    machine="stop",
    person="none",
)
"""Speed and separation monitoring as in industry: the machine stops, then continues."""

RULE_SETS = {rules.name: rules for rules in (PAPER, ARIAC2023, OBSERVE, PROTECTIVE_STOP)}
"""Built-in rule sets by name."""


def rule_set(name: str) -> RuleSet:
    """Return the built-in rule set `name`. `UserError` for an unknown name."""
    try:
        return RULE_SETS[name]
    except KeyError:
        raise UserError(
            f"no rule set and no file is called {name!r}; {suggestion(name, RULE_SETS)}"
        ) from None
