"""Films of a run as GIF or MP4."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any, Literal

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.lines import Line2D
from matplotlib.patches import Circle
from matplotlib.patheffects import withStroke
from numpy.typing import NDArray
from PIL import Image

from floorplan import Point, UserError

from ...core.body import MachineShape
from ...core.output import replacing, writing
from ...machines.kinds import rails_under
from ...record.outcome import Outcome
from ...record.words import told_apart
from ..browser import PageFilm, View, find_chromium
from ..report_page import BLACK, GREY, PALE, VERMILION, MissingExtraError
from .floor import draw_floor, draw_names, floor_axes, stand_beside
from .style import (
    MACHINES,
    Span,
    breaches,
    disabled_spans,
    instants,
    person_colour,
    require_place,
    span_of,
    styled,
)

Place = tuple[Point, Point]
"""A point of the floor (metres), and how far from there a name stands (points)."""


class MovingNames:
    """Where the names of a picture stand that move over what is written on `axes` and stays."""

    def __init__(self, axes: Axes) -> None:
        still = [text for text in axes.texts if not text.get_animated()]
        self._still = [text.get_window_extent().extents for text in still]
        self._taken = list(self._still)

    def clear(self) -> None:
        """Forget what moves, for the next picture."""
        self._taken = list(self._still)

    def keep_off(self, artist: Artist) -> None:
        """Let no name that is put from now on cover this one, if it can stand elsewhere."""
        self._taken.append(artist.get_window_extent().extents)

    def put(self, name: Any, places: Sequence[Place]) -> None:
        """Put an annotation at the first of its places where it covers nothing, or the least."""
        left, low, right, high = np.array(self._taken).reshape(-1, 4).T

        def covered(place: Place) -> float:
            """Put the name there; return how much it covers (square pixels)."""
            name.xy, side = place
            stand_beside(name, side)
            x, y, x_end, y_end = name.get_window_extent().extents
            wide = np.minimum(x_end, right) - np.maximum(x, left)
            deep = np.minimum(y_end, high) - np.maximum(y, low)
            return float(np.sum(wide.clip(0.0) * deep.clip(0.0)))

        if not any(covered(place) == 0.0 for place in places):
            covered(min(places, key=covered))
        self.keep_off(name)


ENDINGS = (".gif", ".mp4")

FilmView = Literal["plot"] | View
"""The run as it is plotted, or as the replay page shows it."""

MOST_PICTURES = 20_000
"""A film of more pictures than this is refused: its speed is a mistake."""

MARKED = 1.5
"""Seconds of the film for which a violation stays on the floor."""

TRAIL = 8.0
"""Seconds of a person's path that are drawn behind them."""

_DOTS_PER_INCH = 100

_MARGIN = 0.7
"""Inches beside the floor, for the figures and names of the axes."""

_ABOVE = 0.25
"""Inches above the floor, for the time."""

_EXPLAINED = 480
"""Pixels of width from which a film has a legend."""

_LETTERS = 6.0
"""Points. The size of a name that moves."""

_SIDES = ((0.0, 5.0), (0.0, -5.0), (5.0, 0.0), (-5.0, 0.0))
"""Points from a person's centre to their name; the best first."""

_SHARES = (0.5, 0.36, 0.64, 0.25, 0.75)
"""Where on the line between two bodies the figure of their distance stands; the best first."""

_DISTANCE = (0, (3, 3))
"""The dashes of a line between two bodies."""

_ROUNDING = 1e-6
"""Metres."""

_SAMPLES = 12
"""Pictures, spread over a film, from which the colours of a GIF are chosen."""

Picture = NDArray[np.uint8]
"""(height, width, 3): red, green and blue of every pixel, from the upper left corner on."""

Progress = Callable[[float], None]
"""Called with the share that is done, from 0 to 1."""


