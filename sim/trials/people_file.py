"""The people of a trial file: their keys and values, and what can be wrong with them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import cache, partial
from pathlib import Path
from typing import Annotated

from pydantic import Field, Strict, model_validator

import bdi
from floorplan import Document, Pair, Place, Positive, Problem, Strictly, standing_fault, suggestion

from .event_kinds import EVENT_KINDS
from .programs import EXTERNAL, find_program, load_program
from .trial import PersonalityChange, PersonEntry, Start, Trial

CONDITIONS = ("time", "part_placed", "order_submitted", "event")


class _PartPlaced(Strictly):
    part: str | None = None
    agv: str | None = None


class StartKeys(Strictly):
    """What is waited for."""

    time: Annotated[float, Strict(), Field(ge=0, allow_inf_nan=False)] | None = None
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

    name: Annotated[str, Field(min_length=1, pattern=r"^[A-Za-z][A-Za-z0-9_-]*$")]
    personality: str = "indifferent"
    start: StartKeys = StartKeys(time=0.0)
    changes: list[_ChangeKeys] = []
    at: Pair | None = None
    beliefs: list[str] = []
    radius: Positive | None = None
    max_speed: Positive | None = None
    max_acceleration: Positive | None = None


def people_of(entries: Sequence[PersonKeys], folder: Path) -> tuple[PersonEntry, ...]:
    """The people, with the programs found from `folder`; one that isn't there is left open.

    Each program is read once, however many people run it.
    """
    program_of = cache(partial(_program, folder=folder))
    return tuple(_person(keys, program_of) for keys in entries)


def _person(keys: PersonKeys, program_of: Callable[[str], bdi.Program | None]) -> PersonEntry:
    return PersonEntry(
        name=keys.name,
        personality=keys.personality,
        start=keys.start.start(),
        at=keys.at,
        beliefs=tuple(keys.beliefs),
        radius=keys.radius,
        max_speed=keys.max_speed,
        max_acceleration=keys.max_acceleration,
        program=program_of(keys.personality),
        changes=tuple(
            PersonalityChange(
                change.when.start(), change.personality, program_of(change.personality)
            )
            for change in keys.changes
        ),
    )


def person_problems(
    person: PersonEntry, trial: Trial, document: Document, k: int
) -> Iterator[Problem]:
    """What is wrong with the person at index `k`, beyond keys and types."""
    yield from _personality_problems(person, trial, document, k)
    plan = trial.floorplan
    if person.at is not None:
        if fault := standing_fault(plan, person.at, person.radius):
            yield document.problem(fault, "people", k, "at")
    elif plan.safe_zone is None:
        message = "the floorplan has no safe zone to start in; give at: [x, y]"
        yield document.problem(message, "people", k)
    elif fault := standing_fault(plan, plan.safe_zone.position, person.radius):
        yield document.problem(f"in the safe zone, {fault}", "people", k)
    for j, belief in enumerate(person.beliefs):
        try:
            bdi.parse_literal(belief)
        except bdi.ProgramError as why:
            yield document.problem(f"is not a belief: {why}", "people", k, "beliefs", j)


def _program(personality: str, folder: Path) -> bdi.Program | None:
    try:
        return load_program(personality, folder)
    except FileNotFoundError:
        return None  # `person_problems` tells, together with everything else


def _personality_problems(
    person: PersonEntry, trial: Trial, document: Document, k: int
) -> Iterator[Problem]:
    named: list[tuple[str, Place]] = [(person.personality, ("personality",))]
    named += [
        (change.personality, ("changes", j, "personality"))
        for j, change in enumerate(person.changes)
    ]
    external = [personality == EXTERNAL for personality, _ in named]
    if any(external) and len(named) > 1:
        message = f"nobody changes to or from {EXTERNAL!r}"
        yield document.problem(message, "people", k, "changes")
    for personality, place in named:
        try:
            if personality != EXTERNAL:
                find_program(personality, trial.folder)
        except FileNotFoundError as why:
            yield document.problem(str(why), "people", k, *place)
    waits: list[tuple[Start, Place]] = [(person.start, ("start",))]
    waits += [(change.when, ("changes", j, "when")) for j, change in enumerate(person.changes)]
    for start, place in waits:
        if start.event is not None and start.event not in EVENT_KINDS:
            hint = suggestion(start.event, EVENT_KINDS)
            message = f"no kind of event is called {start.event!r}; {hint}"
            yield document.problem(message, "people", k, *place, "event")
        names = [somebody.name for somebody in trial.people]
        if start.person is not None and start.person not in names:
            message = f"nobody is called {start.person!r}; {suggestion(start.person, names)}"
            yield document.problem(message, "people", k, *place, "person")
