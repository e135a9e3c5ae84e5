"""Floorplan files: all problems are reported at once, with their places."""

import subprocess
import sys

import pytest
from hypothesis import given, strategies as st
from shapely.geometry import Point

import floorplan

ROOM = """\
boundary: [[0, 0], [10, 0], [10, 8], [0, 8]]
obstacles:
  table: {x: [4, 6], y: [3, 5], z: [0, 1]}
stations:
  door: [1, 1]
"""


def problems(text):
    with pytest.raises(floorplan.FloorplanError) as caught:
        floorplan.parse(text, file="room.yaml")
    return [str(problem) for problem in caught.value.problems]


def test_a_small_room_is_enough():
    plan = floorplan.parse(ROOM, file="room.yaml")
    assert plan.name == "room"
    assert plan.obstacles[0].footprint.area == 4.0
    assert plan.patrolled == plan.stations == (floorplan.Station("door", (1.0, 1.0)),)
    assert floorplan.parse(ROOM + "patrol: []\n").patrolled == ()


@pytest.mark.parametrize(
    ("entry", "area"),
    [
        ("{x: [4, 6], y: [3, 5], z: [0, 1]}", 4.0),
        ("{center: [5, 4], size: [2, 3], z: [0, 1]}", 6.0),
        ("{polygon: [[4, 3], [6, 3], [5, 5]], z: [0, 1]}", 2.0),
    ],
)
def test_a_footprint_has_several_forms(entry, area):
    plan = floorplan.parse(ROOM.replace("{x: [4, 6], y: [3, 5], z: [0, 1]}", entry))
    assert plan.obstacles[0].footprint.area == pytest.approx(area)


def test_a_round_footprint_covers_its_disc():
    text = ROOM.replace(
        "{x: [4, 6], y: [3, 5], z: [0, 1]}", "{center: [5, 4], radius: 1, z: [0, 1]}"
    )
    footprint = floorplan.parse(text).obstacles[0].footprint
    assert footprint.exterior.distance(Point(5, 4)) == pytest.approx(1.0)
    assert footprint.area < 3.1416 * 1.01


def test_all_problems_are_reported_at_once_with_their_lines():
    text = """\
boundary: [[0, 0], [10, 0], [10, 8], [0, 8]]
obstacles:
  a: {x: [0, 1], z: [0, .nan]}
  b: {x: [0, 1], y: [1, 0], z: [0, 1]}
  c: {x: ['1m', 1], y: [0, 1], z: [0, 1]}
stations: {s: [5, 5, 6]}
human: {radius: -1}
foo: 1
"""
    assert problems(text) == [
        "line 3, obstacles.a.z[1]: expected a finite number, found nan",
        "line 4, obstacles.b.y: must be [low, high] with low < high, found [1.0, 0.0]",
        "line 5, obstacles.c.x[0]: expected a number, found '1m'",
        "line 6, stations.s: expected a list of 2, found [5, 5, 6]",
        "line 7, human.radius: expected more than 0, found -1",
        "line 8, foo: unknown key; there are: agvs, base, boundary, doors, gantry, gates, holes,"
        " human, layers, leave_out, move, name, obstacles, origin, patrol, remove, rename,"
        " rotation, safe_zone, snap, source, stations, title, units, zones",
    ]


