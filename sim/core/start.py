"""Conditions that people and orders wait for."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Start:
    """Condition that is waited for: a time (seconds), or something that happens.

    `part_placed` holds the fields a placed part must have (part, agv), `order_submitted` the
    order's name, `event` the kind of an event; it must happen for the `count`th time. Events
    that name a person count if that is `person`, or who waits if none is given. The `time` is None
    where something else is waited for.
    """

    time: float | None = 0.0
    part_placed: dict[str, str] | None = None
    order_submitted: str | None = None
    event: str | None = None
    count: int = 1
    person: str | None = None

    def __post_init__(self) -> None:
        waits = (self.part_placed, self.order_submitted, self.event) != (None, None, None)
        if waits and self.time == 0.0:
            object.__setattr__(self, "time", None)


AT_ONCE = Start()
"""The beginning of the trial."""
