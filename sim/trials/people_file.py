"""The people of a trial file: their keys and values."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import Annotated

from pydantic import Field, Strict, model_validator

from floorplan import NotNegative, Pair, Positive, Strictly

from ..core.scenario import PersonalityChange, PersonEntry, TrialError
from ..core.start import Start
from ..people.programs import load_program
from .checks import CONDITIONS, NAME


class _PartPlaced(Strictly):
    part: str | None = None
    agv: str | None = None


class StartKeys(Strictly):
    """What is waited for."""

    time: NotNegative | None = None
    part_placed: _PartPlaced | None = None
    order_submitted: str | None = None
    event: str | None = None
    count: Annotated[int, Strict(), Field(ge=1)] = 1
    person: str | None = None

    @model_validator(mode="after")
    def _one_condition(self) -> StartKeys:
        given = self.model_fields_set
        if len(given & {*CONDITIONS}) != 1:
            raise ValueError(f"give one of {', '.join(CONDITIONS)}")
        if self.event is None and given & {"count", "person"}:
            raise ValueError("count and person belong to an event")
        return self

    def start(self) -> Start:
        """The same as a value."""
        placed = self.part_placed
        return Start(
            self.time,
            placed.model_dump(exclude_none=True) if placed else None,
            self.order_submitted,
            self.event,
            self.count,
            self.person,
        )


class _ChangeKeys(Strictly):
    when: StartKeys
    personality: str


class PersonKeys(Strictly):
    """One person."""

    name: Annotated[str, Field(pattern=f"^{NAME}$")]
    personality: str = "indifferent"
    start: StartKeys = StartKeys(time=0.0)
    changes: list[_ChangeKeys] = []
    at: Pair | None = None
    home: Pair | None = None
    beliefs: list[str] = []
    radius: Positive | None = None
    max_speed: Positive | None = None
    max_acceleration: Positive | None = None


def people_of(entries: Sequence[PersonKeys], folder: Path) -> tuple[PersonEntry, ...]:
    """The people, with the programs found from `folder`; one that isn't there is left open.

    Each program is read once, however many people run it.
    """
    people = tuple(map(_person, entries))
    changes = [change.personality for keys in entries for change in keys.changes]
    for personality in dict.fromkeys([*(keys.personality for keys in entries), *changes]):
        # One that isn't there is told together with everything else that is wrong.
        with suppress(TrialError):
            load_program(personality, folder)
    return people


def _person(keys: PersonKeys) -> PersonEntry:
    return PersonEntry(
        name=keys.name,
        personality=keys.personality,
        start=keys.start.start(),
        at=keys.at,
        home=keys.home,
        beliefs=tuple(keys.beliefs),
        radius=keys.radius,
        max_speed=keys.max_speed,
        max_acceleration=keys.max_acceleration,
        changes=tuple(
            PersonalityChange(change.when.start(), change.personality) for change in keys.changes
        ),
    )
