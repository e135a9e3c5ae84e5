"""Pictures of runs: their curves are the motions, and their marks the referee's."""

import io
import math
import os
import re
import shutil
import subprocess
import sys
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import shapely
from hypothesis import given, strategies as st
from run_events import Figure, Recorded, Scene, record
from shapely.geometry import box

import floorplan
import sim
from navigation import CollisionWorld, PathPlanner, join, standing, walk
from sim.views import plots
from sim.views.plots.floor import draw_floor, draw_names, floor_figure
from sim.views.plots.maps import HEAT_CELL, profiles_of, time_covered
from sim.views.plots.style import instants
from sim.views.replay_data import replay_data

matplotlib = pytest.importorskip("matplotlib")

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"

TRIAL = """
name: busy
floorplan: ariac2023
duration: 60.0
people:
  - {name: ada, personality: antagonistic}
  - {name: ben, personality: helpful, start: {time: 5.0}}
gantry:
  controller: oblivious
  repeat: true
  jobs: [{move: [-4.0, 1.0, 1.0]}, {move: [-10.0, -1.0, 0.0]}, {wait: 5}]
agvs:
  agv1: [{time: 20.0, to: assembly_front}]
"""


def curve(axes, label):
    (line,) = [line for line in axes.lines if line.get_label() == label]
    return np.asarray(line.get_xdata(), float), np.asarray(line.get_ydata(), float)


def broken_at(t):
    """Return the times before and after each gap of a curve."""
    (gaps,) = np.nonzero(np.isnan(t))
    return [(t[gap - 1], t[gap + 1]) for gap in gaps]


def recorded(scene, duration, events, motions):
    """Return a run with only these events and motions."""
    return Recorded(scene, duration, summary={}, events=events, motions=motions, violations={})


def is_violation(event, person, machine):
    pair = (event.get("person"), event.get("with"))
    return event["kind"] == "violation" and pair == (person, machine)


def teleports(run, person):
    return [e["t"] for e in run.events if e["kind"] == "teleport" and e["person"] == person]


points = st.tuples(st.floats(-9.0, 9.0), st.floats(-9.0, 9.0))
legs = st.lists(st.lists(points, min_size=2, max_size=4, unique=True), min_size=1, max_size=4)


@given(legs, st.none() | legs, st.floats(0.0, 5.0), st.floats(0.1, 60.0))
def test_a_curve_follows_its_motion_and_breaks_where_it_jumps(one, other, begin, length):
    motions = []
    for way in filter(None, (one, other)):
        t, walks = 0.0, []
        for corners in way:
            walks.append(walk(corners, t, max_speed=1.0, max_acceleration=2.5))
            t = walks[-1].end + 0.5
        motions.append(join(walks))
    end = begin + length
    t = instants(motions, begin, end)
    times = t[~np.isnan(t)]
    assert times[0] == begin
    assert times[-1] == pytest.approx(end) and (np.diff(times) >= 0).all()
    jumps = sorted({j for motion in motions for j in motion.jumps if begin < j < end})
    assert [after for _, after in broken_at(t)] == jumps
    stretches = np.split(t, np.flatnonzero(np.isnan(t)))
    for stretch in stretches:
        nodes = stretch[~np.isnan(stretch)]
        between = np.linspace(nodes[0], nodes[-1], 97)
        for motion in motions:
            drawn = [np.interp(between, nodes, motion.position(nodes)[:, k]) for k in (0, 1)]
            # No person brakes harder than 2.5 m/s², so a chord of 0.1 s is off by at most 2.5 ·
            # 0.1² / 8.
            assert np.abs(np.column_stack(drawn) - motion.position(between)).max() < 0.0033


