"""People whose figures are drawn: each has their own, whoever else is there."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from random import Random
from typing import Any, TypeVar

from ..core.noticing import ALL_ROUND, drawn_figure
from ..core.scenario import PersonEntry, Scenario
from ..core.seeds import seed_of
from ..core.work import Duration

_Made = TypeVar("_Made", bound=Scenario)


def with_figures(scenario: _Made) -> _Made:
    """Return the scenario in which every figure of its people is a number."""
    people = tuple(_with_figures(entry, scenario.seed) for entry in scenario.people)
    return scenario if people == scenario.people else replace(scenario, people=people)


def _with_figures(entry: PersonEntry, seed: int) -> PersonEntry:
    if isinstance(entry.max_speed, tuple | Duration):
        speed = drawn_figure(entry.max_speed, seed, f"speed {entry.name}")
        entry = replace(entry, max_speed=speed)
    if entry.noticing == ALL_ROUND:
        return entry
    figures: dict[str, Any] = {
        name: drawn_figure(given, seed, f"{name} {entry.name}")
        for name in ("field_of_view", "reaction_time")
        for given in [getattr(entry.noticing, name)]
        if given is not None
    }
    return replace(entry, noticing=replace(entry.noticing, **figures))


def speed_of(entry: PersonEntry, usual: float) -> float:
    """Return the top speed (m/s) of somebody `with_figures`; `usual` is that of the floor."""
    speed = usual if entry.max_speed is None else entry.max_speed
    assert not isinstance(speed, tuple | Duration)
    return speed


def lag_of(entry: PersonEntry, seed: int) -> Callable[[], float] | None:
    """Return what gives the next lag (s) of somebody's agent; None if it has none.

    The lags are drawn from the trial's `seed` and the name alone.
    """
    lag = entry.agent_lag
    if lag is None:
        return None
    low, high = lag if isinstance(lag, tuple) else (lag, lag)
    return partial(Random(seed_of(seed, f"lag {entry.name}")).uniform, low, high)
