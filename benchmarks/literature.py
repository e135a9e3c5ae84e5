"""People among people against the literature: figures and plot of docs/people-among-people.md.

Bodies have a radius of 0.2 m and walk at up to 1.34 m/s, as in the literature; in a single file,
through openings, one way and both ways in a corridor, beside somebody who stands, and in the tests
1, 5, 6 and 7 of RiMEA (Richtlinie für Mikroskopische Entfluchtungsanalysen, version 3, 2016). PedPy
measures what it has a method for.

    python benchmarks/literature.py [--plot docs/images/literature.svg]
"""

from __future__ import annotations

import argparse
import math
import random
import statistics
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pedpy
from numpy.typing import NDArray

import sim
from navigation import CollisionWorld
from sim.views import plots
from sim.views.plots.style import BLACK, BLUE, GREY, PALE, new_figure, styled

RADIUS, FREE_SPEED, SPREAD = 0.2, 1.34, 0.26
"""Metres, and m/s with their standard deviation: U. Weidmann, "Transporttechnik der Fussgänger",
ETH Zürich, 1993."""

RATE = 10.0
"""Hz. Frames for PedPy."""


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


def trial(
    size: tuple[float, float],
    starts: Sequence[tuple[float, float]],
    sinks: Sequence[tuple[float, float]],
    duration: float,
    *,
    walls: Sequence[tuple[float, float, float, float]] = (),
    speeds: Sequence[float] = (),
) -> sim.Trial:
    """People who walk on a floor with walls (x0, y0, x1, y1) from their starts to their sinks."""
    width, depth = size
    lines = [
        "floorplan:",
        "  name: floor",
        f"  boundary: [[0, 0], [{width}, 0], [{width}, {depth}], [0, {depth}]]",
        f"  safe_zone: {{at: [{starts[0][0]}, {starts[0][1]}]}}",
        f"  human: {{radius: {RADIUS}, max_speed: {FREE_SPEED}}}",
    ]
    if walls:
        lines.append("  obstacles:")
    for k, (x0, y0, x1, y1) in enumerate(walls):
        lines.append(f"    wall{k}: {{x: [{x0}, {x1}], y: [{y0}, {y1}], z: [0, 2]}}")
    lines += [f"duration: {duration}", "people:"]
    for k, (start, sink) in enumerate(zip(starts, sinks, strict=True)):
        speed = f", max_speed: {speeds[k]}" if speeds else ""
        lines.append(
            f"  - {{name: p{k}, personality: visitor, at: [{start[0]}, {start[1]}],"
            f" sink: [{sink[0]}, {sink[1]}]{speed}}}"
        )
    return sim.Trial.parse("\n".join(lines))


