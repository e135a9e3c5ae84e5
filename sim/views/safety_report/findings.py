"""Findings of a safety report: figures, violations, and exposure in zones."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

from floorplan import Floorplan

from ...record.incidents import Incident, Risk
from ...record.outcome import Outcome
from ...record.sampling import CellArray
from ...record.words import told_apart
from ..report_page import MissingExtraError
from .assumptions import counted
from .page import Facts, Part, Picture, Points, ReportTable, clock, metres, place

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ...core.body import MachineShape


INSTANTS = 3
"""So many of the worst violations are shown at the instant of their least margin."""

MOST_PANELS = 4
"""Distances of so many people are drawn over time."""

LONG = 4000
"""Pieces of motion from which on the paths of a run would cover each other."""

_MAPS: dict[Risk, tuple[str, str]] = {
    "margin": (
        "Least margin",
        "How much further apart than required people and machines were, at the worst: below 0 it"
        " was too near.",
    ),
    "time": (
        "Time nearer than required",
        "How long somebody was at each spot while too near to a machine.",
    ),
    "severity": (
        "Severity",
        "The highest speed of person and machine relative to each other while they were too near.",
    ),
}


def floor_picture(plan: Floorplan) -> list[Part]:
    """Return the floor with everything that has a name."""

    def draw() -> Figure:
        from ..plots import floorplan

        return floorplan(plan)

    words = "Obstacles are the darker the higher they are; zones are dashed, lanes dotted."
    return list(_drawn("The floor from above", words, "floor", draw))


def risk_pictures(
    plan: Floorplan,
    machines: Sequence[MachineShape],
    maps: Mapping[Risk, CellArray],
    count: int,
    name: str = "",
) -> list[Part]:
    """Return the maps of risk, with `count` violations in all.

    Those of time and severity only where somebody was too near for some time.
    """
    parts: list[Part] = []
    for of, found in maps.items():
        if of != "margin" and not found.any():
            continue

        def draw(of: Risk = of, found: CellArray = found) -> Figure:
            from ..plots.maps import drawn_risk

            return drawn_risk(plan, machines, found, of=of)

        parts += _drawn(*_MAPS[of], f"risk {of} {name}", draw)
    if len(parts) == 1 and isinstance(parts[0], Picture):
        why = (
            "Each violation was over at once, since the person was put elsewhere"
            if count
            else "Nobody was nearer to a machine than required"
        )
        parts.append(Points((f"{why}: there are no maps of time and severity.",)))
    return parts


def run_pictures(run: Outcome, worst: Sequence[Incident], name: str = "") -> list[Part]:
    """Return where everybody went in a run, the distances of the worst pairs, and instants."""
    parts: list[Part] = []
    dense = sum(len(motion.pieces) for motion in run.motions.values()) > LONG

    def paths() -> Figure:
        from ..plots import heat_map, trails

        return heat_map(run) if dense else trails(run)

    if run.scene.people:
        title, words = (
            ("Where people were", "The time for which each spot was under somebody's body.")
            if dense
            else ("Paths", "Where people and machines went, and where somebody was too close.")
        )
        parts += _drawn(title, words, f"paths {name}", paths)
    pairs = list(dict.fromkeys((one.person, one.machine) for one in worst))
    for person, machine in pairs[:MOST_PANELS]:
        parts += _distance(run, person, machine, name)
    parts += _instants(run, worst[:INSTANTS], name)
    return parts


def _distance(run: Outcome, person: str, machine: str, name: str) -> Iterator[Part]:
    def draw() -> Figure:
        from ..plots import separation

        return separation(run, person, machine)

    title = f"Distance of {person} to {machine}"
    words = "Over time, beside what the law required; where it was less is shaded."
    yield from _drawn(title, words, f"separation {person} {machine} {name}", draw)


def _instants(run: Outcome, worst: Sequence[Incident], name: str) -> Iterator[Part]:
    """Yield the floor at the instants at which violations began."""
    for k, one in enumerate(worst):
        title = f"{one.person} and {one.machine} at {clock(one.worst_at)}"
        # An instant before, since a person may be put elsewhere at once.
        before = max(0.0, one.worst_at - 1e-6)
        if one.worst_at - one.begin < 1e-6:
            distance, required = told_apart(one.distance, one.required)
            words = (
                f"As the violation at t = {one.begin:.2f} s begins: {distance} m apart where"
                f" {required} m are required."
            )
        else:
            apart = float(run.distance(one.person, one.machine, before))
            words = (
                f"The violation from t = {one.begin:.2f} s on at its worst, at t ="
                f" {one.worst_at:.2f} s: {apart:.2f} m apart, {-one.margin:.2f} m less than"
                " required."
            )

        def draw(one: Incident = one, before: float = before) -> Figure:
            from ..plots.paths import moment

            return moment(run, before, one.person, one.machine)

        yield from _drawn(title, words, f"moment {k} {name}", draw)


def _drawn(title: str, words: str, name: str, draw: Callable[[], Figure]) -> Iterator[Part]:
    """Yield a picture, or nothing where there is no matplotlib."""
    try:
        from ..plots.style import figure_element

        yield Picture(title, words, figure_element(draw(), name, f"{title}. {words}"))
    except MissingExtraError:
        return


MOST_INCIDENTS = 40
"""Violations that are listed one by one."""


def incidents_table(
    found: Sequence[Incident], count: int, rows: Sequence[int] | None = None
) -> ReportTable:
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
    return ReportTable(heads, lines, "", words if found else "There were none.", figures)


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
) -> ReportTable:
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
    return ReportTable(heads, rows, "", words, frozenset(range(1, 6)))


def _share(part: float, whole: float) -> str:
    return f"{100 * part / whole:.2f} %" if whole > 0 else "–"