def render(
    run: Outcome,
    path: str | Path,
    *,
    speed: float = 8.0,
    fps: int = 20,
    width: int = 720,
    within: Span | None = None,
    view: FilmView = "plot",
    follow: str = "",
    dark: bool = False,
    progress: Progress = lambda _: None,
) -> None:
    """Film a run into the GIF or MP4 that the end of `path` names.

    `speed` is how much faster than in reality it goes, `fps` how many pictures a second it has,
    `width` how wide it is in pixels; `within` (from, to in seconds) is the part that is filmed.
    Other than the "plot", a `view` is that of the replay page: from above ("2d"), in three
    dimensions ("3d"), or through somebody's "eyes"; `follow` is the body that is kept in the
    middle, or whose eyes these are, and the page may be `dark`. Errors as for
    `require_renderable`; `ValueError` for figures that make no film.
    """
    path = Path(path)
    require_renderable(path, view)
    if view == "plot" and (follow or dark):
        raise UserError("only a film of the page can follow somebody, or be dark: give its view")
    if not 200 <= width <= 4000:
        raise UserError(f"a film is 200 to 4000 pixels wide, not {width}")
    times = _times(run, speed, fps, within)
    write = _write_gif if path.suffix.lower() == ".gif" else _write_mp4
    with styled(), writing(path), replacing(path) as unfinished:
        if view == "plot":
            film = Film(run, width=width, mark=MARKED * speed)
            write(film, times, unfinished, fps, progress)
            return
        page = PageFilm(run, width=width, view=view, speed=speed, follow=follow, dark=dark)
        with page:
            write(page, times, unfinished, fps, progress)


def require_renderable(path: str | Path, view: FilmView = "plot") -> None:
    """Raise, before any work is done for it, if a run can't be filmed into `path`.

    `ValueError` if it ends in neither .gif nor .mp4, `MissingExtraError` if the encoder for it is
    not installed, or no browser for a `view` of the page, `OutputError` if there is no such folder.
    """
    require_place(path, "film", ENDINGS)
    if view != "plot":
        find_chromium()
    if Path(path).suffix.lower() == ".mp4":
        try:
            import av as av
        except ImportError:
            raise MissingExtraError(
                "an MP4 needs the package av, which is missing: pip install 'floorwalker[plot]';"
                " or write a .gif"
            ) from None


