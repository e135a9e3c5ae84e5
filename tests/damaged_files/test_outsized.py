"""Every reader rejects infinite, undefined and absurd numbers on entry."""

import json
import re
import shutil
import sqlite3
from contextlib import closing
from pathlib import Path

import pytest

import floorplan
import sim

from .readers import READERS

DIGITS = "9" * 400
YAML = {"nan": ".nan", "inf": "-.inf", "1e300": "1.0e+300", "digits": DIGITS}
JSON = {"nan": "NaN", "inf": "-Infinity", "1e300": "1e300", "digits": DIGITS}
TEXT = {"nan": "nan", "inf": "-inf", "1e300": "1e300", "digits": DIGITS}

GEOJSON = json.dumps(
    {
        "type": "FeatureCollection",
        "units": "m",
        "features": [
            {
                "type": "Feature",
                "properties": {"kind": "boundary"},
                "geometry": {
                    "type": "Polygon",
                    "coordinates": [[[0, 0], [9, 0], [9, 9], [0, 9], [0, 0]]],
                },
            },
            {
                "type": "Feature",
                "properties": {"kind": "obstacle", "name": "table", "top": 0.75},
                "geometry": {
                    "type": "Polygon",
                    "coordinates": [[[3, 3], [5, 3], [5, 4], [3, 4], [3, 3]]],
                },
            },
            {
                "type": "Feature",
                "properties": {"kind": "station", "name": "a"},
                "geometry": {"type": "Point", "coordinates": [1, 2]},
            },
        ],
    }
)
CIRCLES = """0
SECTION
2
HEADER
9
$ACADVER
1
AC1015
0
ENDSEC
0
SECTION
2
ENTITIES
0
LWPOLYLINE
100
AcDbEntity
8
boundary
100
AcDbPolyline
90
4
70
1
10
0.0
20
0.0
10
9.0
20
0.0
10
9.0
20
9.0
10
0.0
20
9.0
0
CIRCLE
8
post
10
7.0
20
7.0
40
0.25
0
ARC
8
ring
10
3.0
20
3.0
40
0.75
50
15.0
51
375.0
0
LWPOLYLINE
100
AcDbEntity
8
drum
100
AcDbPolyline
39
1.5
90
2
70
1
10
5.0
20
5.0
42
1.0
10
6.0
20
5.0
42
1.0
0
ENDSEC
0
EOF
"""
TRACK = "t,name,x,y,rotation\n0,eve,2.5,5,0\n1,eve,3.5,5.25,0.5\n"
TRAJECTORY = "# framerate: 16.0\n# id frame x/m y/m\n1 0 2.5 5\n1 16 3.5 5.25\n"
HALL = """
floorplan:
  boundary: [[0, 0], [20, 0], [20, 10], [0, 10]]
  stations: {west: [1, 5], east: [19, 5]}
  safe_zone: {at: [1, 1]}
"""
COMMANDS = "commands: [{time: 1.5, send: x, to: [2.5, 3.5]}]"


def recorded(path):
    text = f"{HALL}\npeople: [{{name: eve, recorded: {{file: {path.name}, body: '*'}}}}]"
    body = {".csv": "eve", ".txt": "'1'", ".sqlite": "eve"}[path.suffix]
    sim.Trial.parse(text.replace("'*'", body), folder=path.parent)


def commands(path):
    text = f"{HALL}people: [{{name: x}}]\ncommands: {path.name}"
    sim.Trial.parse(text, folder=path.parent)


OWN = {
    "floor.geojson": (GEOJSON, floorplan.load),
    "circles.dxf": (CIRCLES, floorplan.load),
    "track.csv": (TRACK, recorded),
    "track.txt": (TRAJECTORY, recorded),
    "commands.yaml": (COMMANDS, commands),
}
"""Samples and readers of formats that have no file in the folder of samples."""

