"""Protective fields of a machine in a trial: field sets, response, restart and muting."""

from __future__ import annotations

import math
from dataclasses import KW_ONLY
from functools import cached_property
from typing import Annotated, Any

from pydantic import model_validator

from floorplan.files.dataclass import dataclass
from floorplan.files.fields import LARGEST, Fits, Keyed, NotNegative, Positive
from navigation import FieldSet, ProtectiveFields
from navigation.fields import UNBOUNDED

from .schedule import Interval

LEAST_DELAY = 0.01
"""Seconds. Minimum restart delay: a machine that restarts at once would stop at once again."""


def keys_of_set(one: FieldSet) -> dict[str, Any]:
    """Return the keys of a field set in a file. Keys with their defaults are omitted."""
    keys: dict[str, Any] = {"name": one.name}
    for key in ("linear", "theta", "direction"):
        if (ends := getattr(one, key)) not in (UNBOUNDED, None):
            keys[key] = [min(max(end, -LARGEST), LARGEST) for end in ends]
    if one.load is not None:
        keys["load"] = one.load
    keys["protective"] = [[*corner] for corner in one.protective]
    if one.warning:
        keys["warning"] = [[*corner] for corner in one.warning]
    return keys


@dataclass(frozen=True)
class Muting(Keyed):
    """Muting of the fields of a machine. Muted fields are ignored.

    Parameters
    ----------
    zones : tuple of str, optional
        Names of zones of the floor in which the axis of the machine must be.
    times : tuple of (float, float), optional
        Time spans in seconds.
    """

    zones: tuple[str, ...] = ()
    _: KW_ONLY
    times: tuple[Interval, ...] = ()

    @model_validator(mode="before")
    @classmethod
    def _only_zones(cls, value: Any) -> Any:
        return {"zones": value} if isinstance(value, list | tuple) else value


def _long_enough(seconds: float) -> str:
    return "" if seconds >= LEAST_DELAY else f"must be at least {LEAST_DELAY} s, not {seconds:g}"


@dataclass(frozen=True, kw_only=True)
class MachineFields(Keyed):
    """Protective fields of a machine, which stop and slow it below its controller.

    Parameters
    ----------
    sets : tuple of navigation.FieldSet
        Field sets in the order of their priority.
    response_time : float, optional
        Time in seconds from the intrusion to the begin of braking.
    restart_delay : float, optional
        Time in seconds for which the fields must be free before the machine continues.
    warning_speed : float, optional
        Top speed in m/s while the warning field is occupied.
    muting : Muting, optional
        Zones and time spans in which the fields are muted.
    """

    sets: tuple[FieldSet, ...]
    response_time: NotNegative = 0.2
    restart_delay: Annotated[Positive, Fits(_long_enough)] = 2.0
    warning_speed: Positive = 0.3
    muting: Muting = Muting()

    @cached_property
    def protective(self) -> ProtectiveFields:
        """Field sets with the response time. `UserError` if they do not fit together."""
        return ProtectiveFields(sets=self.sets, response_time=self.response_time)

    @property
    def reach(self) -> float:
        """Largest distance in metres of a corner from the axis of the machine."""
        return max(
            math.hypot(*corner) for one in self.sets for corner in (*one.protective, *one.warning)
        )