class Film:
    """The pictures of a run, each `width` pixels wide.

    `mark` is how long (seconds) a violation stays on the floor. The floor is drawn once, and
    everything that moves over a copy of it.
    """

    def __init__(self, run: Outcome, *, width: int, mark: float) -> None:
        self._run = run
        self._mark = mark
        self._disabled = {
            machine.name: disabled_spans(run, machine.name) for machine in run.scene.machines
        }
        west, south, east, north = run.floorplan.boundary.bounds
        inches = width / _DOTS_PER_INCH
        height = (inches - _MARGIN) * (north - south) / (east - west) + _MARGIN + _ABOVE
        # Video wants an even number of pixels each way.
        self.size = wide, high = 2 * (width // 2), 2 * round(height * _DOTS_PER_INCH / 2)
        above = _ABOVE / (high / _DOTS_PER_INCH)
        with styled():
            self._figure = Figure(
                figsize=(wide / _DOTS_PER_INCH, high / _DOTS_PER_INCH),
                dpi=_DOTS_PER_INCH,
                layout=ConstrainedLayoutEngine(rect=(0.0, 0.0, 1.0, 1.0 - above)),
            )
            self._canvas = FigureCanvasAgg(self._figure)
            self._axes = floor_axes(self._figure.add_subplot(), run.floorplan)
            self._draw(self._axes)
            middle = 1.0 - above / 2
            self._time = self._figure.text(0.99, middle, "", ha="right", va="center")
            if wide >= _EXPLAINED:
                self._explain(middle)
            self._time.set_animated(True)
            self._canvas.draw()
            self._written = MovingNames(self._axes)
        self._floor = self._canvas.copy_from_bbox(self._figure.bbox)

    def at(self, t: float) -> Picture:
        """Return the picture of the instant `t` (seconds)."""
        self._canvas.restore_region(self._floor)
        with styled():
            for artist in self._moved(t):
                self._figure.draw_artist(artist)
        return np.asarray(self._canvas.buffer_rgba())[:, :, :3].copy()

    def _explain(self, middle: float) -> None:
        """Say at this height what the discs and lines are, in the margin above the floor."""
        looks: list[Artist] = [
            Line2D([], [], marker="o", linestyle="", color=(GREY, 0.4), label="required distance"),
            Line2D([], [], color=GREY, linestyle=_DISTANCE, linewidth=0.8, label="distance"),
            Line2D([], [], color=VERMILION, marker="v", linestyle="", label="too close"),
        ]
        self._figure.legend(
            handles=looks,
            loc="center left",
            bbox_to_anchor=(0.0, middle),
            ncols=len(looks),
            borderaxespad=0.2,
            handletextpad=0.5,
        )

    def _draw(self, axes: Axes) -> None:
        """Draw the floor, and make the artists of what moves, which stay out of it."""
        run = self._run
        draw_floor(axes, run.floorplan, run.scene.machines)
        self._beams: dict[str, Any] = {}
        self._boxes: dict[str, Any] = {}
        self._names: dict[str, Any] = {}
        for machine in run.scene.machines:
            colour = MACHINES[machine.category]
            if rails_under(machine.name, run.floorplan) is not None:
                (self._beams[machine.name],) = axes.plot(
                    [], [], color=colour, linewidth=2, alpha=0.6, animated=True
                )
            (self._boxes[machine.name],) = axes.fill(
                [0.0],
                [0.0],
                facecolor=PALE,
                edgecolor=colour,
                linewidth=1.0,
                zorder=4,
                animated=True,
            )
            self._names[machine.name] = _name(axes, machine.name, BLACK)
        self._people = {
            person.name: _Person(axes, person.name, person.radius, person_colour(index))
            for index, person in enumerate(run.scene.people)
        }
        (self._marks,) = axes.plot(
            [], [], "v", color=VERMILION, markersize=7, markeredgecolor="white", animated=True
        )
        draw_names(axes, run.floorplan)

    def _moved(self, t: float) -> list[Artist]:
        """Return everything that moves, put where it is at `t`, in order of drawing."""
        run = self._run
        self._written.clear()
        machines = [
            part for machine in run.scene.machines for part in self._move_machine(machine, t)
        ]
        spans = ((name, *run.presence[name]) for name in self._people)
        present = [name for name, begin, end in spans if begin <= t <= end > begin]
        people = [part for name in present for part in self._move_person(name, t)]
        for name in present:
            self._people[name].write(self._written)
        places = [at for _, at in breaches(run, (t - self._mark, t))]
        self._marks.set_data([x for x, _ in places], [y for _, y in places])
        self._time.set_text(f"{t:.1f} s")
        return [*people, *machines, self._marks, self._time]

    def _move_machine(self, machine: MachineShape, t: float) -> Iterator[Artist]:
        x, y, rotation = self._run.motions[machine.name].state(t).position
        rails = rails_under(machine.name, self._run.floorplan)
        if rails is not None:
            self._beams[machine.name].set_data([x, x], [rails.y.low, rails.y.high])
            yield self._beams[machine.name]
        box = self._boxes[machine.name]
        box.set_xy(machine.footprint((x, y), rotation).exterior.coords)
        if machine.category == "robot":
            disabled = any(begin <= t < end for begin, end in self._disabled[machine.name])
            box.set_facecolor(GREY if disabled else MACHINES["robot"])
        yield box
        self._names[machine.name].xy = (x, y)
        self._written.keep_off(self._names[machine.name])
        yield self._names[machine.name]

    def _move_person(self, name: str, t: float) -> list[Artist]:
        run, since = self._run, max(0.0, t - TRAIL)
        motion = run.motions[name]
        trail = motion.position(instants([motion], since, t)) if t > since else np.empty((0, 2))
        robots = [machine.name for machine in run.scene.machines if machine.category == "robot"]
        watched = [robot for robot in robots if (name, robot) in run.violations]
        required = [float(run.required(name, robot, [t])[0]) for robot in watched]
        apart = [float(run.distance(name, robot, [t])[0]) for robot in watched]
        nearest = min(zip(apart, watched, strict=True), default=None)
        line = None
        if nearest is not None:
            line = (nearest[0], run.motions[nearest[1]].state(t).at)
        near = any(
            begin <= t <= end
            for intervals in run.violations_of(name).values()
            for begin, end in intervals
        )
        largest = max(required, default=None)
        person = self._people[name]
        self._written.keep_off(person.body)
        return person.moved(motion.state(t).position, trail, largest, line, near)


class _Person:
    """A disc with a nose and a name, the required distance around it, and the path behind it."""

    def __init__(self, axes: Axes, name: str, radius: float, colour: str) -> None:
        self._name = _name(axes, name, colour)
        (self._line,) = axes.plot(
            [], [], color=GREY, linestyle=_DISTANCE, linewidth=0.8, animated=True, zorder=3
        )
        self._figure = _name(axes, "", colour)
        self._radius = radius
        self._colour = colour
        self._zone = axes.add_patch(Circle((0, 0), 1.0, linewidth=0.8, animated=True, zorder=2))
        self.body = Circle((0, 0), radius, facecolor=colour, linewidth=0, animated=True, zorder=5)
        axes.add_patch(self.body)
        (self._nose,) = axes.plot([], [], color=BLACK, linewidth=1.2, animated=True, zorder=5)
        (self._trail,) = axes.plot([], [], color=colour, linewidth=1.2, alpha=0.6, animated=True)
        self._at: Point = (0.0, 0.0)
        self._to: Point | None = None

    def moved(
        self,
        pose: tuple[float, float, float],
        trail: NDArray[np.float64],
        required: float | None,
        line: tuple[float, Point] | None,
        near: bool,
    ) -> list[Artist]:
        """The artists of the person, put where they are; `line` is a distance, and to where."""
        x, y, rotation = pose
        nose = 1.5 * self._radius
        self._trail.set_data(*trail.T)
        self.body.set_center((x, y))
        self._nose.set_data([x, x + nose * math.cos(rotation)], [y, y + nose * math.sin(rotation)])
        self._at, self._to = (x, y), None
        parts: list[Artist] = [self._trail, self.body, self._nose, self._name]
        if required is None or line is None:
            return parts
        colour = VERMILION if near else self._colour
        distance, self._to = line
        to_x, to_y = self._to
        self._line.set_data([x, to_x], [y, to_y])
        self._line.set_color(VERMILION if near else GREY)
        self._figure.set_text(_figure(distance, required, near))
        self._figure.set_color(colour)
        self._zone.set(
            center=(x, y), radius=required, facecolor=(colour, 0.15), edgecolor=(colour, 0.6)
        )
        return [self._zone, self._line, *parts, self._figure]

    def write(self, written: MovingNames) -> None:
        """Put the name beside the person, and the figure on the line to the nearest machine."""
        written.put(self._name, [(self._at, side) for side in _SIDES])
        if self._to is not None:
            line = np.subtract(self._to, self._at)
            spots = [tuple(self._at + share * line) for share in _SHARES]
            written.put(self._figure, [(spot, (0.0, 0.0)) for spot in spots])


def _figure(distance: float, required: float, near: bool) -> str:
    """Return the words of a distance, which may be too short; `near` also to another machine."""
    if not near or distance > required + _ROUNDING:
        return f"{distance:.1f} m"
    shown = told_apart(distance, required)
    is_just = shown[0].endswith(shown[1])
    return f"too close: {shown[0] if is_just else ' of '.join(shown)} m"


def _name(axes: Axes, text: str, colour: str) -> Any:
    """Return a text that moves with a point of the floor, its `xy`, and stands on it."""
    return axes.annotate(
        text,
        (0.0, 0.0),
        (0.0, 0.0),
        textcoords="offset points",
        ha="center",
        va="center",
        size=_LETTERS,
        color=colour,
        animated=True,
        zorder=6,
        path_effects=[withStroke(linewidth=1.5, foreground="white")],
    )


AnyFilm = Film | PageFilm


def _times(run: Outcome, speed: float, fps: int, within: Span | None) -> list[float]:
    if not (math.isfinite(speed) and speed > 0):
        raise UserError(f"a film's speed is more than 0, not {speed:g}")
    if not 1 <= fps <= 50:
        raise UserError(f"a film has 1 to 50 pictures a second, not {fps}")
    begin, end = span_of(run, within)
    count = int((end - begin) * fps / speed + 1e-9) + 1
    if count > MOST_PICTURES:
        raise UserError(
            f"that would be {count:,} pictures, more than {MOST_PICTURES:,};"
            " choose a higher speed or a shorter stretch of time"
        )
    times: list[float] = np.minimum(begin + np.arange(count) * (speed / fps), end).tolist()
    return times


def _pictures(film: AnyFilm, times: list[float], progress: Progress) -> Iterator[Picture]:
    for k, t in enumerate(times, 1):
        yield film.at(t)
        progress(k / len(times))


def _write_gif(film: AnyFilm, times: list[float], path: Path, fps: int, progress: Progress) -> None:
    # One palette for the whole film, so that no colour flickers.
    chosen = np.vstack([film.at(t) for t in times[:: max(1, len(times) // _SAMPLES)]])
    palette = Image.fromarray(chosen).quantize(method=Image.Quantize.FASTOCTREE)
    images = (
        Image.fromarray(picture).quantize(palette=palette, dither=Image.Dither.NONE)
        for picture in _pictures(film, times, progress)
    )
    first = next(images)
    first.save(path, save_all=True, append_images=images, duration=1000 / fps, loop=0)


def _write_mp4(film: AnyFilm, times: list[float], path: Path, fps: int, progress: Progress) -> None:
    import av

    with av.open(path, "w") as file:
        # x264's code for single CPUs reads memory that nobody wrote to (its macroblock tree).
        options = {"threads": "1", "x264-params": "cpu-independent=1"}
        stream = file.add_stream("libx264", rate=fps, options=options)
        stream.width, stream.height = film.size
        stream.pix_fmt = "yuv420p"
        for picture in _pictures(film, times, progress):
            file.mux(stream.encode(av.VideoFrame.from_ndarray(picture, format="rgb24")))
        file.mux(stream.encode())