def test_separation_shows_distance_and_requirement_as_they_were(run):
    figure = run.plot.separation("ada")
    (axes,) = figure.axes
    t, distance = curve(axes, "distance")
    gaps = broken_at(t)
    assert teleports(run, "ada")
    assert [after for _, after in gaps] == pytest.approx(teleports(run, "ada"))
    ada, gantry = run.motions["ada"], run.motions["gantry"]
    for instant, shown in zip(t.tolist(), distance.tolist(), strict=True):
        if not math.isnan(instant):
            assert shown == pytest.approx(
                math.dist(ada.state(instant).at, gantry.state(instant).at)
            )
    t, required = curve(axes, "required distance")
    counted = [event for event in run.events if is_violation(event, "ada", "gantry")]
    assert counted
    for event in counted:
        shown = required[np.abs(t - event["t"]) < 1e-8].tolist()
        assert event["required"] in [pytest.approx(one) for one in shown]
    assert np.nanmin(required) == 1.0
    assert np.nanmax(required) == pytest.approx(2.5 + 1.0 + gantry_top_speed(run), abs=1e-3)


def gantry_top_speed(run):
    """Return the top speed while ada walks at 1 m/s. The requirement adds it times t1 = 1 s."""
    t = instants([run.motions["gantry"], run.motions["ada"]], 0.0, run.duration)
    t = t[~np.isnan(t)]
    speeds = [np.hypot(*run.motions[body].velocity(t).T) for body in ("gantry", "ada")]
    return speeds[0][speeds[1] > 0.999].max()


def test_separation_marks_every_violation(run):
    figure = run.plot.separation()
    for axes, person in zip(figure.axes, ("ada", "ben"), strict=True):
        shown = {
            label: curve(axes, label)[0].tolist()
            for label in axes.get_legend_handles_labels()[1]
            if label in ("violation", "too close, not counted")
        }
        begins = [begin for begin, _ in run.violations[person, "gantry"]]
        assert sorted(t for times in shown.values() for t in times) == begins
        counted = [event for event in run.events if is_violation(event, person, "gantry")]
        assert len(shown.get("violation", [])) == len(counted) > 0


def test_names_of_people_leave_room_for_the_floor():
    hall = "{boundary: [[0, 0], [30, 0], [30, 4], [0, 4]]}"
    text = f"floorplan: {hall}\nduration: 1\npeople: [{{name: p, count: COUNT, at: anywhere}}]\n"
    for count, named in ((12, 12), (20, 0)):
        run = sim.run(sim.Trial.parse(text.replace("COUNT", str(count))))
        figure = run.plot.trails()
        figure.draw_without_rendering()
        assert figure.axes[0].get_position().height * figure.get_figheight() > 0.5
        assert sum(len(legend.get_texts()) for legend in figure.legends) == named


def test_separation_of_a_long_run_is_drawn_in_columns(run, monkeypatch):
    (axes,) = run.plot.separation("ada").axes
    _, distance = curve(axes, "distance")
    _, required = curve(axes, "required distance")
    module = sys.modules["sim.views.plots.time_series"]
    monkeypatch.setattr(module, "DENSEST", 0)  # as if the run were a long one
    monkeypatch.setattr(module, "COLUMNS", 20)
    (axes,) = run.plot.separation("ada").axes
    t, nearest = curve(axes, "nearest distance")
    assert len(t) == 20
    assert np.diff(t) == pytest.approx(run.duration / 20)
    assert nearest.min() == pytest.approx(np.nanmin(distance))
    assert curve(axes, "largest required distance")[1].max() == np.nanmax(required)
    ada, gantry = run.motions["ada"], run.motions["gantry"]
    for instant, shown in zip(t.tolist(), nearest.tolist(), strict=True):
        assert shown <= math.dist(ada.state(instant).at, gantry.state(instant).at) + 1e-9


def test_the_vehicle_that_came_too_close_is_shown(run):
    vehicles = tuple(one for one in run.scene.machines if one.category == "vehicle")
    alone = replace(run, scene=replace(run.scene, machines=vehicles), violations={})
    close = replace(alone, violations={("ben", "agv3"): ((1.0, 2.0),)})
    titles = [
        [axes.get_title(loc="left") for axes in one.plot.separation().axes]
        for one in (alone, close)
    ]
    assert titles == [["ada and agv1", "ben and agv1"], ["ada and agv1", "ben and agv3"]]


CREW = """
floorplan: ariac2023
duration: 15
rules: {gantry_law: {fixed: 3.0}, machine: none, person: none}
gantry: {at: [-10, -3, 0]}
people: [{name: crew, count: 9, at: anywhere}]
"""


