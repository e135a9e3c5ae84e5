"""Parameters of avoidance: those of the algorithm, and the manners of a person."""

from __future__ import annotations

from dataclasses import field, fields
from random import Random
from typing import TypeVar

from floorplan.files.dataclass import dataclass

from ...core.entries import AS_USUAL, MannersEntry, Side, seed_of

Number = TypeVar("Number", int, float)


def _of(default: Number, unit: str, source: str) -> Number:
    """Return the field of a parameter with its default, unit and source."""
    parameter: Number = field(default=default, metadata={"unit": unit, "source": source})
    return parameter


@dataclass(frozen=True, kw_only=True)
class AvoidanceParameters:
    """Parameters of the decisions of all people, each with default, unit and source.

    The sources are experiments on random crowds (`benchmarks/random_crowds.py`), on jams
    (`tests/test_sim/test_crowd_scenes.py`) and on a patrol of 50 people.
    """

    gap: float = _of(0.006, "m", "above the rounding of positions on floors of 1 km")
    """Distance that two bodies always keep."""

    # Decisions
    early: float = _of(0.25, "s", "time to decide before the start of braking; chosen, not varied")
    """Time before the start of braking at which a person decides again."""
    apart: float = _of(0.5, "s", "at most two changes of motion in one second")
    """Minimum time between two decisions of a person."""
    keeps: float = _of(1.0, "s", "chosen, not varied")
    """Minimum time for which a person keeps a motion other than the preferred one."""
    again: float = _of(2.0, "s", "chosen, not varied")
    """Maximum time until that person looks for a better motion."""
    reports: float = _of(0.1, "s", "chosen, not varied")
    """Time until a person alone who stands at the goal already has arrived."""
    worth: float = _of(0.6, "m", "two people head-on in an aisle of 1.5 m")
    """Loss of one person above which two people look for a shift of both."""

    # Candidate courses
    abreast_inside: int = _of(2, "people", "an aisle that one person fills")
    """Number of people abreast below which a place is narrow for the people in it."""
    abreast_outside: int = _of(3, "people", "two abreast leave no room for oncoming people")
    """Number of people abreast below which a place is narrow for the people outside of it."""
    farthest: float = _of(25.0, "m", "longer than the aisles of the built-in floors")
    """Distance along a course at which the search for the end of a narrow place stops."""
    looks_around: float = _of(2.0, "m", "wider than a shift past a person")
    """Margin around the preferred motion within which people are observed."""
    widths: tuple[float, ...] = (-0.45, 0.45, -0.9, 0.9, -1.35, 1.35)
    """Shifts besides those just past a person, m. Corner of 2 m: 20 % less time lost."""
    detours: tuple[float, ...] = (-2.0, 2.0, -2.8, 2.8, -3.6, 3.6)
    """Wide shifts of a stationary person to the left, m. 60 random crowds: no clear effect."""
    widest: float = _of(3.6, "m", "widest detour")
    """Maximum shift."""
    paces: tuple[float, ...] = (0.75, 0.5, 0.25)
    """Shares of the top speed that are tried. 60 random crowds: no clear effect."""
    delays: tuple[float, ...] = (0.5, 1.0, 2.0, 4.0)
    """Delays of a start, s. 60 random crowds: no clear effect."""
    parts: tuple[float, ...] = (1.0, 0.8, 0.6, 0.4, 0.2)
    """Shares of the free stretch at which a stop is tried. Patrol: 977 legs, 668 without."""
    shortest: float = _of(0.5, "m", "chosen, not varied")
    """Minimum length of a walk that starts from rest."""
    phantom: float = _of(0.1, "1", "patrol of 10: 5 % fewer legs with 0.3")
    """Share of its loss that a stop behind a person about to walk on counts."""
    files: tuple[float, ...] = (0.25, 0.5, 1.0, 1.5, 2.0, 2.5)
    """Shifts at which a follower looks for a faster file, m."""
    faster: float = _of(0.15, "m/s", "chosen, not varied")
    """Gain in speed for which a person leaves a file."""
    beside_after: float = _of(0.4, "1", "chosen, not varied")
    """Share of the foresight after which that person walks in the other file."""
    past: float = _of(0.3, "m", "chosen, not varied")
    """Distance past an oncoming person at which a stop beside is allowed."""
    other_side: float = _of(0.15, "m", "share of people who pass on the right, Moussaïd 2009")
    """Loss of passing on the unusual side."""
    brush: float = _of(0.5, "m", "chosen, not varied")
    """Loss of a motion within the comfort distance of others."""
    alike: float = _of(0.3, "1", "chosen, not varied")
    """Cosine above which two people walk the same way."""
    closes_in: float = _of(1.0, "s", "single file, Seyfried 2005")
    """Time in which a follower reaches the distance of the time gap."""
    sees: float = _of(0.5, "s", "single file, Seyfried 2005")
    """Time over which the speed of the person ahead is averaged."""
    least_speed: float = _of(0.05, "m/s", "slower people are stationary")
    """Minimum speed of a follower."""
    same_way: float = _of(0.7, "1", "45 degrees")
    """Cosine above which one person follows another."""
    closes_up: float = _of(1.5, "m", "aisles for two")
    """Lateral distance of oncoming people at which followers close up."""

    # Escalation
    pause: float = _of(1.0, "s", "chosen, not varied")
    """First pause between two searches of a blocked person. Each is twice as long as the last."""
    longest_pause: float = _of(8.0, "s", "chosen, not varied")
    """Maximum pause between two searches."""
    in_reach: float = _of(1.25, "m", "patrol: two bodies and the width of a third")
    """Distance from an occupied goal at which a blocked person has arrived."""
    beside: float = _of(6.0, "m", "patrol: 977 legs, 800 without the ring")
    """Distance from a goal at which a person has arrived behind a closed ring of people."""
    at_the_door: float = _of(1.0, "m", "width of a door")
    """Distance from a source or sink at which people enter and leave."""
    detour_around: float = _of(6.0, "m", "chosen, not varied")
    """Margin around start and goal within which stationary people are bypassed."""
    detour_costs: float = _of(8.0, "s", "chosen, not varied")
    """Time that a detour around stationary people may cost beyond the time stood."""
    strays: float = _of(15.0, "s", "chosen, not varied")
    """Time of walking without coming nearer to the goal after which a person takes a detour."""
    nearer: float = _of(0.1, "m", "chosen, not varied")
    """Decrease of the length of a course by which a person comes nearer."""
    rank_counts: float = _of(25.0, "s", "chosen, not varied")
    """Time after which a blocked person may also ask people of higher rank."""
    deadlock: float = _of(30.0, "s", "chosen, not varied")
    """Time without any change of motion after which blocked people are in deadlock."""

    # Requests to make room
    longest_chain: int = _of(10, "people", "chosen, not varied")
    """Maximum length of a chain of requests."""
    most_moved: int = _of(24, "people", "chosen, not varied")
    """Maximum number of people who move for one request."""
    wide: int = _of(12, "courses", "chosen, not varied")
    """Maximum number of retreats that one person tries."""
    tries: int = _of(200, "courses", "40 random crowds: 18 % less time lost than with 60")
    """Maximum number of retreats that all people try for one request."""
    passed: float = _of(1.0, "m", "chosen, not varied")
    """Distance beyond the blocking person that the asker wants to reach."""
    lane: float = _of(1.0, "m", "distance of corners in a bend of 1 m")
    """Distance between the points of a course beside the asker's own."""
    stride: float = _of(0.25, "m", "less than the radius of a body")
    """Distance between positions on a course at which people look for a retreat."""
    shifts: tuple[float, ...] = (-0.45, 0.45, -0.9, 0.9, -0.2, 0.2)
    """Shifts of an asker's course to the left, m."""
    waits: tuple[float, ...] = (0.0, 0.5, 1.0, 2.0, 4.0)
    """Times for which an asker waits until the others have moved, s."""
    rings: tuple[float, ...] = (0.1, 0.3, 0.5, 0.7, 1.0, 1.4, 2.0, 2.8)
    """Distances at which people look for a place to step aside, m.

    A step of 0.1 m opens an arch: two people touch in a door, and a third stands close behind.
    """
    angles: int = _of(16, "directions", "chosen, not varied")
    """Number of directions in which people look for such a place."""

    # Vehicles
    alarm: float = _of(5.0, "s", "random trials in an open hall")
    """Time before a vehicle comes at which a person in its way steps aside."""
    hurry: float = _of(2.5, "s", "time to stop, turn and leave the width of a vehicle")
    """Time before a vehicle comes up to which a person in its way may still arrive first."""
    stays: float = _of(5.0, "s", "random trials in an open hall")
    """Time for which a person may stand in a place before a vehicle comes there."""
    berth: float = _of(0.3, "m", "60 open halls")
    """Distance that a person keeps from a vehicle while stepping aside, beyond the usual one."""
    escape: float = _of(5.0, "m", "as far as people walk until the vehicle comes")
    """Maximum distance of a step aside."""
    raster: float = _of(0.25, "m", "less than the radius of a body")
    """Distance of the places that are tried."""
    stops_after: tuple[float, ...] = (0.0, 0.5, 1.0, 2.0, 4.0)
    """Times after which a walking person stops to step aside, s."""

    # Interruptions
    clear_time: float = _of(0.1, "s", "a tenth of a meter at walking speed")
    """Time between the stops that are tried before a closed place."""
    foresees: float = _of(0.5, "s", "half a meter at walking speed")
    """Time between points of a recorded motion from which people step aside."""


