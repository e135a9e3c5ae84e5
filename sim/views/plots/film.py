"""A run as frames: everybody where they are at each instant, on one drawing of the floor."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ...record.outcome import Outcome
from .curves import Array, instants
from .floor import draw_floor, floor_axes, machine_outline
from .incidents import breaches, disabled_spans
from .names import draw_names
from .style import BLACK, GREY, MACHINES, PALE, VERMILION, person_colour, styled

if TYPE_CHECKING:
    from matplotlib.artist import Artist

Frame = NDArray[np.uint8]
"""(height, width, 3): red, green and blue of every pixel, from the upper left corner on."""

TRAIL = 8.0
"""Seconds of a person's way that are left behind."""

_DOTS_PER_INCH = 100

_MARGIN = 0.7
"""Inches that stand beside the floor, for figures and names of axes."""

_ABOVE = 0.25
"""Inches above the floor, for the time."""


class Film:
    """The pictures of a run at given instants; `width` is that of a picture in pixels.

    `mark` is how long (seconds) a violation stays on the floor.
    """

    def __init__(self, run: Outcome, times: Array, *, width: int, mark: float) -> None:
        self.times = times
        self._run = run
        self._width = width
        self._mark = mark
        self._poses = {
            body: np.column_stack([motion.position(times), motion.rotation(times)])
            for body, motion in run.motions.items()
        }
        self._disabled = disabled_spans(run)
        west, south, east, north = run.floorplan.boundary.bounds
        inches = width / _DOTS_PER_INCH
        height = (inches - _MARGIN) * (north - south) / (east - west) + _MARGIN + _ABOVE
        # Video wants an even number of pixels each way.
        self.size = (2 * (width // 2), 2 * round(height * _DOTS_PER_INCH / 2))

    def at(self, times: Array) -> Film:
        """The same film at other instants."""
        return Film(self._run, times, width=self._width, mark=self._mark)

    def frames(self) -> Iterator[Frame]:
        """One picture after the other."""
        with styled():
            from matplotlib.backends.backend_agg import FigureCanvasAgg
            from matplotlib.figure import Figure
            from matplotlib.layout_engine import ConstrainedLayoutEngine

            wide, high = self.size
            above = _ABOVE / (high / _DOTS_PER_INCH)
            figure = Figure(
                figsize=(wide / _DOTS_PER_INCH, high / _DOTS_PER_INCH),
                dpi=_DOTS_PER_INCH,
                layout=ConstrainedLayoutEngine(rect=(0.0, 0.0, 1.0, 1.0 - above)),
            )
            canvas: Any = FigureCanvasAgg(figure)
            self._draw_still(figure.add_subplot())
            self._time = figure.text(0.5, 1.0 - above / 2, "", ha="center", va="center")
            self._time.set_animated(True)
            canvas.draw()
            still = canvas.copy_from_bbox(figure.bbox)
            for k in range(len(self.times)):
                canvas.restore_region(still)
                for artist in self._moved(k):
                    figure.draw_artist(artist)
                yield np.asarray(canvas.buffer_rgba())[:, :, :3].copy()

    def _draw_still(self, axes: Any) -> None:
        """What is the same in all pictures; and what moves, to be drawn over it."""
        run = self._run
        floor_axes(axes, run.floorplan)
        draw_floor(axes, run.floorplan)
        self._machines: dict[str, Any] = {}
        self._people: dict[str, _Person] = {}
        self._beam: Any = None
        for body in run.motions:
            kind = run.scene.kind(body)
            if kind == "gantry":
                look = {"color": MACHINES["gantry"], "linewidth": 2, "alpha": 0.6}
                (self._beam,) = axes.plot([], [], animated=True, **look)
            if kind != "person":
                look = {"facecolor": PALE, "edgecolor": MACHINES[kind], "linewidth": 1.0}
                (box,) = axes.fill([0.0], [0.0], zorder=4, animated=True, **look)
                self._machines[body] = box
        for index, person in enumerate(run.scene.people):
            self._people[person.name] = _Person(axes, person.radius, person_colour(index))
        (self._marks,) = axes.plot(
            [], [], "v", color=VERMILION, markersize=7, markeredgecolor="white", animated=True
        )
        draw_names(axes, run.floorplan)

    def _moved(self, k: int) -> list[Artist]:
        """Everything that moves, put where it is at the `k`-th instant, in order of drawing."""
        t = float(self.times[k])
        artists: list[Artist] = []
        for person in self._people:
            artists += self._move_person(person, k)
        for body, box in self._machines.items():
            x, y, rotation = self._poses[body][k].tolist()
            box.set_xy(machine_outline(self._run.floorplan, body, (x, y), rotation))
            if body == "gantry":
                self._move_gantry(box, x, t)
                artists.append(self._beam)
            artists.append(box)
        places = [at for _, at in breaches(self._run, (t - self._mark, t))]
        self._marks.set_data([x for x, _ in places], [y for _, y in places])
        self._time.set_text(f"{t:.1f} s")
        return [*artists, self._marks, self._time]

    def _move_person(self, name: str, k: int) -> list[Artist]:
        t = float(self.times[k])
        x, y, rotation = self._poses[name][k].tolist()
        person = self._people[name]
        since = max(0.0, t - TRAIL)
        trail = np.empty((0, 2))
        if t > since:
            motion = self._run.motions[name]
            trail = motion.position(instants([motion], since, t))
        required = None
        if (name, "gantry") in self._run.violations:
            required = float(self._run.required(name, "gantry", [t])[0])
        near = any(
            begin <= t <= end
            for (who, _), intervals in self._run.violations.items()
            for begin, end in intervals
            if who == name
        )
        return person.moved(x, y, rotation, trail, required, near)

    def _move_gantry(self, box: Any, x: float, t: float) -> None:
        gantry = self._run.floorplan.gantry
        assert gantry is not None and self._beam is not None
        self._beam.set_data([x, x], [gantry.y.low, gantry.y.high])
        disabled = any(begin <= t < end for begin, end in self._disabled)
        box.set_facecolor(GREY if disabled else MACHINES["gantry"])


class _Person:
    """A disc with a nose, the required distance around it, and the way behind it."""

    def __init__(self, axes: Any, radius: float, colour: str) -> None:
        from matplotlib.patches import Circle

        self._radius = radius
        self._colour = colour
        self._zone = axes.add_patch(Circle((0, 0), 1.0, linewidth=0.8, animated=True, zorder=2))
        self._body = axes.add_patch(
            Circle((0, 0), radius, facecolor=colour, linewidth=0, animated=True, zorder=5)
        )
        (self._nose,) = axes.plot([], [], color=BLACK, linewidth=1.2, animated=True, zorder=5)
        (self._trail,) = axes.plot([], [], color=colour, linewidth=1.2, alpha=0.6, animated=True)

    def moved(
        self,
        x: float,
        y: float,
        rotation: float,
        trail: Array,
        required: float | None,
        near: bool,
    ) -> list[Artist]:
        """What is drawn of the person, put where they are."""
        self._trail.set_data(*trail.T)
        self._body.set_center((x, y))
        nose = 1.5 * self._radius
        self._nose.set_data([x, x + nose * math.cos(rotation)], [y, y + nose * math.sin(rotation)])
        parts: list[Artist] = [self._trail, self._body, self._nose]
        if required is None:
            return parts
        colour = VERMILION if near else self._colour
        self._zone.set_center((x, y))
        self._zone.set_radius(required)
        self._zone.set_facecolor((colour, 0.15))
        self._zone.set_edgecolor((colour, 0.6))
        return [self._zone, *parts]