def shown(figure):
    """Return the names of the people with a panel, in order."""
    return [axes.get_title(loc="left").split()[0] for axes in figure.axes]


def test_many_people_are_reduced_to_those_with_the_least_margin():
    run = sim.run(sim.Trial.parse(CREW))
    everybody = [person.name for person in run.scene.people]
    for within in ((0.0, 15.0), (0.0, 2.0)):
        t = np.linspace(*within, 20_000)
        least = {name: run.margin(name, "gantry", t).min() for name in everybody}
        figure = run.plot.separation(within=within)
        assert shown(figure) == sorted(everybody, key=least.__getitem__)[:6]
        assert "6 of 9" in figure.get_supxlabel()
    # An AGV that stands requires no distance, so the nearest people are shown.
    nearest = {name: run.distance(name, "agv1", t).min() for name in everybody}
    figure = run.plot.separation(machine="agv1", within=within)
    assert shown(figure) == sorted(everybody, key=nearest.__getitem__)[:6]
    assert "nearest" in figure.get_supxlabel()
    assert shown(run.plot.separation(everybody)) == everybody
    assert shown(run.plot.separation(["crew8", "crew2"])) == ["crew2", "crew8"]
    assert run.plot.separation(everybody).get_supxlabel() == ""


def test_people_with_most_violations_are_first_if_all_end_immediately():
    trial = CREW.replace("{gantry_law: {fixed: 3.0}, machine: none, person: none}", "paper")
    run = sim.run(sim.Trial.parse(trial.replace("duration: 15", "duration: 60")))
    counts = {}
    for person in run.scene.people:
        begun = [e for e in run.events if is_violation(e, person.name, "gantry")]
        if min(e["distance"] - e["required"] for e in begun) > -0.0005:
            counts[person.name] = len(begun)
    named = [counts[name] for name in shown(run.plot.separation()) if name in counts]
    assert len(named) >= 4 and named == sorted(counts.values(), reverse=True)[: len(named)]
    assert named[0] > named[-1]


def test_few_people_are_all_shown(run):
    few = sim.run(sim.Trial.parse(CREW.replace("count: 9", "count: 6")))
    figure = few.plot.separation()
    assert shown(figure) == [person.name for person in few.scene.people]
    assert figure.get_supxlabel() == ""