def trajectories(run: sim.Run) -> pedpy.TrajectoryData:
    """Return a run as PedPy reads it."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "run.sqlite"
        sim.export(run, path, rate=RATE)
        return pedpy.load_trajectory_from_jupedsim_sqlite(trajectory_file=path)


def single_file(speeds: Sequence[float] = (0.1, 0.2, 0.4, 0.6, 0.8, 1.0)) -> Iterator[Found]:
    """Yield the distances in a file of six behind somebody who walks at a speed."""
    for speed in speeds:
        count, length = 6, 12.0 + 12.0 * speed
        starts = [(7.0 - 1.2 * k, 0.35) for k in range(count)]
        duration = (length - 8.0) / speed
        one = trial(
            (length + 3.0, 0.7),
            starts,
            [(length + 2.0, 0.35)] * count,
            duration,
            speeds=[speed, *[FREE_SPEED] * (count - 1)],
        )
        run = sim.run(one)
        times = np.linspace(duration / 2, duration, 100)
        x = np.array([run.motions[f"p{k}"].position(times)[:, 0] for k in range(count)])
        yield Found(speed, float(np.mean(-np.diff(x, axis=0))))


def corridor(densities: Sequence[float] = (0.25, 0.5, 1.0, 1.5, 2.0)) -> Iterator[Found]:
    """Yield densities and speeds in the middle of a corridor of 4 m, all one way, by PedPy.

    Everybody has a speed of their own, as far as others let them.
    """
    width, block = 4.0, 6.0
    for density in densities:
        step = 1 / math.sqrt(density)
        rows, columns = max(int(width / step), 1), max(int(block / step), 1)
        starts = [
            (0.5 + step * (c + 0.5), (r + 0.5) * width / rows)
            for c in range(columns)
            for r in range(rows)
        ]
        sinks = [(26.0, y) for _, y in starts]
        chance = random.Random(1)
        speeds = [min(max(chance.gauss(FREE_SPEED, SPREAD), 0.6), 2.0) for _ in starts]
        run = sim.run(trial((27.0, width), starts, sinks, 30.0, speeds=speeds))
        data = trajectories(run)
        area = pedpy.MeasurementArea([(10.0, 0.5), (14.0, 0.5), (14.0, 3.5), (10.0, 3.5)])
        dense = pedpy.compute_classic_density(traj_data=data, measurement_area=area)
        individual = pedpy.compute_individual_speed(
            traj_data=data,
            frame_step=2,
            speed_calculation=pedpy.SpeedCalculation.BORDER_SINGLE_SIDED,
        )
        speed = pedpy.compute_mean_speed_per_frame(
            traj_data=data, individual_speed=individual, measurement_area=area
        )
        densities_then, speeds_then = dense["density"].to_numpy(), speed["speed"].to_numpy()
        full = densities_then >= 0.8 * densities_then.max()
        yield Found(float(densities_then[full].mean()), float(np.nanmean(speeds_then[full])))


def bottleneck(widths: Sequence[float] = (0.8, 1.0, 1.2, 1.6, 2.0)) -> Iterator[Found]:
    """Yield the flows (1/s) of twenty through openings."""
    for width in widths:
        starts = [(1.0 + 0.7 * c, 1.0 + 0.8 * r) for c in range(4) for r in range(5)]
        low, high = 2.6 - width / 2, 2.6 + width / 2
        run = sim.run(
            trial(
                (12.0, 5.2),
                starts,
                [(11.5, 0.5 + 0.21 * k) for k in range(20)],
                90.0,
                walls=[(5.5, 0.0, 6.0, low), (5.5, high, 6.0, 5.2)],
            )
        )
        line = pedpy.MeasurementLine([(6.0, 0.0), (6.0, 5.2)])
        passed, _ = pedpy.compute_n_t(traj_data=trajectories(run), measurement_line=line)
        passed = passed[passed["cumulative_pedestrians"].diff() > 0]
        times = passed["time"].to_numpy()
        if len(times) < 10:
            raise ValueError(f"only {len(times)} have passed an opening of {width} m")
        yield Found(width, float((len(times) - 1) / (times[-1] - times[0])))


def rimea_1() -> float:
    """Return the seconds that one person takes for 40 m at 1.33 m/s; RiMEA wants 26 to 34."""
    run = sim.run(trial((42.0, 2.0), [(1.0, 1.0)], [(41.0, 1.0)], 60.0, speeds=[1.33]))
    return float(run.summary["people"]["p0"]["left"])


def rimea_6() -> tuple[int, float]:
    """Return how many of twenty got round a corner, and the least distance to a wall (m)."""
    starts = [(0.5 + 0.6 * c, 0.3 + 0.45 * r) for c in range(5) for r in range(4)]
    sinks = [(10.4 + 0.3 * (k % 5), 10.2 + 0.4 * (k // 5)) for k in range(20)]
    run = sim.run(trial((12.0, 12.0), starts, sinks, 90.0, walls=[(0.0, 2.0, 10.0, 12.0)]))
    world = CollisionWorld(run.trial.floorplan)
    least = math.inf
    for name, (begin, end) in run.presence.items():
        times = np.arange(begin, end - 1e-6, 0.02)
        least = min(least, float(world.clearance(run.motions[name].position(times))))
    return int(run.summary["left"]), least


def rimea_7() -> float:
    """Return the greatest deviation of a speed from what it should be, as a share of it.

    Twenty people of the speeds of Weidmann's ages walk 20 m side by side.
    """
    speeds = [round(0.6 + 0.055 * k, 3) for k in range(20)]
    starts = [(1.0, 0.5 + k) for k in range(20)]
    run = sim.run(trial((24.0, 20.0), starts, [(22.0, y) for _, y in starts], 60.0, speeds=speeds))
    off = []
    for k, speed in enumerate(speeds):
        times = np.linspace(3.0, 12.0, 200)
        found = np.hypot(*run.motions[f"p{k}"].velocity(times).T)
        off.append(abs(statistics.mean(found.tolist()) / speed - 1))
    return max(off)


def lanes(rate: float = 0.25) -> tuple[float, float]:
    """Return how far counterflow in a corridor of 3 m has parted into lanes: from 0 to 1.

    `rate` people per second come in at each of three places at either end. It is the order
    parameter of M. Moussaïd et al. ("Traffic instabilities in self-organized pedestrian crowds",
    PLoS Comput. Biol. 8, 2012) over strips of a body's width: the mean, over people and time, of
    ((n - m) / (n + m))², where n people of one's strip go one's way and m the other. The second
    figure is what it would be if as many people were anywhere across the corridor.
    """
    length, width, strip, count = 20.0, 3.0, 2 * RADIUS, 15
    lines = ["floorplan:", "  name: floor"]
    lines += [f"  boundary: [[0, 0], [{length}, 0], [{length}, {width}], [0, {width}]]"]
    lines += [
        f"  safe_zone: {{at: [1, 1.5]}}\n  human: {{radius: {RADIUS}, max_speed: {FREE_SPEED}}}"
    ]
    lines += ["duration: 50", "people:"]
    for way, (here, there) in enumerate(((0.5, length - 0.5), (length - 0.5, 0.5))):
        lines += [
            f"  - {{name: w{way}{row}, personality: visitor, sink: [{there}, {y}],"
            f" source: {{at: [{here}, {y}], rate: {rate}, count: {count}}}}}"
            for row, y in enumerate((0.5, 1.5, 2.5))
        ]
    run = sim.run(sim.Trial.parse("\n".join(lines)))
    times = np.arange(20.0, 50.0, 0.2)
    at = np.array([motion.position(times) for motion in run.motions.values()])
    inside = (at[..., 0] > 4.0) & (at[..., 0] < length - 4.0)
    east = np.array([name.startswith("w0") for name in run.motions])[:, np.newaxis]
    chance = np.random.default_rng(1)

    def order(rows: NDArray[np.float64]) -> float:
        found = []
        for k in range(len(rows)):
            same = inside & (rows == rows[k])
            n, m = (same & east).sum(axis=0), (same & ~east).sum(axis=0)
            found += (((n - m) / np.maximum(n + m, 1)) ** 2)[inside[k]].tolist()
        return float(np.mean(found))

    anywhere = chance.uniform(RADIUS, width - RADIUS, at.shape[:2])
    return order(np.floor(at[..., 1] / strip)), order(np.floor(anywhere / strip))


def rimea_5() -> float:
    """Return the greatest deviation (s) from ten reaction times of 10 to 100 s of who sets out."""
    delays = [10.0 * (k + 1) for k in range(10)]
    lines = ["floorplan:", "  name: floor", "  boundary: [[0, 0], [8, 0], [8, 5], [0, 5]]"]
    lines += [
        "  safe_zone: {at: [1, 1]}",
        f"  human: {{radius: {RADIUS}, max_speed: {FREE_SPEED}}}",
    ]
    lines += ["duration: 120", "people:"]
    for k, delay in enumerate(delays):
        lines.append(
            f"  - {{name: p{k}, personality: visitor, start: {{time: {delay}}},"
            f" at: [{1.0 + k // 5}, {0.6 + 0.9 * (k % 5)}], sink: [7.5, 2.5]}}"
        )
    run = sim.run(sim.Trial.parse("\n".join(lines)))
    set_out = [
        next(piece.begin for piece in run.motions[f"p{k}"].pieces if piece.x[1:] != (0, 0, 0))
        for k in range(10)
    ]
    return max(abs(t - delay) for t, delay in zip(set_out, delays, strict=True))


def standing_still() -> tuple[float, float]:
    """Return the seconds lost past somebody who stands, and the gap (m) where nobody gets past.

    As the tests of Jülich want it: one walks on past the other where there is room for that, and
    stops behind them, without touching, where there is none.
    """
    found = []
    for width in (3.0, 0.7):
        starts = [(1.0, width / 2), (8.0, width / 2)]
        given = trial((16.0, width), starts, [(15.0, width / 2), starts[1]], 40.0)
        stays = replace(given.people[1], personality="indifferent", actions=None, sink=None)
        stays = replace(
            stays, start=sim.Start(1e5), manners=replace(stays.manners, steps_aside=False)
        )
        found.append(sim.run(replace(given, people=(given.people[0], stays))))
    past, behind = found
    left = past.summary["people"]["p0"]["left"]
    gap = behind.summary["nearest_people"]["distance"]
    return float(left - 14.0 / FREE_SPEED), float(gap)


@styled()
def draw(
    files: Sequence[Found], flows: Sequence[Found], openings: Sequence[Found], path: Path
) -> None:
    """Draw the three diagrams beside the literature's."""
    figure = new_figure("double", 2.4)
    left, middle, right = figure.subplots(1, 3)
    v = np.linspace(0.0, 1.1, 50)
    left.plot(v, [seyfried(one) for one in v], color=BLACK, label="Seyfried et al. 2005")
    left.plot(*zip(*files, strict=True), "o", color=BLUE, label="Floorwalker")
    left.set(xlabel="speed (m/s)", ylabel="length per person (m)", ylim=(0.0, None))
    rho = np.linspace(0.05, 3.0, 100)
    middle.plot(rho, [weidmann(one) for one in rho], color=BLACK, label="Weidmann 1993")
    middle.plot(*zip(*flows, strict=True), "o", color=BLUE)
    middle.set(xlabel="density (1/m²)", ylabel="speed (m/s)", ylim=(0.0, 1.5))
    right.axhspan(1.2, 2.2, facecolor=PALE, label="experiments")
    right.plot(*zip(*((w, f / w) for w, f in openings), strict=True), "o", color=BLUE)
    right.set(xlabel="width (m)", ylabel="specific flow (1/(m s))", ylim=(0.0, 2.4))
    for axes in (left, middle, right):
        axes.legend(loc="best", frameon=False, fontsize=6)
        axes.grid(color=GREY, alpha=0.2, linewidth=0.5)
    plots.save(figure, path)


