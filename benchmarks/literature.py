"""People among people against the literature: figures and plot of docs/people-validation.md.

Bodies have a radius of 0.2 m and walk at up to 1.34 m/s, as in the literature: in a single file,
through openings, one way and both ways in a corridor, in the tests 1, 4, 5, 6, 7, 9 and 12 of RiMEA
(Richtlinie für Mikroskopische Entfluchtungsanalysen, version 3, 2016), and in the verification
tests 1 to 6 of Jülich (JuPedSim 0.9, 2020). JuPedSim walks the same scenes beside, and PedPy
measures what it has a method for.

    python benchmarks/literature.py [--plot docs/images/literature.svg] [--people 1000]
"""

from __future__ import annotations

import argparse
import math
import random
import statistics
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pedpy
import shapely
from crowd_scenes import (
    FREE_SPEED,
    RADIUS,
    RATE,
    SPREAD,
    Point,
    Program,
    Scene,
    Walker,
    floorwalker,
    jupedsims,
    rectangle,
)
from numpy.typing import NDArray
from scipy.spatial import cKDTree
from shapely import affinity

from sim.views import plots
from sim.views.plots.style import new_figure, styled
from sim.views.report_page import BLACK, BLUE, GREY, PALE, VERMILION

SPEEDS = (0.1, 0.2, 0.4, 0.6, 0.8, 1.0)
"""m/s. Of who leads a single file."""

WIDTHS = (0.8, 1.0, 1.2, 1.6, 2.0)
"""Metres. Of openings."""

DENSITIES = (0.5, 1.0, 1.5, 2.0)
"""People per square metre, at the start."""

STARTS = (1, 2, 3, 4)
"""Seeds of the places in a full corridor, and of when people come into counterflow.

From files along the corridor, what is measured soon after would be how far apart these were laid.
"""

RATES = (0.15, 0.25, 0.4)
"""People per second who come in at each of three places at either end."""


class Found(NamedTuple):
    """A figure at a speed, a density or a width."""

    at: float
    figure: float


def weidmann(density: float) -> float:
    """Return the speed (m/s) at a density (1/m²), after Weidmann 1993."""
    return FREE_SPEED * (1 - math.exp(-1.913 * (1 / density - 1 / 5.4)))


def seyfried(speed: float) -> float:
    """Return the length (m) that one person takes in a single file at a speed (m/s).

    A. Seyfried et al., "The fundamental diagram of pedestrian movement revisited", J. Stat. Mech.,
    2005.
    """
    return 0.36 + 1.06 * speed


def drawn(count: int) -> list[float]:
    """Return walking speeds (m/s) for this number of people, after Weidmann, always the same."""
    chance = random.Random(1)
    return [min(max(chance.gauss(FREE_SPEED, SPREAD), 0.6), 2.0) for _ in range(count)]


def filled(low: Point, high: Point, count: int) -> list[Point]:
    """Return `count` places, even over a rectangle: the corners of equilateral triangles."""
    (x0, y0), (x1, y1) = low, high
    step = math.sqrt((x1 - x0) * (y1 - y0) / count * 2 / math.sqrt(3))
    rows = max(round((y1 - y0) / (step * math.sqrt(3) / 2)), 1)
    columns = math.ceil(count / rows)
    pitch = (x1 - x0) / (columns + 0.5)
    places = [
        (x0 + (c + 0.25 + 0.5 * (r % 2)) * pitch, y0 + (r + 0.5) * (y1 - y0) / rows)
        for c in range(columns)
        for r in range(rows)
    ]
    return places[:count]


def strewn(low: Point, high: Point, count: int, seed: int) -> list[Point]:
    """Return `count` places, drawn at random over a rectangle, no two bodies nearer than 0.05 m.

    The distance is smaller where the people do not fit.
    """
    chance, apart, tries, places = random.Random(seed), 2 * RADIUS + 0.05, 0, list[Point]()
    while len(places) < count:
        at = (chance.uniform(low[0], high[0]), chance.uniform(low[1], high[1]))
        tries += 1
        if tries > 20_000:
            apart, tries = 0.95 * apart, 0
        if all(math.dist(at, other) > apart for other in places):
            places.append(at)
    return places