PARAMETERS = AvoidanceParameters()
"""The parameters of all simulations."""


@dataclass(frozen=True, kw_only=True)
class Manners:
    """Parameters of one person, as given under the key `manners` of a trial.

    Parameters
    ----------
    comfort : float
        Distance between bodies that the person keeps if there is room, m.
    time_gap : float
        Time gap to the person ahead, s. The distance between the bodies is the speed times this
        gap, as in single file [2]_.
    foresight : float
        How far ahead the person commits to a motion, s.
    reaction_time : float
        Time for which the person waits behind another before asking to pass, s, near the 0.5 s
        in [3]_.
    patience : float
        Time for which the person stands blocked before perceiving `blocked`, s.
    passing_side : {"right", "left"}
        Preferred passing side if both are equally good. People keep right in much of Europe [1]_.
    steps_aside : bool
        Whether the person steps aside on request.

    References
    ----------
    .. [1] M. Moussaïd et al., "Experimental study of the behavioural mechanisms underlying
       self-organization in human crowds", Proc. R. Soc. B 276, 2009.
    .. [2] A. Seyfried et al., "The fundamental diagram of pedestrian movement revisited",
       J. Stat. Mech. P10002, 2005.
    .. [3] M. Moussaïd et al., "How simple rules determine pedestrian behavior and crowd
       disasters", PNAS 108, 2011.
    """

    comfort: float = 0.1
    time_gap: float = 1.0
    foresight: float = 5.0
    reaction_time: float = 0.4
    patience: float = 10.0
    passing_side: Side = "right"
    steps_aside: bool = True


USUAL = Manners()
"""Manners of a person without the key `manners`."""


def drawn(entry: MannersEntry, seed: int, name: str) -> Manners:
    """Return the manners of a person, with ranges drawn uniformly.

    The values depend only on the trial's `seed` and the person's `name`.
    """
    if entry == AS_USUAL:
        return USUAL
    random = Random(seed_of(seed, f"manners {name}"))
    values = {}
    for one in fields(entry):
        value = getattr(entry, one.name)
        if isinstance(value, tuple):
            value = random.uniform(*value)
        if value is not None:
            values[one.name] = value
    return Manners(**values)