MACHINES = """\
agvs:
  size: [1.0, 0.6]
  height: 1.2
  max_speed: 2.0
  max_acceleration: 2.0
  limits: [0.0, 5.0]
  locations: {home: 0.0, away: 5.0}
  start: home
  lanes:
    agv1: {origin: [2, 2], heading: 0.0, serves: {door: home}}
gantry:
  x: {range: [1, 8], max_speed: 1.0, max_acceleration: 0.5}
  y: {range: [1, 8], max_speed: 1.0, max_acceleration: 0.5}
  start: [4, 4, 0]
  torso: {size: [1.05, 0.95], z: [1.24, 2.71]}
  arm: {mount: [0.51, 0.0], reach: 0.9, bottom: 1.1}
  rail_height: 2.9
  tray_height: 0.8
safe_zone: {at: [1, 7], heading: 0.0}
"""


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("[10, 8], [0, 8]]", "[0, 8], [10, 8]]"), "is not a simple polygon: edges cross at [5 4]"),
        (("[10, 0], [10, 8], [0, 8]]", "[5, 0], [10, 0]]"), "boundary"),
        (
            ("x: [4, 6], y: [3, 5]", "polygon: [[1, 1], [2, 2], [2, 1], [1, 2]]"),
            "obstacles.table: ",
        ),
        (("door: [1, 1]", "door: [5, 4]"), "is inside obstacle 'table'"),
        (("door: [1, 1]", "door: [3.9, 4]"), "a person of radius 0.3 m does not fit"),
        (("door: [1, 1]", "door: [0.1, 4]"), "is 0.100 m from the boundary"),
        (("  door: [1, 1]", "  door: [1, 1]\npatrol: [gate]"), "no station is called 'gate'"),
        (("  door: [1, 1]", "  door: [1, 1]\n  door: [2, 2]"), "this key stands twice"),
        (("y: [3, 5], z", "y: [3, 5], radius: 1, z"), "give the footprint as"),
        (("boundary", "boundry"), "boundary: is missing"),
        (("away: 5.0", "away: 6.0"), "agvs.locations.away: 6 is outside the lane's limits 0 … 5"),
        (("start: home", "start: hmoe"), "starts at 'hmoe', which is no location (there are: home"),
        (("{door: home}", "{door: hmoe}"), "agvs.lanes.agv1.serves.door: 'hmoe' is no location"),
        (("start: [4, 4, 0]", "start: [4, 9, 0]"), "gantry.start: "),
        (("at: [1, 7]", "at: [5, 4]"), "safe_zone.at: (5, 4) is inside obstacle 'table'"),
    ],
)
def test_an_unsound_floor_is_reported_with_its_place(change, message):
    text = ROOM + MACHINES
    assert floorplan.parse(text).gantry.start == (4, 4, 0)
    assert message in "\n".join(problems(text.replace(*change)))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("boundary: [[0,0],[10,10],\na: : b", "line 2: is not YAML"),
        ("", "expected keys with values, found nothing"),
        ("[1, 2]", "expected keys with values, found a list"),
        ("a: &x [*x]", "contains it"),
        ("a: !!python/object:os.system {}", "is not YAML"),
    ],
)
def test_text_that_is_no_floorplan_is_rejected(text, message):
    assert any(message in problem for problem in problems(text))


def test_aliases_that_multiply_are_rejected():
    bomb = "a0: &a0 [1]\n" + "".join(
        f"a{k}: &a{k} [{', '.join([f'*a{k - 1}'] * 9)}]\n" for k in range(1, 12)
    )
    assert any("more than 300,000 values" in problem for problem in problems(bomb))


@pytest.mark.parametrize(
    ("source", "message"),
    [
        ("ariac", "did you mean 'ariac2023'?"),
        ("nowhere.yaml", "there is no such file"),
        ("nonsense", "there are: ariac2023"),
    ],
)
def test_a_missing_floorplan_is_reported(source, message):
    with pytest.raises(floorplan.FloorplanError, match=message.replace("?", r"\?")):
        floorplan.load(source)


def test_a_binary_file_is_rejected(tmp_path):
    path = tmp_path / "room.yaml"
    path.write_bytes(b"boundary: \xff\xfe")
    with pytest.raises(floorplan.FloorplanError, match="is not UTF-8 text"):
        floorplan.load(path)


@given(st.text(max_size=200))
def test_any_text_is_a_floorplan_or_an_error(text):
    try:
        floorplan.parse(text)
    except floorplan.FloorplanError as error:
        assert error.problems


KEYS = st.sampled_from(
    ["boundary", "obstacles", "stations", "patrol", "human", "agvs", "gantry", "x", "y", "z"]
)
VALUES = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(KEYS, inner, max_size=4),
    max_leaves=12,
)


@given(st.dictionaries(KEYS, VALUES, max_size=5))
def test_any_values_are_a_floorplan_or_an_error(values):
    import yaml

    try:
        floorplan.parse(yaml.safe_dump(values))
    except floorplan.FloorplanError as error:
        assert error.problems


def test_floorplan_imports_none_of_the_other_packages():
    code = "import sys, floorplan; print({'navigation', 'bdi', 'sim'} & set(sys.modules))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "set()"


@pytest.mark.parametrize("text", ["-.5", "+.5", "-.5e+0", "-0.5"])
def test_numbers_need_no_digit_before_the_point(text):
    plan = floorplan.parse(f"boundary: [[-1, -1], [9, -1], [9, 9]]\nsafe_zone: {{at: [4, {text}]}}")
    assert abs(plan.safe_zone.position[1]) == 0.5


@pytest.mark.parametrize("text", ["\tat: 1\n", "stations:\n\tdock: [1, 1]\n", "patrol:\n  - \ta\n"])
def test_a_tab_is_called_a_tab(text):
    if "patrol" in text:
        text += "\t- b\n"
    with pytest.raises(floorplan.FloorplanError, match="a tab"):
        floorplan.parse(text)
