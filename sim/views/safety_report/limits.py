"""Limits of a report: what the simulation does not say."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from ...core.rules import RuleSet
from ...core.scenario import Scenario
from ...machines.law_audit import in_words, short_laws
from .assumptions import NO_SOURCE
from .parts import Points
from .people import assumed

ALWAYS = (
    "This is no risk assessment (ISO 12100) and no certificate. It says what follows from the"
    " assumptions above, and nothing about how well they fit the plant.",
    "People do what their personalities say: programs, not measured behaviour. Somebody who"
    " stumbles, runs, climbs, kneels or reaches out is not in them.",
    "Bodies are discs on the floor, and distances are between centres: arms, loads and tools stick"
    " out of both. How near surfaces come is not in the figures.",
    "Machines move as their limits allow and as their controllers say: no drift, no failure of a"
    " brake, no loss of a load, no delay of a network, unless a trial has it.",
    "Sensors see everybody at all times, unless a trial has blackouts. What a protective device"
    " would have seen is not simulated.",
    "There is no contact: severity is a speed, not a force or a pressure, and ends where the"
    " distance is kept again.",
    "Only distances between people and machines are judged. Crushing, shearing, falling objects,"
    " electricity, noise and the like are not.",
)


def limits(
    rules: Iterable[RuleSet], scenarios: Iterable[Scenario], further: Iterable[str] = ()
) -> Points:
    """Return what can't be concluded from a report under these rules, of these trials."""
    found = [*further, *dict.fromkeys(_of_rules(rules)), *dict.fromkeys(_of_trials(scenarios))]
    return Points((*found, *ALWAYS))


def _of_rules(rules: Iterable[RuleSet]) -> Iterator[str]:
    for one in rules:
        if one.person == "teleport":
            yield (
                f"Under the rules {one.name} a person who was too close is put into the safe zone:"
                " a violation ends there, and how it would have gone on is not known."
            )
        if one.machine == "none":
            yield (
                f"Under the rules {one.name} a violation changes nothing: machines do not stop for"
                " people, unless their controllers do."
            )


def _of_trials(scenarios: Iterable[Scenario]) -> Iterator[str]:
    for one in scenarios:
        if short := short_laws(one):
            yield (
                "A law counts on shorter stops than machines may take: a person who keeps the"
                f" distance can still be reached. {in_words(short)}."
            )
        known = {*one.sources, *(["floorplan"] if one.floorplan.source else [])}
        missing = [name for name in assumed(one) if name not in known]
        if missing:
            yield f"There is {NO_SOURCE} for {', '.join(missing)} in the trial {one.name}."
        if any(person.recorded is not None for person in one.people):
            yield (
                "Those who were recorded walk as they were measured, whatever the machines do: they"
                " react to nothing that was not there when they were measured."
            )
