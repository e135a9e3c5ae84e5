"""Intrusions of people into the fields of a machine, in continuous time, however short."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from .fields import FieldKind, FieldSet, ProtectiveFields
from .kernels.encounter import Encounter
from .kernels.fields import within_reach
from .motion import Motion


class Intrusion(NamedTuple):
    """Contact of a person with a field: from `begin` to `end` (seconds), while its set applies."""

    begin: float
    end: float
    field: FieldKind
    set: str


class FieldEntry(NamedTuple):
    """First contact of a person with a field: its time (seconds), the field, and its set."""

    t: float
    field: FieldKind
    set: str


def intrusions(
    fields: ProtectiveFields,
    machine: Motion,
    person: Motion,
    radius: float,
    begin: float,
    end: float,
    loaded: bool = False,
) -> tuple[Intrusion, ...]:
    """Return when a person's disc touches the fields of a machine.

    Parameters
    ----------
    fields : ProtectiveFields
        Fields of the machine.
    machine, person : Motion
        Motions of both. They are at rest before and after.
    radius : float
        Radius of the person, metres.
    begin, end : float
        Time span, s. The end may be infinite.
    loaded : bool, optional
        Whether the machine is loaded.

    Returns
    -------
    tuple of Intrusion
        Contacts in the order of their begins. A contact ends at the latest when another set
        begins to apply. The response time is not included.

    Notes
    -----
    No contact that is deeper than 1e-10 m is missed. Contacts may begin or end at jumps of motions.
    """
    contacts: list[Intrusion] = []
    for part in _parts(fields, machine, person, radius, (begin, end), loaded):
        for field, search in part.set.searches.items():
            for since, until in search.spans(part.encounter, radius, part.begin, part.end, False):
                until = end if until == part.last else until
                contacts.append(Intrusion(since, until, field, part.set.name))
    return tuple(sorted(contacts, key=lambda each: (each.begin, each.field)))


def first_intrusion(
    fields: ProtectiveFields,
    machine: Motion,
    person: Motion,
    radius: float,
    begin: float,
    end: float,
    loaded: bool = False,
    *,
    field: FieldKind | None = None,
) -> FieldEntry | None:
    """Return the first contact of a person's disc with the fields of a machine, or None.

    Parameters
    ----------
    fields, machine, person, radius, begin, end, loaded
        See `intrusions`.
    field : {"protective", "warning"}, optional
        Field to test. By default both. If both begin together, the protective field counts.
    """
    for part in _parts(fields, machine, person, radius, (begin, end), loaded):
        best: FieldEntry | None = None
        for kind, search in part.set.searches.items():
            if field in (None, kind):
                contacts = search.spans(part.encounter, radius, part.begin, part.end, True)
                if contacts and (best is None or contacts[0][0] < best.t):
                    best = FieldEntry(contacts[0][0], kind, part.set.name)
        if best is not None:
            return best
    return None


class _Part(NamedTuple):
    """Time span of an encounter (s) with one field set, and the time when both are at rest."""

    set: FieldSet
    begin: float
    end: float
    encounter: Encounter
    last: float


def _parts(
    fields: ProtectiveFields,
    machine: Motion,
    person: Motion,
    radius: float,
    within: tuple[float, float],
    loaded: bool,
) -> Iterator[_Part]:
    """Yield the parts of an encounter in which a field set applies."""
    begin, end = map(float, within)
    # Nothing changes after both have come to rest, so the last second represents all later ones.
    last = min(end, max(begin, machine.end, person.end) + 1.0)
    encounter = Encounter(person, machine)
    # Most people are out of the reach of all fields for most of the time.
    since, until = within_reach(encounter, fields.reach + radius, begin, last)
    if since <= until:
        for span in fields.applying(machine, since, until, loaded):
            if span.set is not None:
                yield _Part(span.set, span.begin, span.end, encounter, last)