def test_the_command_names_omitted_people(tmp_path, floorwalker):
    (tmp_path / "crew.trial.yaml").write_text(CREW.replace("15", "2"))
    command = ("plot", "separation", "crew.trial.yaml", "--out", "s.svg")
    done = floorwalker(*command, cwd=tmp_path)
    assert (done.returncode, done.stdout) == (0, "s.svg\n")
    picture = (tmp_path / "s.svg").read_text()
    hint = re.search(r"--person (\w+)", done.stderr)
    assert hint and hint[0] in picture and f"{hint[1]} and gantry" not in picture
    done = floorwalker(*command, "--person", hint[1], "--person", "crew1", cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    picture = (tmp_path / "s.svg").read_text()
    assert f"{hint[1]} and gantry" in picture and "crew1 and gantry" in picture


def test_a_stationary_agv_requires_no_distance(run):
    (axes,) = run.plot.separation("ben", "agv1").axes
    t, required = curve(axes, "required distance")
    assert np.isnan(required[t < 20.0]).all()
    moving = required[(t > 20.1) & (t < 21.0)]
    assert np.isfinite(moving).all()


def test_space_time_has_bands_as_wide_as_bodies_and_breaks_at_teleports(run):
    along_x, along_y = run.plot.space_time().axes
    for axes, k in ((along_x, 0), (along_y, 1)):
        for person in ("ada", "ben"):
            _, at = curve(axes, person)
            t = instants([run.motions[person]], 0.0, run.duration)
            np.testing.assert_array_equal(at, run.motions[person].position(t)[:, k])
            assert [after for _, after in broken_at(t)] == pytest.approx(teleports(run, person))
    gantry = along_x.collections[0].get_paths()[0].vertices
    begin = gantry[np.isclose(gantry[:, 0], 0.0), 1]
    assert (begin.min(), begin.max()) == pytest.approx((-7 - 0.525, -7 + 0.525))


VEHICLES = """\
floorplan: {boundary: [[0, 0], [24, 0], [24, 8], [0, 8]]}
duration: 30
rules: observe
people: [{name: eve, personality: external, at: [14, 4], max_speed: 0.1}]
machines:
  fork: &fork {kind: amr, at: [2, 4, 0], load: [1, 0.6, 1], missions: [{go: [22, 4, 0]}]}
  cart: {<<: *fork, at: [20, 6, 3.14159], missions: [{go: [2, 6, 3.14159]}]}
fields:
  fork: &fields
    sets:
    - {name: empty, load: false, protective: [[9, 3], [-1, 3], [-1, -3], [9, -3]]}
    - {name: loaded, load: true, protective: [[4, 0.7], [-1, 0.7], [-1, -0.7], [4, -0.7]]}
  cart: *fields
"""


@pytest.fixture(scope="module")
def vehicles():
    return sim.run(sim.Trial.parse(VEHICLES))


def test_lines_of_several_vehicles_differ(vehicles):
    axes = vehicles.plot.space_time().axes[0]
    lines = {line.get_label(): line for line in axes.lines}
    assert lines["fork"].is_dashed() != lines["cart"].is_dashed()


def test_trails_have_the_field_that_stopped_a_vehicle(vehicles):
    (stop,) = (e for e in vehicles.events if e["kind"] == "field_stop")
    entered = next(e for e in vehicles.events if e["kind"] == "field_occupied")
    assert stop["machine"] == "fork" and entered["set"] == "loaded"
    (axes,) = vehicles.plot.trails().axes
    (area,) = (p for p in axes.patches if p.get_label() == "protective field at a stop")
    # The field touches the disc of the person who enters it.
    field = shapely.Polygon(area.get_path().vertices[:-1])
    assert field.area == pytest.approx(5 * 1.4)
    radius = vehicles.scene.people[0].radius
    eve = shapely.Point(vehicles.motions["eve"].position(entered["t"]))
    assert field.distance(eve) == pytest.approx(radius, abs=1e-6)
    (early,) = vehicles.plot.trails(within=(0.0, stop["t"] - 1)).axes
    assert not [p for p in early.patches if p.get_label() == "protective field at a stop"]


def test_a_replay_has_the_field_sets_for_the_load_of_a_vehicle(vehicles):
    fork = next(one for one in replay_data(vehicles)["bodies"] if one["name"] == "fork")
    assert [one["name"] for one in fork["fields"]] == ["loaded"]


def test_trails_break_at_teleports(run):
    (axes,) = run.plot.trails().axes
    for person in ("ada", "ben"):
        x, _ = curve(axes, person)
        assert np.isnan(x).sum() == len(teleports(run, person))
    x, y = curve(axes, "too close")
    first = run.violations["ada", "gantry"][0][0]
    assert run.motions["ada"].state_before(first).at in [*zip(x.tolist(), y.tolist(), strict=True)]


def test_all_trails_on_the_same_path_are_visible():
    """Later trails are thinner, so both edges of the earlier ones stay visible."""
    plan = floorplan.parse("{boundary: [[0, 0], [10, 0], [10, 4], [0, 4]]}")
    motion = walk([(1.0, 2.0), (9.0, 2.0)], max_speed=1.0, max_acceleration=2.5)
    for count in (1, 2, 4, 12):
        names = [f"p{k}" for k in range(count)]
        people = tuple(Figure(name, personality="", radius=0.4, height=1.7) for name in names)
        scene = Scene(
            trial="row",
            seed=0,
            floorplan=plan,
            rules=sim.PAPER,
            people=people,
            starts=dict.fromkeys(names, (1, 2, 0)),
        )
        run = recorded(scene, motion.end, (), dict.fromkeys(names, motion))
        (axes,) = run.plot.trails().axes
        lines = [line for line in axes.lines if line.get_label() in names]
        widths = [line.get_linewidth() for line in lines]
        assert [line.get_label() for line in sorted(lines, key=lambda line: line.zorder)] == names
        assert widths == sorted(widths, reverse=True) and len(set(widths)) == count
        assert widths[-1] == 1.0 and widths[0] < 6.0


def test_a_part_of_a_run(run):
    (axes,) = run.plot.separation("ada", within=(10.0, 20.0)).axes
    assert axes.get_xlim() == (10.0, 20.0)
    t, _ = curve(axes, "distance")
    assert (np.nanmin(t), np.nanmax(t)) == pytest.approx((10.0, 20.0))
    with pytest.raises(ValueError, match="nothing between 70 and 60 s: the run"):
        run.plot.trails(within=(70.0, 80.0))


def test_a_heat_map_adds_up(run):
    """The disc of a person covers π r² during all the time since the start."""
    seconds = time_covered(run)
    area = HEAT_CELL**2 * seconds.sum()
    everybody = math.pi * 0.3**2 * (60.0 + 55.0)
    assert area == pytest.approx(everybody, rel=0.03)


def test_a_heat_map_shows_the_time_of_people_in_each_cell():
    plan = floorplan.parse("{boundary: [[0, 0], [10, 0], [10, 4], [0, 4]]}")
    motion = walk([(1.0, 2.0), (9.0, 2.0)], max_speed=0.5, max_acceleration=2.5)
    scene = Scene(
        trial="walk",
        seed=0,
        floorplan=plan,
        rules=sim.PAPER,
        people=(Figure("ada", personality="", radius=0.4, height=1.7),),
        starts={"ada": (1.0, 2.0, 0.0)},
    )
    event = {"t": 0.0, "kind": "human_started", "person": "ada"}
    run = recorded(scene, motion.end, (event,), {"ada": motion})
    seconds = time_covered(run)
    row, column = int(2.0 / HEAT_CELL), int(5.0 / HEAT_CELL)
    assert seconds[row, column] == pytest.approx(2 * 0.4 / 0.5, abs=2 * HEAT_CELL / 0.5)
    assert seconds[int(1.5 / HEAT_CELL), column] == 0.0
    later = recorded(scene, motion.end, (), {"ada": motion})
    assert time_covered(later).sum() == 0.0
    two = plots.heat_map([run, run]).axes[0].images[0].get_array()
    np.testing.assert_allclose(two.filled(0.0), 2 * seconds)


def test_a_heat_map_without_people_is_rejected():
    alone = sim.run(sim.Trial.parse("{floorplan: ariac2023, duration: 1, people: []}"))
    with pytest.raises(ValueError, match="a heat map needs a person; there is none"):
        plots.heat_map(alone)


def test_a_short_required_distance_leaves_room_for_the_distance():
    text = """
floorplan: warehouse
duration: 20
rules: {based_on: observe, between: surfaces, agv_law: {fixed: 0.05}}
people: [{name: ann, at: [10.0, 17.0]}]
machines: {cart: {kind: amr, at: [3.0, 17.0, 0.0], missions: [{go: dock}]}}
"""
    (axes,) = sim.run(sim.Trial.parse(text)).plot.separation("ann").axes
    assert axes.get_ylim() == (0.0, 4.0)


def test_a_heat_map_of_different_floors_is_rejected(run):
    other = sim.run(sim.Trial(floorplan.load("warehouse"), duration=1.0))
    with pytest.raises(ValueError, match="not on the same floor"):
        plots.heat_map([run, other])


def test_density_and_speed_are_gaussian_profiles(run):
    """Compare with a sum of Gaussians at cells with people and at others."""
    density, speed = profiles_of(run)
    assert density.sum() * 0.1**2 == pytest.approx(len(run.scene.people), rel=0.02)
    times = np.arange(0.005, run.duration, 0.01)
    people = [run.motions[person.name] for person in run.scene.people]
    west, south, *_ = run.floorplan.boundary.bounds
    sigma = 1.0 / (2.0 * math.sqrt(2.0 * math.log(2.0)))
    most = density.max()
    for row, column in np.argwhere(density > 0.2 * most)[::17]:
        at = np.array([west, south]) + 0.1 * (np.array([column, row]) + 0.5)
        weights, flows = [], []
        for motion in people:
            apart = np.hypot(*(motion.position(times) - at).T)
            weight = np.exp(-((apart / sigma) ** 2) / 2.0) / (2.0 * math.pi * sigma**2)
            weights.append(weight.mean())
            flows.append((weight * np.hypot(*motion.velocity(times).T)).mean())
        assert density[row, column] == pytest.approx(sum(weights), rel=0.01)
        assert speed[row, column] == pytest.approx(sum(flows) / sum(weights), rel=0.02)
    drawn = plots.density_map([run, run], of="speed").axes[0].images[0].get_array()
    np.testing.assert_allclose(drawn.compressed(), speed[~drawn.mask])
    with pytest.raises(ValueError, match="density or speed"):
        plots.density_map(run, of="people")


def test_a_path_shows_the_clearance_along_it():
    world = CollisionWorld(floorplan.load("ariac2023"))
    way = PathPlanner(world, 0.3).plan((-15.0, -10.0), (-20.0, 1.2))
    _, profile = plots.path(world, way, radius=0.3).axes
    along, clearance = profile.lines[0].get_data()
    assert along[-1] == pytest.approx(way.length)
    assert clearance.min() == pytest.approx(way.clearance, abs=2e-3)
    narrowest = profile.lines[2].get_xydata()[0]
    assert narrowest[1] == clearance.min()


@pytest.mark.parametrize(("there", "width"), [(True, "single"), (False, "double")])
def test_the_words_in_the_profile_of_a_path_stand_apart(there, width):
    world = CollisionWorld(floorplan.load("ariac2023"))
    ends = [(-15.0, -10.0), (-16.2, -5.0)]
    way = PathPlanner(world, 0.3).plan(*(ends if there else ends[::-1]))
    figure = plots.path(world, way, radius=0.3, width=width)
    figure.draw_without_rendering()
    least, radius = (text.get_window_extent() for text in reversed(figure.axes[1].texts))
    assert not least.overlaps(radius)


FLOORS = (
    ("warehouse", "double"),
    pytest.param("ariac2023", "single", marks=pytest.mark.slow),
    pytest.param("ariac2023", "double", marks=pytest.mark.slow),
    pytest.param("machine_shop", "single", marks=pytest.mark.slow),
)


@cache
def floor(name, width):
    """Return a floor and its picture, cached because the placement of names takes a while."""
    plan = floorplan.load(name)
    (axes,) = plots.floorplan(plan, width=width).axes
    axes.figure.draw_without_rendering()
    return plan, axes


@pytest.mark.parametrize(("name", "width"), FLOORS)
def test_a_floor_shows_its_obstacles(name, width):
    plan, axes = floor(name, width)
    assert axes.figure.get_figwidth() == (3.5 if width == "single" else 7.16)
    assert len(axes.patches) == len(plan.obstacles) + len(plan.lanes) + bool(plan.gantry)
    written = {text.get_text() for text in axes.texts}
    assert {station.name for station in plan.stations} <= written


@pytest.mark.parametrize(("name", "width"), FLOORS)
def test_names_of_places_cover_nothing(name, width):
    plan, axes = floor(name, width)
    places = {station.name for station in plan.stations} | {"safe zone"}
    names = [text for text in axes.texts if text.get_text() in places]
    assert len(names) == len(places)
    written = {text.get_text(): outline(axes, text) for text in axes.texts}
    starts = [lane.footprint(lane.locations[lane.start]) for lane in plan.lanes]
    for place in places:
        area = written.pop(place)
        assert area.within(plan.boundary), place
        for other in (*(one.footprint for one in plan.obstacles), *starts, *written.values()):
            assert area.intersection(other).area < 0.05 * area.area, place


def outline(axes, text):
    """Return the box of a text on the floor (m)."""
    return box(*text.get_window_extent().transformed(axes.transData.inverted()).extents)


def test_names_of_stations_avoid_the_marks_of_violations():
    plan = floorplan.load("ariac2023")
    stations = {station.name for station in plan.stations}

    def names(marked):
        _, axes = floor_figure(plan, "double")
        draw_floor(axes, plan)
        draw_names(axes, plan, marked=marked)
        outlines = {text.get_text(): outline(axes, text) for text in axes.texts}
        return {name: outlines[name] for name in stations}

    marks = {name: area.centroid for name, area in names([]).items()}
    for name, area in names([(at.x, at.y) for at in marks.values()]).items():
        assert not area.contains(marks[name])


def test_many_people_have_thin_lines():
    few, many = (
        sim.run(sim.Trial.parse(CREW.replace("15", "1").replace("9", count)))
        for count in ("12", "13")
    )
    for name in ("trails", "space_time"):
        widths = [
            max(line.get_linewidth() for line in axes.lines if "crew" in line.get_label())
            for axes in (getattr(one.plot, name)().axes[0] for one in (few, many))
        ]
        assert widths[1] < widths[0]


def test_a_floor_names_every_obstacle_and_location():
    plan, axes = floor("ariac2023", "double")
    written = {text.get_text().replace("\n", "_") for text in axes.texts}
    assert {obstacle.name for obstacle in plan.obstacles} <= written
    assert {name for lane in plan.lanes for name in lane.locations} - written <= {"kitting"}


def test_runs_without_a_pair_say_so(run):
    alone = sim.run(sim.Trial(floorplan.load("warehouse"), duration=1.0))
    with pytest.raises(ValueError, match="a separation needs a person and a machine"):
        alone.plot.separation()
    with pytest.raises(ValueError, match=r"no person is called 'eve' .there are: ada, ben."):
        run.plot.separation("eve")
    with pytest.raises(ValueError, match="no machine is called 'ada'"):
        run.plot.separation("ada", "ada")
    with pytest.raises(ValueError, match="single or double column wide, not 'triple'"):
        run.plot.trails(width="triple")
    alone.plot.space_time().savefig(io.BytesIO(), format="svg")


def test_settings_of_matplotlib_stay_and_have_no_effect(run, tmp_path):
    plots.save(run.plot.separation(), tmp_path / "plain.svg")
    with matplotlib.rc_context({"font.size": 20, "lines.linewidth": 9, "svg.fonttype": "path"}):
        plots.save(run.plot.separation(), tmp_path / "own.svg")
        assert matplotlib.rcParams["font.size"] == 20
    assert (tmp_path / "own.svg").read_bytes() == (tmp_path / "plain.svg").read_bytes()


@pytest.mark.slow
def test_the_same_picture_has_the_same_bytes_in_every_process(tmp_path):
    code = """
import sys
import sim
from sim import plots

run = sim.run(sim.Trial.load("scene_antagonistic"))
for ending in plots.FORMATS:
    plots.save(run.plot.separation(width="single"), sys.argv[1] + ending)
"""
    for seed, clock in (("1", "0"), ("2", "1000000000")):
        environment = {**os.environ, "PYTHONHASHSEED": seed, "SOURCE_DATE_EPOCH": clock}
        subprocess.run(
            [sys.executable, "-c", code, str(tmp_path / seed)], env=environment, check=True
        )
    for ending in plots.FORMATS:
        assert (tmp_path / f"1{ending}").read_bytes() == (tmp_path / f"2{ending}").read_bytes()


def test_vector_pictures_have_real_text_and_no_date(run, tmp_path):
    plots.save(run.plot.separation(), tmp_path / "s.svg")
    svg = (tmp_path / "s.svg").read_text()
    written = [re.sub(r"<[^>]*>", "", text) for text in re.findall(r"<text.*?</text>", svg, re.S)]
    assert {"time (s)", "distance (m)", "required distance"} <= {text.strip() for text in written}
    assert "dc:date" not in svg
    plots.save(run.plot.separation(), tmp_path / "s.pdf")
    assert b"/CreationDate" not in (tmp_path / "s.pdf").read_bytes()


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("plots") / "run"
    record(sim.Trial.parse(TRIAL), folder)
    return folder


@pytest.mark.parametrize(
    "words",
    [
        ("floorplan", "FOLDER"),
        ("floorplan", EXAMPLES / "own_floor.trial.yaml"),
        ("path", "warehouse", 1.5, 1.5, 28, 10, "--radius", 0.25),
        ("trails", "FOLDER", "--from", 5, "--to", 30),
        ("spacetime", "FOLDER", "--width", "single"),
        ("separation", "FOLDER", "--person", "ben", "--machine", "agv1"),
        ("heatmap", "FOLDER", "FOLDER"),
        ("riskmap", "FOLDER", "FOLDER"),
        ("density", "FOLDER", "FOLDER", "--of", "speed"),
    ],
    ids=str,
)
def test_the_command_draws(words, folder, tmp_path, floorwalker):
    out = tmp_path / "picture.svg"
    done = floorwalker("plot", *(folder if w == "FOLDER" else w for w in words), "--out", out)
    assert (done.returncode, done.stdout, done.stderr) == (0, f"{out}\n", "")
    assert out.read_text().startswith("<?xml")


def test_the_note_of_a_picture_is_printed(folder, tmp_path, floorwalker):
    """Violations under the rules of ARIAC end at once by a teleport, so they have no duration."""
    out = tmp_path / "picture.svg"
    done = floorwalker("plot", "riskmap", folder, "--of", "time", "--out", out)
    assert (done.returncode, done.stdout) == (0, f"{out}\n")
    assert "ended at once" in done.stderr and done.stderr.strip() in out.read_text()


@pytest.mark.parametrize(
    ("words", "why"),
    [
        (("trails", "nowhere", "--out", "a.svg"), "no such file, nor a built-in trial"),
        (("trails", "ariac2023", "--out", "a.jpeg"), "ends in one of .png, .svg, .pdf"),
        (("trails", "ariac2023", "--out", "no/such/a.svg"), "there is no folder no/such"),
        (
            ("separation", "ariac2023", "--machine", "robot", "--out", "a.svg"),
            "no machine is called",
        ),
        (("path", "ariac2023", -9, 0, 99, 99, "--out", "a.svg"), "the goal (99, 99) is"),
    ],
)
def test_bad_input_is_one_sentence(words, why, tmp_path, floorwalker):
    done = floorwalker("plot", *words, cwd=tmp_path)
    assert (done.returncode, done.stdout) == (1, "")
    assert why in done.stderr and done.stderr.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def test_an_interrupted_run_is_drawn(folder, tmp_path, floorwalker):
    broken = shutil.copytree(folder, tmp_path / "broken")
    for name in ("summary.json", "violations.jsonl"):
        (broken / name).unlink()
    motions = broken / "motions.jsonl"
    motions.write_bytes(motions.read_bytes()[:-4000])
    for kind in ("trails", "separation"):
        out = tmp_path / f"{kind}.svg"
        done = floorwalker("plot", kind, broken, "--out", out)
        assert (done.returncode, done.stdout, done.stderr) == (0, f"{out}\n", "")


def test_without_matplotlib_trials_run_and_pictures_name_the_remedy(folder, tmp_path):
    code = """
import sys
import sim
from sim.cli import main

run = sim.load_run(sys.argv[1])
assert "matplotlib" not in sys.modules and "sim.views.plots" not in sys.modules
sys.modules["matplotlib"] = None
try:
    run.plot
except ImportError:
    sys.argv = ["floorwalker", "plot", "trails", *sys.argv[1:]]
    main()
"""
    command = [sys.executable, "-c", code, str(folder), "--out", str(tmp_path / "a.svg")]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 1
    assert "pip install 'floorwalker[plot]'" in done.stderr
    assert done.stderr.count("\n") == 1


def test_standing_people_are_drawn():
    plan = floorplan.parse("{boundary: [[0, 0], [10, 0], [10, 4], [0, 4]]}")
    scene = Scene(
        trial="standing",
        seed=0,
        floorplan=plan,
        rules=sim.PAPER,
        people=(Figure("ada", personality="", radius=0.4, height=1.7),),
        starts={"ada": (1, 2, 0)},
    )
    started = ({"t": 1.0, "kind": "human_started", "person": "ada"},)
    run = recorded(scene, 5.0, started, {"ada": standing((1.0, 2.0))})
    for figure in (run.plot.trails(), run.plot.space_time(), run.plot.heat_map()):
        figure.savefig(io.BytesIO(), format="svg")
    [line] = [one for one in run.plot.trails().axes[0].lines if one.get_label() == "ada"]
    assert {*zip(*line.get_data(), strict=True)} == {(1.0, 2.0)}
    seconds = run.plot.heat_map().axes[0].images[0].get_array()
    assert seconds.compressed() == pytest.approx(4.0)
    area = seconds.count() * (10.0 / seconds.shape[1]) ** 2
    assert area == pytest.approx(math.pi * 0.4**2, rel=0.1)
