"""Doubts about the programs of people: actions that nobody has, and percepts misspelt."""

from __future__ import annotations

import bdi

from ..core.scenario import Scenario
from .actions import numbers_of_arguments
from .own_actions import modules_of
from .programs import load_program
from .regard import PERCEPTS


def doubts_in(scenario: Scenario) -> tuple[bdi.Problem, ...]:
    """Return what is doubtful in the programs of all people of a trial."""
    used = {
        (personality, modules_of(person.actions, scenario.actions)): None
        for person in scenario.people
        for personality in (person.personality, *(one.personality for one in person.changes))
    }
    programs = [
        load_program(personality, scenario.folder, modules, own_code=scenario.own_code)
        for personality, modules in used
    ]
    found = (doubt for one in programs if one is not None for doubt in doubts_of(one))
    return tuple(dict.fromkeys(found))


def doubts_of(program: bdi.Program) -> tuple[bdi.Problem, ...]:
    """Return what a person who runs the program probably does not do as its author meant it."""
    triggers = (plan.trigger for name in bdi.programs() for plan in bdi.load(name).plans)
    events = {one.literal.functor for one in triggers if not one.kind}  # type: ignore[union-attr]
    events |= {*PERCEPTS}
    return bdi.doubts(program, actions=numbers_of_arguments(), events=sorted(events))
