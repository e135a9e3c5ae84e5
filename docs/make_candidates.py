"""Makes the picture of candidates in docs/avoidance.md: `python docs/make_candidates.py [FOLDER]`.

One decision of a scene is repeated with a log of all candidates that are drawn up. Then the
candidates that were left are drawn up too.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from unittest.mock import patch

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle

import sim
from floorplan import Point
from navigation import Motion
from sim.people.crowd.observe import Outlook
from sim.people.crowd.propose import Foresighted
from sim.people.crowd.traveller import Traveller
from sim.views import plots
from sim.views.plots.floor import draw_floor, floor_axes
from sim.views.plots.style import explain, new_figure, styled
from sim.views.report_page import BLACK, BLUE, GREY, PALE, VERMILION

SCENE, PERSON, TIME = "people_crossing", "ben", 20.79
"""The decision of the picture: of this person, after this time (s)."""

WINDOW = (2.2, 9.4, 2.4, 7.6)
"""The part of the floor that is shown: west, east, south, north, m."""

STEP = 0.1
"""Seconds between the points of a motion that is drawn."""


@dataclass
class DrawnUp:
    """The candidates of one decision, in place of the speed zones of a person.

    Every candidate asks the zones for the speed limits on its course, so they see each one.
    """

    courses: list[tuple[list[Point], float]] = field(default_factory=list)

    def along(self, course: Sequence[Point], top_speed: float) -> tuple[list[Point], float]:
        """Note a candidate, and return it without limits."""
        self.courses.append(([*course], top_speed))
        return self.courses[-1]


@dataclass
class Decision:
    """Motions of a person and of the others, from `now` (s) on."""

    now: float
    radius: float
    preferred: Motion
    rejected: list[Motion]
    conflicts: list[float]
    """Times of their first conflicts, s."""
    chosen: Motion
    left: list[Motion]
    """Candidates that were not drawn up."""
    others: list[Motion]


def repeated(me: Traveller, outlook: Outlook) -> Decision:
    """Repeat the decision of a person who walks."""
    zones, log = me.zones, DrawnUp()
    table = outlook._commitments
    me.zones = log
    again = Outlook(me, outlook.now, table, outlook.ground)
    again.look_again()
    first = len(log.courses)
    again.first_free()
    chosen = len(log.courses) - 1
    # Without other people, every remaining candidate is free.
    while again.walks.next_free([], table, me.radius) is not None:
        pass
    me.zones = zones
    motions = [again.walk(course, top_speed=speed) for course, speed in log.courses]
    rejected = motions[first:chosen]
    return Decision(
        outlook.now,
        me.radius,
        motions[0],
        rejected,
        [again.hit(motion).t for motion in rejected],
        motions[chosen],
        motions[chosen + 1 :],
        [other.body.motion for other in table.people if other is not me],
    )


def decision(trial: sim.Trial) -> Decision:
    """Run a trial, and return the decision of `PERSON` after `TIME`."""
    found: list[Decision] = []
    replan = Foresighted.replan

    def watched(
        self: Foresighted, body: Traveller, neighbours: Sequence[Traveller], outlook: Outlook
    ) -> Motion | None:
        if not found and body.name == PERSON and outlook.now > TIME:
            found.append(repeated(body, outlook))
        return replan(self, body, neighbours, outlook)

    with patch.object(Foresighted, "replan", watched):
        sim.run(trial)
    return found[0]


def line(axes: Axes, motion: Motion, begin: float, **look: object) -> None:
    """Draw the path of a motion from `begin` (s) to its end, with a dot there."""
    times = np.arange(begin, motion.end + STEP, STEP)
    x, y = motion.position(times)[:, :2].T
    axes.plot(x, y, marker="o", markersize=2.5, markevery=[-1], **look)


def body(axes: Axes, at: Sequence[float], radius: float, colour: str) -> None:
    """Draw a person."""
    axes.add_patch(Circle(at[:2], radius, facecolor=colour, edgecolor=BLACK, lw=0.6, zorder=5))


@styled()
def candidates(out: Path) -> None:
    """Draw the candidates of one decision."""
    trial = sim.Trial.load(SCENE)
    shown = decision(trial)
    figure = new_figure("double", 3.9)
    axes = floor_axes(figure.add_subplot(), trial.floorplan)
    axes.set(xlim=WINDOW[:2], ylim=WINDOW[2:])
    draw_floor(axes, trial.floorplan)
    for other in shown.others:
        line(axes, other, shown.now, color=BLACK, linewidth=0.6, linestyle=":", zorder=3)
        body(axes, other.position(shown.now), shown.radius, PALE)
    for motion in shown.left:
        line(axes, motion, shown.now, color=GREY, linewidth=0.6, zorder=2)
    for motion, t in zip(shown.rejected, shown.conflicts, strict=True):
        line(axes, motion, shown.now, color=VERMILION, linewidth=0.9, zorder=4)
        axes.plot(*motion.position(t)[:2], "x", color=VERMILION, markersize=6, zorder=6)
    dashed = {"color": BLACK, "linewidth": 0.9, "linestyle": "--"}
    line(axes, shown.preferred, shown.now, zorder=3, **dashed)
    line(axes, shown.chosen, shown.now, color=BLUE, linewidth=2.0, zorder=4.5)
    body(axes, shown.chosen.position(shown.now), shown.radius, BLUE)
    labels = {
        "preferred motion": dashed,
        "chosen": {"color": BLUE, "linewidth": 2.0},
        f"rejected ({len(shown.rejected)}), × first conflict": {"color": VERMILION},
        f"not drawn up ({len(shown.left)})": {"color": GREY},
        "motion of the other": {"color": BLACK, "linestyle": ":"},
    }
    for label, look in labels.items():
        axes.plot([], [], label=label, **look)
    explain(figure, [axes], "double")
    plots.save(figure, out / "avoidance-candidates.svg")


if __name__ == "__main__":
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent / "images"
    candidates(folder)