def main() -> None:
    """Measure, print tables in Markdown, and draw."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n\n")[0])
    parser.add_argument("--plot", type=Path, default=Path("docs/images/literature.svg"))
    asked = parser.parse_args()
    print(f"RiMEA 1: {rimea_1():.1f} s")
    print("RiMEA 6: {} of 20 round the corner, nearest to a wall {:.3f} m".format(*rimea_6()))
    print(f"RiMEA 7: speeds off by {100 * rimea_7():.2f} % at most")
    print(f"RiMEA 5: set out {rimea_5():.3f} s off at most")
    print(
        "somebody who stands: {:.2f} s lost past them, {:.3f} m behind them".format(
            *standing_still()
        )
    )
    for rate in (0.15, 0.25, 0.4):
        print("lanes, {:.2f}/s: order {:.2f}, by chance {:.2f}".format(3 * rate, *lanes(rate)))
    files = list(single_file())
    for speed, length in files:
        print(f"file, {speed:.1f} m/s: {length:.2f} m ({length / seyfried(speed) - 1:+.0%})")
    openings = list(bottleneck())
    for width, flow in openings:
        print(f"opening, {width:.1f} m: {flow:.2f}/s, {flow / width:.2f}/(m s)")
    flows = list(corridor())
    for density, speed in flows:
        print(f"corridor, {density:.2f}/m²: {speed:.2f} m/s ({speed / weidmann(density) - 1:+.0%})")
    draw(files, flows, openings, asked.plot)


if __name__ == "__main__":
    main()