def durations(data: pedpy.TrajectoryData) -> NDArray[np.float64]:
    """Return how long (s) each walker is on the floor."""
    frames = data.data.groupby("id").frame
    return ((frames.max() - frames.min()) / RATE).to_numpy()


def positions(data: pedpy.TrajectoryData, k: int) -> NDArray[np.float64]:
    """Return where a walker is, frame by frame. Shape (n, 2)."""
    return data.data[data.data.id == k][["x", "y"]].to_numpy()


def nearest(data: pedpy.TrajectoryData) -> float:
    """Return the least distance (m) between two bodies in any frame, negative if they overlap."""
    least = math.inf
    for _, frame in data.data.groupby("frame"):
        if len(frame) > 1:
            at = frame[["x", "y"]].to_numpy()
            least = min(least, float(cKDTree(at).query(at, k=2)[0][:, 1].min()))
    return least - 2 * RADIUS


# ---- tests that pass or fail, as published


def rimea_1(walk: Program) -> str:
    """One person walks 40 m at 1.33 m/s."""
    one = Walker((1.0, 1.0), ((41.0, 1.0),), 1.33)
    return f"{durations(walk(Scene(rectangle(42.0, 2.0), [one], 60.0)))[0]:.1f} s"


def rimea_5(walk: Program) -> str:
    """Ten people set out after 10, 20, …, 100 s."""
    walkers = [
        Walker((1.0 + k // 5, 0.6 + 0.9 * (k % 5)), ((7.5, 2.5),), sets_out=10.0 * (k + 1))
        for k in range(10)
    ]
    data = walk(Scene(rectangle(8.0, 5.0), walkers, 120.0))
    off = []
    for k, one in enumerate(walkers):
        moved = np.hypot(*(positions(data, k) - one.at).T) > 1e-6
        off.append(abs((int(np.argmax(moved)) - 1) / RATE - one.sets_out))
    return f"error at most {max(off):.1f} s"


def rimea_6(walk: Program) -> str:
    """Twenty people go round a corner."""
    starts = [(0.5 + 0.6 * c, 0.3 + 0.45 * r) for c in range(5) for r in range(4)]
    sinks = [(10.4 + 0.3 * (k % 5), 10.2 + 0.4 * (k // 5)) for k in range(20)]
    walkers = [Walker(start, (sink,)) for start, sink in zip(starts, sinks, strict=True)]
    floor = rectangle(12.0, 12.0, (0.0, 2.0, 10.0, 12.0))
    data = walk(Scene(floor, walkers, 90.0))
    at = shapely.points(data.data[["x", "y"]].to_numpy())
    wall = shapely.distance(floor.exterior, at)
    through = int((~shapely.covers(floor, at)).sum())
    left = int((durations(data) < 90.0).sum())
    return f"{left} of 20, {through} through a wall, minimum {wall.min():.2f} m from one"


def rimea_7(walk: Program) -> str:
    """Twenty people of the speeds of Weidmann's ages walk 20 m side by side."""
    speeds = [round(0.6 + 0.055 * k, 3) for k in range(20)]
    walkers = [Walker((1.0, 0.5 + k), ((22.0, 0.5 + k),), v) for k, v in enumerate(speeds)]
    data = walk(Scene(rectangle(24.0, 20.0), walkers, 60.0))
    off = []
    for k, speed in enumerate(speeds):
        steps = np.hypot(*np.diff(positions(data, k)[30:110], axis=0).T) * RATE
        off.append(abs(statistics.mean(steps.tolist()) / speed - 1))
    return f"error at most {100 * max(off):.2f} %"


def juelich_1(walk: Program, turned: float = 0.0) -> str:
    """One person walks 10 m at 1 m/s along the middle of a corridor, which may be turned."""
    floor = affinity.rotate(rectangle(12.0, 2.0), turned, origin=(0.0, 0.0))
    c, s = math.cos(math.radians(turned)), math.sin(math.radians(turned))
    start, goal = ((x * c - s, x * s + c) for x in (1.0, 11.0))
    return f"{durations(walk(Scene(floor, [Walker(start, (goal,), 1.0)], 30.0)))[0]:.1f} s"


def juelich_2(walk: Program) -> str:
    """The same, turned by 45 degrees."""
    return juelich_1(walk, 45.0)


def juelich_3(walk: Program) -> str:
    """One person walks to a goal from each of a hundred places, drawn at random."""
    chance, there = random.Random(3), 0
    for _ in range(100):
        start = (chance.uniform(0.3, 4.7), chance.uniform(0.3, 4.7))
        floor = rectangle(12.0, 5.0, (5.0, 0.0, 5.2, 2.0), (5.0, 3.0, 5.2, 5.0))
        data = walk(Scene(floor, [Walker(start, ((11.0, 2.5),), 1.0)], 30.0))
        there += bool(durations(data)[0] < 30.0)
    return f"{there} of 100"


def _past_somebody(walk: Program, width: float) -> pedpy.TrajectoryData:
    walkers = [Walker((1.0, width / 2), ((15.0, width / 2),), 1.0), Walker((8.0, width / 2))]
    return walk(Scene(rectangle(16.0, width), walkers, 40.0))


def juelich_4(walk: Program) -> str:
    """One person comes up behind a standing one, with room to pass."""
    data = _past_somebody(walk, 3.0)
    return f"{durations(data)[0] - 14.0:+.1f} s, gap {nearest(data):.2f} m"


def juelich_5(walk: Program) -> str:
    """One person comes up behind a standing one, without room to pass."""
    data = _past_somebody(walk, 0.7)
    at = positions(data, 0)
    past = "passes" if at[-1, 0] > 8.0 or len(at) < 40 * RATE else "stops"
    return f"{past}, gap {nearest(data):.2f} m"


def juelich_6(walk: Program) -> str:
    """One person walks 10 m at 1 m/s by three goals in between."""
    goals = tuple((x, 1.0) for x in (3.5, 6.0, 8.5, 11.0))
    data = walk(Scene(rectangle(12.0, 2.0), [Walker((1.0, 1.0), goals, 1.0)], 30.0))
    return f"{durations(data)[0]:.1f} s"


ROWS: tuple[tuple[str, str, Callable[[Program], str]], ...] = (
    ("one person, 40 m at 1.33 m/s (RiMEA 1)", "26 to 34 s", rimea_1),
    ("ten reaction times of 10 to 100 s (RiMEA 5)", "as given", rimea_5),
    ("twenty people around a corner (RiMEA 6)", "all, none through a wall", rimea_6),
    ("twenty speeds, 0.60 to 1.65 m/s (RiMEA 7)", "as given", rimea_7),
    ("one person, 10 m at 1 m/s (Jülich 1)", "10 s", juelich_1),
    ("the same, rotated by 45° (Jülich 2)", "10 s", juelich_2),
    ("one goal from a hundred places (Jülich 3)", "all", juelich_3),
    ("past a standing person, 3 m wide (Jülich 4)", "passes", juelich_4),
    ("behind a standing person, 0.7 m wide (Jülich 5)", "stops without overlap", juelich_5),
    ("10 m at 1 m/s with three goals (Jülich 6)", "10 s", juelich_6),
)
"""Scene, the figure as published, and the measurement."""


# ---- diagrams


def single_file(walk: Program) -> Iterator[Found]:
    """Yield the distances in a file of six behind a person who walks at a speed."""
    for speed in SPEEDS:
        count, length = 6, 12.0 + 12.0 * speed
        duration = (length - 8.0) / speed
        walkers = [
            Walker((7.0 - 1.2 * k, 0.35), ((length + 2.0, 0.35),), FREE_SPEED if k else speed)
            for k in range(count)
        ]
        data = walk(Scene(rectangle(length + 3.0, 0.7), walkers, duration))
        late = data.data[data.data.frame >= duration / 2 * RATE]
        table = late.pivot_table(index="frame", columns="id", values="x")
        yield Found(speed, float(-np.nanmean(np.diff(table.to_numpy(), axis=1))))


def bottleneck(walk: Program) -> Iterator[Found]:
    """Yield the specific flows (1/(m s)) of twenty through openings: means of random starts."""
    for width in WIDTHS:
        yield Found(width, statistics.mean(_flow(walk, width, seed) for seed in STARTS) / width)


def _flow(walk: Program, width: float, seed: int) -> float:
    low, high = 2.6 - width / 2, 2.6 + width / 2
    starts = strewn((0.7, 0.7), (3.9, 4.5), 20, seed)
    walkers = [Walker(at, ((11.4, 0.5 + 0.21 * k),)) for k, at in enumerate(starts)]
    floor = rectangle(12.0, 5.2, (5.5, 0.0, 6.0, low), (5.5, high, 6.0, 5.2))
    data = walk(Scene(floor, walkers, 90.0))
    line = pedpy.MeasurementLine([(6.0, 0.0), (6.0, 5.2)])
    passed, _ = pedpy.compute_n_t(traj_data=data, measurement_line=line)
    times = passed[passed["cumulative_pedestrians"].diff() > 0]["time"].to_numpy()
    if len(times) < 10:
        raise ValueError(f"only {len(times)} have passed an opening of {width} m")
    return float((len(times) - 1) / (times[-1] - times[0]))


def rimea_4(walk: Program) -> Iterator[Found]:
    """Yield densities (1/m²) and speeds (m/s) in a corridor that is full at first.

    RiMEA's is 1,000 m by 10 m. This one is 60 m by 4 m, and full for 36 m of its length. PedPy
    measures in 2 m by 2 m, 3 to 10 s after all set out, which is before either end of the crowd is
    felt there. Means of several random starts.
    """
    floor, length = rectangle(60.0, 4.0), 36.0
    area = pedpy.MeasurementArea([(18.0, 1.0), (20.0, 1.0), (20.0, 3.0), (18.0, 3.0)])
    for density in DENSITIES:
        results = []
        for seed in STARTS:
            starts = strewn((0.3, 0.25), (length, 3.75), round(density * length * 4.0), seed)
            speeds = drawn(len(starts))
            walkers = [
                Walker(at, ((59.5, at[1]),), v) for at, v in zip(starts, speeds, strict=True)
            ]
            data = walk(Scene(floor, walkers, 10.0))
            dense = pedpy.compute_classic_density(traj_data=data, measurement_area=area)
            individual = pedpy.compute_individual_speed(
                traj_data=data,
                frame_step=2,
                speed_calculation=pedpy.SpeedCalculation.BORDER_SINGLE_SIDED,
            )
            speed = pedpy.compute_mean_speed_per_frame(
                traj_data=data, individual_speed=individual, measurement_area=area
            )
            steady = slice(3 * RATE, None)
            results.append(
                Found(
                    float(dense["density"].to_numpy()[steady].mean()),
                    float(np.nanmean(speed["speed"].to_numpy()[steady])),
                )
            )
        yield Found(*(statistics.mean(column) for column in zip(*results, strict=True)))


def lanes(walk: Program, rate: float) -> tuple[float, float]:
    """Return how far counterflow in a corridor of 3 m has parted into lanes: from 0 to 1.

    `rate` people per second come in at each of three places at either end. It is the order
    parameter of M. Moussaïd et al. ("Traffic instabilities in self-organized pedestrian crowds",
    PLoS Comput. Biol. 8, 2012) over strips of a body's width: the mean, over people and time, of
    ((n - m) / (n + m))², where n people of one's strip go one's way and m the other. The second
    figure is what it would be if as many people were anywhere across the corridor. Means of
    several draws of when they come in.
    """
    orders = [_lanes(walk, rate, seed) for seed in STARTS]
    return statistics.mean(one for one, _ in orders), statistics.mean(one for _, one in orders)


def _lanes(walk: Program, rate: float, seed: int) -> tuple[float, float]:
    length, width, strip, count = 20.0, 3.0, 2 * RADIUS, 15
    chance, walkers = random.Random(seed), []
    for here, there in ((0.5, length - 0.5), (length - 0.5, 0.5)):
        for y in (0.5, 1.5, 2.5):
            t = 0.0
            for _ in range(count):
                t += chance.expovariate(rate)
                walkers.append(Walker((here, y), ((there, y),), enters=t))
    data = walk(Scene(rectangle(length, width), walkers, 50.0)).data
    rows = data[(data.frame >= 20 * RATE) & (data.frame % 2 == 0) & data.x.between(4.0, 16.0)]
    across = np.random.default_rng(1).uniform(RADIUS, width - RADIUS, len(rows))

    def order(y: NDArray[np.float64]) -> float:
        frame = rows.assign(strip=np.floor(y / strip), way=np.where(rows.id < 3 * count, 1, -1))
        parted = frame.groupby(["frame", "strip"])["way"].agg(["sum", "count"])
        return float(((parted["sum"] / parted["count"]) ** 2 * parted["count"]).sum() / len(rows))

    return order(rows.y.to_numpy()), order(across)


def rimea_9(walk: Program, people: int, doors: int) -> NDArray[np.float64]:
    """Return when each of many people leaves a hall (s) by four doors or by two.

    The hall is 30 m by 20 m, with doors of 1 m. All people take the nearest. RiMEA's are 1,000.
    """
    low = [(7.5, -1.0, 8.5, 0.0), (21.5, -1.0, 22.5, 0.0)]
    every = [*low, *((x0, 20.0, x1, 21.0) for x0, _, x1, _ in low)]
    floor = shapely.union_all([rectangle(30.0, 20.0), *(shapely.box(*one) for one in every)])
    ways = [((x0 + x1) / 2, (y0 + y1) / 2) for x0, y0, x1, y1 in every[-doors:]]
    starts = filled((0.5, 0.5), (29.5, 19.5), people)
    walkers = [
        Walker(at, (min(ways, key=lambda way, at=at: math.dist(way, at)),), v)
        for at, v in zip(starts, drawn(people), strict=True)
    ]
    duration = 4.0 * people / doors + 60.0
    left = np.sort(durations(walk(Scene(floor, walkers, duration))))
    return np.where(left < duration, left, np.inf)


def rimea_12(walk: Program, people: int = 150) -> tuple[float, float, float]:
    """Return the greatest densities (1/m²) before a corridor and before the way out behind it.

    150 people leave a room of 10 m by 10 m by a corridor of 1 m by 5 m, and the room behind it, as
    large, by a door of 1 m. The third figure is when the last has left (s), or infinity.
    """
    walls = [(10.0, 0.0, 15.0, 4.5), (10.0, 5.5, 15.0, 10.0)]
    walls += [(25.0, 0.0, 26.5, 4.5), (25.0, 5.5, 26.5, 10.0)]
    starts = filled((0.3, 0.3), (9.5, 9.7), people)
    walkers = [Walker(at, ((26.0, 5.0),), v) for at, v in zip(starts, drawn(people), strict=True)]
    duration = 400.0
    data = walk(Scene(rectangle(26.5, 10.0, *walls), walkers, duration))
    before = []
    for x in (10.0, 25.0):
        area = pedpy.MeasurementArea([(x - 2, 4.0), (x, 4.0), (x, 6.0), (x - 2, 6.0)])
        dense = pedpy.compute_classic_density(traj_data=data, measurement_area=area)
        before.append(float(dense["density"].rolling(5 * RATE, min_periods=1).mean().max()))
    last = float(durations(data).max())
    return before[0], before[1], last if last < duration else math.inf


class Diagrams(NamedTuple):
    """Results of one program in the scenes with a diagram."""

    files: list[Found]
    openings: list[Found]
    full: list[Found]
    lanes: list[tuple[float, float]]
    four: NDArray[np.float64]
    two: NDArray[np.float64]
    rooms: tuple[float, float, float]


def measured(walk: Program, people: int) -> Diagrams:
    """Walk all scenes with a diagram."""
    return Diagrams(
        list(single_file(walk)),
        list(bottleneck(walk)),
        list(rimea_4(walk)),
        [lanes(walk, rate) for rate in RATES],
        rimea_9(walk, people, 4),
        rimea_9(walk, people, 2),
        rimea_12(walk),
    )


@styled()
def draw(ours: Diagrams, theirs: Diagrams, path: Path) -> None:
    """Draw both programs' diagrams beside the literature's."""
    figure = new_figure("double", 4.6)
    (file, full, opening), (parted, halls, rooms) = figure.subplots(2, 3)
    v = np.linspace(0.0, 1.1, 50)
    file.plot(v, [seyfried(one) for one in v], color=BLACK, label="Seyfried et al. 2005")
    file.set(xlabel="speed (m/s)", ylabel="length per person (m)", ylim=(0.0, None))
    rho = np.linspace(0.05, 3.0, 100)
    full.plot(rho, [weidmann(one) for one in rho], color=BLACK, label="Weidmann 1993")
    full.set(xlabel="density (1/m²)", ylabel="speed (m/s)", ylim=(0.0, 1.7))
    opening.axhspan(1.2, 2.2, facecolor=PALE, label="experiments")
    opening.set(xlabel="width (m)", ylabel="specific flow (1/(m s))", ylim=(0.0, 3.0))
    inflow = [3 * rate for rate in RATES]
    chance = [one for _, one in ours.lanes]
    parted.plot(inflow, chance, color=BLACK, label="by chance")
    parted.set(xlabel="people each way (1/s)", ylabel="order of lanes", ylim=(0.0, 1.05))
    halls.set(xlabel="time (s)", ylabel="people in the hall")
    rooms.set(ylabel="greatest density (1/m²)", xticks=(0, 1), xlim=(-0.5, 1.5))
    rooms.set_xticklabels(["before the\ncorridor", "before the\nway out"])
    for k, (name, color, data) in enumerate(
        (("Floorwalker", BLUE, ours), ("JuPedSim", VERMILION, theirs))
    ):
        marks = {"color": color, "marker": "os"[k], "linestyle": "", "label": name}
        marks |= {"markersize": 4 + 2 * k, "markerfacecolor": "none" if k else color}
        for axes, points in ((file, data.files), (full, data.full), (opening, data.openings)):
            axes.plot(*zip(*points, strict=True), **marks)
        parted.plot(inflow, [one for one, _ in data.lanes], **marks)
        for times, style, doors in ((data.four, "-", "four doors"), (data.two, "--", "two")):
            gone = np.sort(times[np.isfinite(times)])[:: max(len(times) // 60, 1)]
            left = len(times) - np.searchsorted(np.sort(times), gone, side="right")
            halls.plot(gone, left, style, color=color, label=f"{name}, {doors}")
        rooms.bar(np.arange(2) + 0.3 * k - 0.15, data.rooms[:2], 0.28, color=color, label=name)
    for axes in (file, full, opening, parted, halls, rooms):
        axes.legend(loc="best", frameon=False, fontsize=6)
        axes.grid(color=GREY, alpha=0.2, linewidth=0.5)
    plots.save(figure, path)


def diagram_rows(ours: Diagrams, theirs: Diagrams) -> Iterator[str]:
    """Yield the diagrams' rows of the table in `docs/people-validation.md`, in Markdown."""

    def row(
        scene: str, published: str, figures: Callable[[Diagrams], Sequence[float]], digits: int = 2
    ) -> str:
        cells = [", ".join(f"{one:.{digits}f}" for one in figures(data)) for data in (ours, theirs)]
        return _line(scene, published, *cells)

    speeds, widths, rates = (
        ", ".join(f"{figure:g}" for figure in figures) for figures in (SPEEDS, WIDTHS, RATES)
    )
    file = ", ".join(f"{seyfried(one):.2f}" for one in SPEEDS)
    full = "full corridor, 1.34 ± 0.26 m/s (RiMEA 4)"
    yield row(f"{full}: density, 1/m²", "–", lambda d: [one.at for one in d.full])
    yield row("its speed, m/s", "Weidmann 1993", lambda d: [one.figure for one in d.full])
    yield row(
        "its difference from Weidmann's speed at that density, %",
        "0",
        lambda d: [100 * (speed / weidmann(at) - 1) for at, speed in d.full],
        0,
    )
    hall = "people leave a 30 m by 20 m hall through four 1 m doors, or two (RiMEA 9)"
    hall = f"{len(ours.four):,} {hall}"
    yield _line(hall, HALL, *(f"{_left(one.four)}; {_left(one.two)}" for one in (ours, theirs)))
    rooms = "150 people leave a room through a corridor into a room with a door (RiMEA 12)"
    jam = "a jam before the corridor only"
    yield row(f"{rooms}: peak density before corridor and door, 1/m²", jam, lambda d: d.rooms[:2])
    yield row("time until the last has left, s", "–", lambda d: d.rooms[2:], 0)
    flows = "1.2 to 2.2"
    opening = f"twenty through openings of {widths} m, people per metre and second"
    yield row(opening, flows, lambda d: [one.figure for one in d.openings])
    single = f"single file at {speeds} m/s, metres per person"
    yield row(single, f"Seyfried et al. 2005: {file}", lambda d: [one.figure for one in d.files])
    lane = f"counterflow of {rates} people per second from each of three places: lane order, 0 to 1"
    yield row(lane, "more than by chance", lambda d: [one for one, _ in d.lanes])
    yield row("the same by chance", "–", lambda d: [one for _, one in d.lanes])


HALL = "about twice as long with two"


def _left(times: NDArray[np.float64]) -> str:
    """Return in words when the last person left a hall, and how many did not."""
    gone = times[np.isfinite(times)]
    stay = len(times) - len(gone)
    return f"all after {gone.max():.0f} s" if not stay else f"{stay} of {len(times)} remain"


def _line(*cells: str) -> str:
    return f"| {' | '.join(cells)} |"


def published(people: int, plot: Path) -> str:
    """Measure everything, draw the diagrams, and return the table of the documents."""
    lines = [_line("scene", "literature", "Floorwalker", "JuPedSim"), "|---|---|---|---|"]
    for scene, figure, measure in ROWS:
        lines.append(_line(scene, figure, measure(floorwalker), measure(jupedsims)))
    both = measured(floorwalker, people), measured(jupedsims, people)
    draw(*both, plot)
    return "\n".join([*lines, *diagram_rows(*both)])


def main() -> None:
    """Measure, print the table in Markdown, and draw."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n\n")[0])
    parser.add_argument("--plot", type=Path, default=Path("docs/images/literature.svg"))
    parser.add_argument("--people", type=int, default=1000, help="in the hall of RiMEA 9")
    options = parser.parse_args()
    begin = time.process_time()
    print(published(options.people, options.plot))
    print(f"{time.process_time() - begin:.0f} s of CPU")


if __name__ == "__main__":
    main()