SPOTS = [
    ("work.trial.yaml", r"duration: (20\.0)", YAML),
    ("work.trial.yaml", r"time: (1\.0)", YAML),
    ("work.trial.yaml", r"at: \[(-10), 0\]", YAML),
    ("work.trial.yaml", r"max_speed: (1\.2)", YAML),
    ("work.trial.yaml", r"radius: (0\.25)", YAML),
    ("work.trial.yaml", r"wait: (2)", YAML),
    ("work.trial.yaml", r"agv1: \[\{time: (3\.0)", YAML),
    ("expectations.yaml", r"minimum_separation: \">= (3\.5)", TEXT),
    ("expectations.yaml", r"walked: \"(100)", TEXT),
    ("expectations.yaml", r"metres: (3\.0)", YAML),
    ("expectations.yaml", r"within: (20)", YAML),
    ("everything.ariac.yaml", r"time_limit: (400)", YAML),
    ("everything.ariac.yaml", r"slots: \[2, 5\], rotation: (pi/2)", YAML),
    ("laws.trial.yaml", r"intrusion: (0\.8)", YAML),
    ("laws.trial.yaml", r"cap: (5\.0)", YAML),
    ("ours.rules.yaml", r"fixed: (2\.1)", YAML),
    ("ours.rules.yaml", r"grace: (1\.0)", YAML),
    ("many.study.yaml", r"max_speed: \[(0\.8)", YAML),
    ("many.study.yaml", r"uniform: \[0, (30)\]", YAML),
    ("many.study.yaml", r"normal: \[(3\.0)", YAML),
    ("floor.yaml", r"boundary: \[\[(0), 0\]", YAML),
    ("floor.yaml", r"stations: \{a: \[(1)", YAML),
    ("floor.yaml", r"z: \[0, (3)\]", YAML),
    ("floor.yaml", r"reach: (0\.9)", YAML),
    ("floor.geojson", r"\[\[\[(0), 0\]", JSON),
    ("floor.geojson", r"\"coordinates\": \[(1), 2", JSON),
    ("floor.geojson", r"\"top\": (0\.75)", JSON),
    ("holes.wkt", r"(5) 3,", TEXT),
    ("parts.wkt", r"\(\((-?[\d.]+) ", TEXT),
    ("circles.dxf", r"10\n(0\.0)", TEXT),
    ("circles.dxf", r"10\n(7\.0)", TEXT),
    ("circles.dxf", r"40\n(0\.25)", TEXT),
    ("circles.dxf", r"40\n(0\.75)", TEXT),
    ("circles.dxf", r"42\n(1\.0)", TEXT),
    ("circles.dxf", r"39\n(1\.5)", TEXT),
    ("rooms.map", r"width (10)", TEXT),
    ("rooms.map.scen", r"10\t6\t(0)", TEXT),
    ("rooms.map.scen", r"(9\.00000000)", TEXT),
    ("questions.csv", r"\n(1),1", TEXT),
    ("map.yaml", r"resolution: (0\.5)", YAML),
    ("map.yaml", r"origin: \[(-1\.0)", YAML),
    ("map.pgm", r"\n(255)\n", TEXT),
    ("map.pgm", r"\n0 (254)", TEXT),
    ("track.csv", r"\n(1),eve", TEXT),
    ("track.csv", r"(3\.5)", TEXT),
    ("track.csv", r"5\.25,(0\.5)", TEXT),
    ("track.txt", r"framerate: (16\.0)", {"digits": DIGITS, "none": "0", "dots": "1.2.3"}),
    ("track.txt", r"(3\.5)", TEXT),
    ("commands.yaml", r"time: (1\.5)", YAML),
    ("commands.yaml", r"to: \[(2\.5)", YAML),
    ("percepts.jsonl", r"\"t\": (1\.5)", JSON),
    ("run/scene.json", r"\"starts\":\{\"ada\":\[(-?[\d.]+)", JSON),
    ("run/scene.json", r"\"boundary\":\{.*?\[\[\[(-?[\d.]+)", JSON),
    ("run/scene.json", r"\"height\":([\d.]+)", JSON),
    ("run/summary.json", r"\"duration\": ([\d.]+)", JSON),
    ("run/events.jsonl", r"\"t\": ([\d.]+)", JSON),
    ("run/motions.jsonl", r"\"start\": ([\d.]+)", JSON),
    ("run/motions.jsonl", r"\"pieces\": \[\[([\d.]+)", JSON),
    ("run/motions.jsonl", r"\"pieces\": \[\[[\d.]+, [\d.]+, \[(-?[\d.]+)", JSON),
    ("run/thoughts.jsonl", r"\"t\": ([\d.]+)", JSON),
    ("run/violations.jsonl", r"\"intervals\": \[\[([\d.]+)", JSON),
    ("results/results.jsonl", r"\"max_speed\": (0\.\d+)", {"inf": "Infinity", "1e300": "1e300"}),
]


@pytest.fixture(scope="module")
def folder(folder):
    for name, (text, _) in OWN.items():
        (folder / name).write_text(text)
    return folder


@pytest.mark.parametrize("name", OWN)
def test_the_sample_is_accepted(folder, name):
    OWN[name][1](folder / name)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(
    ("name", "spot", "written"),
    [
        pytest.param(name, spot, form, id=f"{name}-{spot}-{kind}")
        for name, spot, forms in SPOTS
        for kind, form in forms.items()
    ],
)
def test_an_outsized_number_is_rejected(folder, name, spot, written):
    path = folder / name
    whole = path.read_bytes()
    read = OWN[name][1] if name in OWN else READERS[name]
    text = whole.decode("utf-8")
    match = re.search(spot, text, re.DOTALL)
    assert match is not None, text[:2000]
    path.write_text(text[: match.start(1)] + written + text[match.end(1) :], encoding="utf-8")
    try:
        with pytest.raises(floorplan.UserError) as refused:
            read(path)
    finally:
        path.write_bytes(whole)
    assert 0 < len(str(refused.value)) < 20_000


@pytest.fixture(scope="module")
def exported(tmp_path_factory):
    path = tmp_path_factory.mktemp("jupedsim") / "track.sqlite"
    trial = sim.Trial.parse(f"{HALL}duration: 2\npeople: [{{name: eve}}]")
    sim.export(sim.run(trial), path)
    recorded(path)
    return path


@pytest.mark.parametrize("value", ["nan", "inf", "1e300"])
@pytest.mark.parametrize("change", ["trajectory_data SET pos_x = {}", "metadata SET value = {}"])
def test_an_outsized_number_in_a_recording_of_jupedsim_is_rejected(
    exported, tmp_path, value, change
):
    path = Path(shutil.copy(exported, tmp_path))
    stored = {"nan": "'nan'", "inf": "9e999", "1e300": "1e300"}[value]
    with closing(sqlite3.connect(path)) as database, database:
        key = " WHERE key = 'fps'" if change.startswith("metadata") else ""
        database.execute(f"UPDATE {change.format(stored)}{key}")
    with pytest.raises(sim.TrialError):
        recorded(path)


def test_a_mistake_in_a_file_of_commands_names_that_file(folder):
    path = folder / "late.yaml"
    path.write_text("commands:\n  - {time: 1, send: nobody, to: west}\n")
    words = r"late\.yaml: line 2, commands\[0\]\.send: no person is called 'nobody'"
    with pytest.raises(sim.TrialError, match=words):
        commands(path)
    with pytest.raises(sim.TrialError, match=words):
        sim.Trial.parse(f"{HALL}people: [{{name: x}}]\ncommands: late.yaml", folder=folder)
