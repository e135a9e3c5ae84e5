"""Pages of safety reports: figures in words, pictures of findings, and HTML or PDF files."""

from __future__ import annotations

import math
import re
import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from floorplan import Floorplan

from ..core.wording import (
    clock,
    counted,
    distinguished,
    figure,
    minus,
    percent,
    signed,
    to_millimetres,
)
from ..record.incidents import CELL, Incident, Risk
from ..record.outcome import Outcome
from ..record.output import replacing, writing
from ..record.sampling import MOMENT, CellArray
from .film import in_browser, open_page, require_browser
from .report_page import MissingExtraError, require_place, write_report_page

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from playwright.sync_api import Browser

    from ..core.body import MachineShape


def metres(length: float) -> str:
    """Return a length or a margin (m) to a millimetre, with a minus sign."""
    return minus(to_millimetres(length))


def incident_rows(violations: Sequence[Incident], numbers: Sequence[int] | None) -> list[list[str]]:
    """Return a line for each violation, after the number of its run if there are several."""
    rows = [
        [
            *(f"{one.begin:.3f}", f"{one.seconds:.3f}", one.person, one.machine, one.cause or "–"),
            *(
                minus(f"({one.at[0]:.2f},\u00a0{one.at[1]:.2f})"),
                ", ".join(one.zones) or "–",
                f"{one.distance:.3f}",
            ),
            *(f"{one.required:.3f}", metres(one.margin), f"{one.worst_at:.3f}"),
            *(f"{one.severity:.2f}", "; ".join(one.led_to) or "nothing"),
        ]
        for one in violations
    ]
    if numbers is None:
        return rows
    return [[str(number), *row] for number, row in zip(numbers, rows, strict=True)]


def print_page(page: Path, path: Path) -> None:
    """Print the HTML file `page` to the PDF `path`."""

    def printed(browser: Browser) -> None:
        open_page(browser, page).pdf(path=target, prefer_css_page_size=True, print_background=True)

    with writing(path), replacing(path) as target:
        in_browser("a PDF", printed)


ENDINGS = (".html", ".pdf")
"""Suffixes of files that a report can be written to."""


def require_writable(path: Path) -> None:
    """Raise the errors of an unwritable report before it is made.

    `ValueError` if the suffix is neither .html nor .pdf, `OutputError` if the folder is missing,
    `MissingExtraError` if a PDF cannot be printed.
    """
    require_place(path, "report", ENDINGS)
    if path.suffix.lower() == ".pdf":
        require_browser("a PDF")


def write_safety_page(path: Path, template: str, **values: Any) -> None:
    """Write a report to `path` as HTML or, with a browser, as PDF.

    `template` is one of `data/report`, which gets the `values`.
    """
    if path.suffix.lower() != ".pdf":
        _write(path, template, values)
        return
    with tempfile.TemporaryDirectory() as folder:
        page = Path(folder) / "report.html"
        _write(page, template, values)
        print_page(page, path)


def _write(path: Path, template: str, values: Mapping[str, Any]) -> None:
    shared = {"titles": [], "infinity": math.inf, "moment": MOMENT, "cell": CELL}
    write_report_page(path, template, _FILTERS, **shared, **values)


def _anchor(title: str) -> str:
    """Return the link target of a section."""
    return re.sub(r"\W+", "-", title.lower()).strip("-")


def _minus_signs(cell: Any) -> Any:
    """Return a text with a minus sign before each negative number. Other values stay the same."""
    return re.sub(r"(?<![\w-])-(?=[\d.])", "−", cell) if type(cell) is str else cell


def _in_css(text: str) -> str:
    """Return a text in the form of a quoted string of a style sheet."""
    return "".join(one if one.isalnum() or one in " -_.,:" else f"\\{ord(one):x} " for one in text)


_FILTERS: dict[str, Callable[..., Any]] = {
    "anchor": _anchor,
    "clock": clock,
    "counted": counted,
    "css": _in_css,
    "figure": figure,
    "incident_rows": incident_rows,
    "kind": lambda law: type(law).__name__,
    "metres": metres,
    "minus_signs": _minus_signs,
    "signed": signed,
}

Picture = dict[str, str]
"""A picture of a report: its `title`, the `words` below it, and the SVG `element`."""

INSTANTS = 3
"""Number of worst violations that are drawn at the time of their least margin."""

MOST_PANELS = 4
"""Maximum number of people with a chart of their distance."""

LONG = 4000
"""Number of pieces of motion from which a heat map replaces the paths."""

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


