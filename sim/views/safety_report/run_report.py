"""Safety report of a single run: the figures that its template shows."""

from __future__ import annotations

import platform
from collections.abc import Mapping, Sequence
from importlib.metadata import PackageNotFoundError, version
from typing import Any

from navigation.kernels import COMPILED

from ...core.scenario import Scenario
from ...record.incidents import RISKS, incidents, risk, time_on_floor, time_too_close, worst_first
from ...record.outcome import Outcome
from ...record.summary import figures_in_words
from .assumptions import about, laws_of
from .findings import MOST_INCIDENTS, exposure, risk_pictures, run_pictures, together

LIBRARIES = ("numpy", "shapely", "ompl", "python-fcl", "ruckig", "simpy")
"""Packages that figures may depend on in their last digits."""

ASSUMED_FIGURES = ("personality",)
"""Figures of people that stand among the assumptions."""


def software() -> list[tuple[str, str]]:
    """Return what computed the figures."""
    kernels = "compiled" if COMPILED else "not compiled"
    return [
        ("Floorwalker", f"{_version('floorwalker')}, kernels {kernels}"),
        ("Python", f"{platform.python_version()} ({platform.python_implementation()})"),
        ("platform", f"{platform.system()} {platform.machine()}"),
        ("libraries", ", ".join(f"{name} {_version(name)}" for name in LIBRARIES)),
    ]


def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:  # built into the system
        return "unknown"


def run_report(
    run: Outcome,
    scenario: Scenario | None,
    *,
    digests: Mapping[str, str],
    verdicts: Sequence[tuple[str, bool]] = (),
) -> dict[str, Any]:
    """Return what `safety_run.html` shows; `scenario` is the trial, None of a recording.

    `digests` are those of what was read, `verdicts` the expectations and whether they were met.
    """
    worst = worst_first(incidents(run))
    scene, zones = run.scene, run.summary.get("zones", {})
    near, there = time_too_close(run), time_on_floor(run)
    described = about(scene, scenario)
    maps = {of: risk(run, of) for of in RISKS} if scene.people and scene.machines else {}
    return {
        "scene": scene,
        "rules": scene.rules,
        "duration": run.duration,
        "on_floor": there,
        "near": near,
        "worst": worst,
        "most_incidents": MOST_INCIDENTS,
        "led_to": together(worst),
        "verdicts": [("met" if met else "not met", words) for words, met in verdicts],
        "about": described,
        "trials": [described] if scenario else [],
        "held": laws_of(scene.rules, scene.machines),
        **_summary(run),
        "maps": risk_pictures(run.floorplan, scene.machines, maps),
        "exposed": exposure(run.floorplan, zones, there, near),
        "shown": run_pictures(run, worst),
        "software": software(),
        "digests": [*digests.items()],
    }


def _summary(run: Outcome) -> dict[str, Any]:
    """Return the figures of a run, and those of its people with a line for each."""
    of_people: dict[str, dict[str, str]] = {person.name: {} for person in run.scene.people}
    others = []
    for line, amount in figures_in_words(run.summary, in_short=False) if run.summary else ():
        name, _, label = line.partition(": ")
        if name not in of_people:
            others.append((line, amount))
        elif label not in ASSUMED_FIGURES:
            of_people[name][label] = amount
    labels = [*dict.fromkeys(label for figures in of_people.values() for label in figures)]
    rows = [
        (name, *(figures.get(label, "–") for label in labels))
        for name, figures in of_people.items()
        if labels
    ]
    return {"summary": others, "people": {"heads": ("who", *labels), "rows": rows}}
