"""Rule sets: which distances are kept between people and machines, and what follows if not."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from floorplan import suggestion
from navigation import AnyLaw, FixedDistance, Scaled, SeparationLaw


@dataclass(frozen=True, kw_only=True)
class Notice:
    """When a person notices the gantry: inside `law` and getting closer.

    A person is told once per approach. The approach is over when the two have parted by
    `parting` metres again, or, if `every` is given, that many seconds after the telling.
    """

    law: Scaled
    parting: float = 1.0
    every: float | None = None


@dataclass(frozen=True, kw_only=True)
class RuleSet:
    """The figures of a competition or a standard; times in seconds.

    A violation between a person and the gantry costs a penalty and disables the gantry for
    `gantry_disabled`; for `grace` after that, a new one costs nothing. The person is put into
    the safe zone and waits `pause_after_violation`. Near an AGV that moves the person is put
    there as well, without penalty, and waits `pause_after_agv`.
    """

    name: str
    summary: str = field(default="", compare=False)
    gantry_law: AnyLaw
    agv_law: AnyLaw
    notice: Notice
    gantry_disabled: float
    grace: float = 0.0
    pause_after_violation: float
    pause_after_agv: float


_ARIAC_LAW = SeparationLaw(t1=1.0, t2=1.5, stopping=0.0, intrusion=1.0)

PAPER = RuleSet(
    name="paper",
    summary="ISO/TS 15066 distances for gantry and AGVs; noticed at twice the distance",
    gantry_law=_ARIAC_LAW,
    agv_law=_ARIAC_LAW,
    notice=Notice(law=Scaled(_ARIAC_LAW, 2.0)),
    gantry_disabled=8.0,
    pause_after_violation=8.0,
    pause_after_agv=5.0,
)
"""The rules as the paper on the competition has them."""

ARIAC2023 = RuleSet(
    name="ariac2023",
    summary="as the ARIAC 2023 competition ran it: 15 s disabled, AGVs at 2.1 m",
    gantry_law=_ARIAC_LAW,
    agv_law=FixedDistance(2.1),
    notice=Notice(
        law=Scaled(SeparationLaw(t1=1.0, t2=1.5, stopping=0.0, intrusion=1.2), 1.75, cap=5.0),
        parting=math.inf,
        every=20.0,
    ),
    gantry_disabled=15.0,
    grace=10.0,
    pause_after_violation=10.0,
    pause_after_agv=5.0,
)
"""The rules as the competition's software had them."""

RULE_SETS = {rules.name: rules for rules in (PAPER, ARIAC2023)}
"""The built-in rule sets by name."""


def rule_set(name: str) -> RuleSet:
    """The rule set called `name`; `ValueError` that names those there are."""
    try:
        return RULE_SETS[name]
    except KeyError:
        raise ValueError(
            f"no rule set and no file is called {name!r}; {suggestion(name, RULE_SETS)}"
        ) from None
