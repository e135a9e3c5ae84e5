"""The audit of a rule set's laws: they must not count on shorter stops than machines can make."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

from navigation import IntegralLaw, SeparationLaw

from ..core.scenario import Scenario
from .kinds import models_of

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