def floor_picture(plan: Floorplan) -> list[Picture]:
    """Return the picture of the floor with all names."""

    def draw() -> Figure:
        from .plots import floorplan

        return floorplan(plan)

    words = "Obstacles are the darker the higher they are; zones are dashed, lanes dotted."
    return list(_drawn("The floor from above", words, "floor", draw))


def risk_pictures(
    plan: Floorplan,
    machines: Sequence[MachineShape],
    maps: Mapping[Risk, CellArray],
    name: str = "",
) -> list[Picture]:
    """Return the maps of risk. Maps of time and severity need violations with a duration."""
    parts: list[Picture] = []
    for of, cells in maps.items():
        if of != "margin" and not cells.any():
            continue

        def draw(of: Risk = of, cells: CellArray = cells) -> Figure:
            from .plots.maps import drawn_risk

            return drawn_risk(plan, machines, cells, of=of, width="single")

        parts += _drawn(*_MAPS[of], f"risk {of} {name}", draw)
    return parts


def run_pictures(
    run: Outcome, worst: Sequence[Incident], name: str = "", *, since: float = 0.0
) -> list[Picture]:
    """Return the pictures of a run: paths, distances of the worst pairs, and worst times.

    Paths and distances begin at `since` (s).
    """
    parts: list[Picture] = []
    dense = sum(len(motion.pieces) for motion in run.motions.values()) > LONG

    def paths() -> Figure:
        from .plots import heat_map, trails

        return (
            heat_map(run, width="single")
            if dense
            else trails(run, within=(since, run.duration), width="single")
        )

    if run.scene.people:
        title, words = (
            ("Where people were", "The time for which each spot was under somebody's body.")
            if dense
            else ("Paths", "Where people and machines went, and where somebody was too close.")
        )
        parts += _drawn(title, words, f"paths {name}", paths)
    pairs = list(dict.fromkeys((one.person, one.machine) for one in worst))
    for person, machine in pairs[:MOST_PANELS]:
        parts += _distance(run, person, machine, name, since)
    parts += _instants(run, worst[:INSTANTS], name)
    return parts


def _distance(
    run: Outcome, person: str, machine: str, name: str, since: float
) -> Iterator[Picture]:
    def draw() -> Figure:
        from .plots import separation

        return separation(run, person, machine, within=(since, run.duration), width="single")

    title = f"Distance of {person} to {machine}"
    words = "Over time, beside what the law required; where it was less is shaded."
    yield from _drawn(title, words, f"separation {person} {machine} {name}", draw)


def _instants(run: Outcome, worst: Sequence[Incident], name: str) -> Iterator[Picture]:
    """Yield pictures of the floor at the times of the worst violations."""
    for k, one in enumerate(worst):
        title = f"{one.person} and {one.machine} at {clock(one.worst_at)}"
        # Just before, because a violation may end in a teleport.
        before = max(0.0, one.worst_at - 1e-6)
        if one.worst_at - one.begin < 1e-6:
            distance, required = distinguished(one.distance, one.required)
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
            from .plots.paths import moment

            return moment(run, before, one.person, one.machine, width="single")

        yield from _drawn(title, words, f"moment {k} {name}", draw)


def _drawn(title: str, words: str, name: str, draw: Callable[[], Figure]) -> Iterator[Picture]:
    """Yield a picture, or nothing without matplotlib."""
    try:
        from .plots.style import figure_element

        element = figure_element(draw(), name, f"{title}. {words}")
        yield {"title": title, "words": words, "element": element}
    except MissingExtraError:
        return


MOST_INCIDENTS = 40
"""Maximum number of violations in the list."""


def together(violations: Iterable[Incident]) -> list[tuple[str, str]]:
    """Return the consequences of violations and their frequencies."""
    counts: dict[str, int] = {}
    for one in violations:
        for consequence in one.led_to or ("nothing",):
            kind = consequence.partition(" for ")[0].partition(" of ")[0]
            counts[kind] = counts.get(kind, 0) + 1
    return [(kind, counted(n, "time")) for kind, n in counts.items()]


def exposure(
    plan: Floorplan, zones: Mapping[str, Mapping[str, float]], on_floor: float, near: float
) -> dict[str, Any]:
    """Return the time of people in each zone, and the time nearer to a machine than required.

    `zones` has the figures of each zone by name. `on_floor` and `near` (s) are totals of all people
    on the whole floor.
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
    return {"rows": rows, "has_zones": bool(plan.zones)}


def _share(part: float, whole: float) -> str:
    return percent(part, whole, 2) if whole > 0 else "–"
