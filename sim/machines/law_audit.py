"""The audit of a rule set's laws: the stops that they count on, and the room that they ask for."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

from navigation import IntegralLaw, SeparationLaw, required_at_speeds

from ..core.scenario import Scenario
from ..safety.own_law import OwnLaw
from .kinds import models_of

FAR = 2.0
"""Sizes of a floor. A law that asks for more was probably meant in other units."""

_ROUNDING = 1e-9
"""Seconds or metres. A law that is short by less is not short."""


@dataclass(frozen=True)
class ShortLaw:
    """A law that states a shorter stop than its machine may take, in seconds and metres.

    `law` is its key in the rule set; `stopping` is None where the law computes it from `t2`.
    """

    machine: str
    law: str
    t2: float
    needed_t2: float
    stopping: float | None
    needed_stopping: float


def short_laws(trial: Scenario) -> tuple[ShortLaw, ...]:
    """Return the machines of `trial` for which the law states too short a stop.

    Only the two forms of ISO/TS 15066 state one, as `t2` and `stopping`: others are not judged.
    """
    plan, rules = trial.floorplan, trial.rules
    found = []
    for name, model in models_of(trial, own=False).items():
        key, law = rules.law_and_key_of(model.shape(name, plan))
        stop = model.longest_stop(plan)
        if stop is not None and isinstance(law, SeparationLaw | IntegralLaw):
            time, distance = stop
            stated = math.inf if law.stopping is None else law.stopping
            if time > law.t2 + _ROUNDING or distance > stated + _ROUNDING:
                found.append(ShortLaw(name, key, law.t2, time, law.stopping, distance))
    return tuple(found)


def far_laws(trial: Scenario) -> dict[str, float]:
    """Return the laws that ask for more room than there is, by their keys, and how much (metres).

    That is more than `FAR` times the diagonal of the floor, of somebody at the usual top speed
    near a machine that stands. Laws of one's own are not asked.
    """
    plan, rules = trial.floorplan, trial.rules
    west, south, east, north = plan.boundary.bounds
    room = FAR * math.hypot(east - west, north - south)
    laws = dict(
        rules.law_and_key_of(model.shape(name, plan))
        for name, model in models_of(trial, own=False).items()
    )
    asked = {
        key: required_at_speeds(law, plan.human.max_speed, 0.0)
        for key, law in laws.items()
        if not isinstance(law, OwnLaw)
    }
    return {key: metres for key, metres in asked.items() if metres > room}


def in_words(found: Iterable[ShortLaw]) -> str:
    """Return the stops that the laws state and those the machines need, rounded up to 0.01."""
    machines: dict[str, list[str]] = {}
    for short in found:
        stated = _stop(short.t2, short.stopping)
        needed = _stop(_rounded_up(short.needed_t2), _rounded_up(short.needed_stopping))
        machines.setdefault(f"{stated} (up to {needed} needed)", []).append(short.machine)
    return "; ".join(f"{', '.join(names)} {figures}" for figures, names in machines.items())


def _stop(time: float, distance: float | None) -> str:
    return f"{time:g} s" if distance is None else f"{time:g} s and {distance:g} m"


def _rounded_up(figure: float) -> float:
    return math.ceil(100 * figure - 1e-6) / 100
