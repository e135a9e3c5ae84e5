"""Findings of runs in print: violations, and exposure to the zones of a floor."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from floorplan import Floorplan

from ...record.incidents import Incident
from .assumptions import counted
from .parts import Facts, Table, clock, metres, place

MOST_INCIDENTS = 40
"""Violations that are listed one by one."""


def incidents_table(
    found: Sequence[Incident], count: int, rows: Sequence[int] | None = None
) -> Table:
    """Return the worst of `count` violations; `rows` are the numbers of their runs in a study."""
    numbered = rows is not None
    heads = (
        *(("row",) if numbered else ()),
        *("from, s", "for, s", "who", "machine", "moved", "at, m", "zone"),
        *("distance at first, m", "required at first, m", "least margin, m", "least at, s"),
        *("relative speed, m/s", "led to"),
    )
    lines = [
        (
            *((str(rows[k]),) if rows is not None else ()),
            *(f"{one.begin:.3f}", f"{one.seconds:.3f}", one.person, one.machine, one.cause or "–"),
            *(place(*one.at), ", ".join(one.zones) or "–"),
            *(
                f"{one.distance:.3f}",
                f"{one.required:.3f}",
                metres(one.margin),
                f"{one.worst_at:.3f}",
            ),
            *(f"{one.severity:.2f}", "; ".join(one.led_to) or "nothing"),
        )
        for k, one in enumerate(found)
    ]
    first = 1 if numbered else 0
    figures = frozenset({*range(first), *(first + k for k in (0, 1, 7, 8, 9, 10, 11))})
    words = "By how much the distance fell short, the most first."
    if count > len(found):
        words += f" These are {len(found)} of {count:,}."
    return Table(heads, lines, "", words if found else "There were none.", figures)


def together(found: Iterable[Incident]) -> Facts:
    """Return what followed from violations, and how often."""
    counts: dict[str, int] = {}
    for one in found:
        for consequence in one.led_to or ("nothing",):
            kind = consequence.partition(" for ")[0].partition(" of ")[0]
            counts[kind] = counts.get(kind, 0) + 1
    rows = [(kind, counted(n, "time")) for kind, n in counts.items()]
    return Facts(rows, "What they led to")


def exposure_table(
    plan: Floorplan, zones: Mapping[str, Mapping[str, float]], on_floor: float, near: float
) -> Table:
    """Return how long people were in each zone, and how long nearer to a machine than required.

    `zones` has the figures of each by its name; `on_floor` and `near` (seconds) are those of all
    people on the whole floor.
    """
    rows = [
        (
            name,
            clock(one["time_occupied"]),
            _share(one["time_occupied"], on_floor),
            f"{one['entries']:,.0f}",
            f"{one['time_too_close']:,.2f}",
            _share(one["time_too_close"], one["time_occupied"]),
        )
        for name, one in zones.items()
    ]
    rows.append(("whole floor", clock(on_floor), "", "", f"{near:,.2f}", _share(near, on_floor)))
    words = "People's time is that of all of them together, of their centres."
    if not plan.zones:
        words += " The floor has no zones: with zones in its file there is a line for each."
    heads = ("zone", "people's time", "share", "entries", "too near, s", "share of the time there")
    return Table(heads, rows, "", words, frozenset(range(1, 6)))


def _share(part: float, whole: float) -> str:
    return f"{100 * part / whole:.2f} %" if whole > 0 else "–"
