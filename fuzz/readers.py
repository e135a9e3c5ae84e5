"""Everything that reads a file, as functions of bytes that end well or with an error for the user.

A crash is any other exception. What a reader accepts is not looked at.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import bdi
import floorplan
import sim

TOLD = (floorplan.InputError, bdi.ProgramError, sim.ControllerError)
"""What a user is told: one message that names the file."""

FLOOR = b"""boundary: [[0, 0], [9, 0], [9, 9], [0, 9]]
obstacles:
  table: {x: [3, 5], y: [3, 5], z: [0, 1]}
  post: {center: [7, 7], radius: 0.2, z: [0, 3]}
stations: {a: [1, 1], b: [8, 8]}
safe_zone: {at: [1, 8], heading: 0.0}
"""
TRIAL = b"""floorplan: ariac2023
duration: 20.0
seed: 3
rules: paper
people:
  - {name: ada, personality: helpful, start: {time: 1.0}, at: [-10, 0], beliefs: ["calm"]}
gantry:
  controller: oblivious
  at: [-5.0, 2.5, 0.0]
  jobs: [{pick: bin2, place: agv1, part: purple pump}, {move: [-3, 0, 0]}, {wait: 2}]
agvs: {agv1: [{time: 3.0, to: assembly_front}]}
expect: {penalties: 0, minimum_separation: ">= 1.0"}
"""
WKT = b"POLYGON ((0 0, 9 0, 9 9, 0 9, 0 0), (3 3, 5 3, 5 5, 3 5, 3 3))"
ROS_MAP = b"""image: map.pgm
resolution: 0.5
origin: [-1.0, -1.0, 0.1]
negate: 0
occupied_thresh: 0.65
free_thresh: 0.2
"""
IMAGE = b"P2\n6 6\n255\n" + b"0 0 0 0 0 0\n" + b"0 254 254 254 254 0\n" * 4 + b"0 0 0 0 0 0\n"
DXF = b"""0\nSECTION\n2\nENTITIES\n0\nLWPOLYLINE\n8\nboundary\n90\n4\n70\n1
10\n0.0\n20\n0.0\n10\n9.0\n20\n0.0\n10\n9.0\n20\n9.0\n10\n0.0\n20\n9.0\n0\nENDSEC\n0\nEOF\n"""
PROGRAM = b"""// A program with some of everything.
at(home)[source(self)]. far(X) :- dist(X, D) & D > 2 & not near(X).
!patrol(1).
@p1[atomic] +!patrol(N) : N < 10 & far(_) <- ?at(P); .concat("a", P, S); !patrol(N+1).
+!patrol(N) <- if (N > 3) { -+at(away) } else { move(1.5, -2, [a, b|T]) }; .wait(1000).
-!patrol(N)[error(E)] <- .print("failed ", E); .findall(X, at(X), L); for (.member(M, L)) { x(M) }.
+human_start : true <- .drop_all_desires; !!patrol(0).
"""


def trial(data: bytes) -> None:
    """A trial file."""
    _in_file("t.trial.yaml", data, sim.Trial.load)


def yaml_floor(data: bytes) -> None:
    """A floorplan in YAML."""
    _in_file("f.yaml", data, floorplan.load)


def wkt(data: bytes) -> None:
    """A floor in WKT."""
    _in_file("f.wkt", data, floorplan.load)


def dxf(data: bytes) -> None:
    """A drawing."""
    _in_file("f.dxf", data, floorplan.load)


def ros_map(data: bytes) -> None:
    """The YAML of a ROS map."""
    _in_file("f.yaml", data, floorplan.load, ("map.pgm", IMAGE))


def ros_image(data: bytes) -> None:
    """The image of a ROS map."""
    _in_file(
        "map.pgm", data, lambda path: floorplan.load(path.parent / "f.yaml"), ("f.yaml", ROS_MAP)
    )


def program(data: bytes) -> None:
    """A program in AgentSpeak, read and loaded into an agent."""

    def read(path: Path) -> None:
        bdi.Agent(bdi.parse_file(path), act=lambda term: True, print=lambda text: None)

    _in_file("p.asl", data, read)


READERS: dict[str, tuple[Callable[[bytes], None], bytes]] = {
    "trial": (trial, TRIAL),
    "floorplan": (yaml_floor, FLOOR),
    "wkt": (wkt, WKT),
    "dxf": (dxf, DXF),
    "ros_map": (ros_map, ROS_MAP),
    "ros_image": (ros_image, IMAGE),
    "program": (program, PROGRAM),
}
"""By name: the reader, and a file that it accepts."""


def recording_of(folder: Path) -> dict[str, bytes]:
    """The files of a short recording, made in `folder`."""
    recording = sim.Recording(folder)
    text = "floorplan: ariac2023\nduration: 3.0\npeople: [{name: ada}]\n"
    recording.finish(sim.run(sim.Trial.parse(text), recording))
    names = ("scene.json", "summary.json", "events.jsonl", "motions.jsonl", "violations.jsonl")
    return {name: (folder / name).read_bytes() for name in names}


def recording(files: dict[str, bytes], name: str, data: bytes) -> None:
    """A recording in which the file `name` holds `data`."""
    with tempfile.TemporaryDirectory() as folder:
        for other, content in files.items():
            (Path(folder) / other).write_bytes(data if other == name else content)
        with suppress(TOLD):
            sim.load_run(folder)


def _in_file(
    name: str,
    data: bytes,
    read: Callable[[Path], object],
    *others: tuple[str, bytes],
) -> None:
    with tempfile.TemporaryDirectory() as folder:
        for other, content in ((name, data), *others):
            (Path(folder) / other).write_bytes(content)
        with suppress(TOLD):
            read(Path(folder) / name)
