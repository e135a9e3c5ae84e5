"""Everything that reads a file or a foreign text, as functions of bytes.

Each ends well or with an error for the user. A crash is any other exception. What is accepted is
used a little, too: a file that is read and can't be worked with afterwards is no better.
"""

from __future__ import annotations

import io
import shutil
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path

import bdi
import floorplan
import sim
from sim.commands.percept_script import read_percepts
from sim.views.replay import recordings_in

from . import bridges, recordings
from .mutations import Form
from .told import told

SAMPLES = Path(__file__).parent / "samples"


@dataclass(frozen=True)
class Reader:
    """Something that reads: `read(data)` does, as if it stood in a file.

    `samples()` are files that it accepts; `form` is what they are made of.
    """

    read: Callable[[bytes], None]
    samples: Callable[[], tuple[bytes, ...]]
    form: Form


def _trial(path: Path) -> None:
    trial = sim.Trial.load(path)
    trial.to_yaml(path.parent)


def _short_trial(path: Path) -> None:
    trial = sim.Trial.load(path)
    try:
        simulation = sim.Simulation(trial)
        simulation.advance(min(trial.duration, 3.0))
    except sim.StandstillError:
        return  # that shows only as it runs
    except Exception as why:
        raise AssertionError(f"what was checked is refused as it begins: {why}") from why
    recordings.use(simulation.finish())


def _program(path: Path) -> None:
    program = bdi.parse_file(path)
    bdi.parse(str(program), folder=path.parent)
    bdi.Agent(program, act=lambda action: True, print=lambda line: None)


def _running_program(path: Path) -> None:
    agent = bdi.Agent(
        bdi.parse_file(path),
        act=lambda action: bool(str(action)),
        print=lambda line: None,
        on_event=lambda entry: None,
        society=bdi.Society(),
        max_cycles=2000,
        max_goals=3000,
    )
    agent.advance(0.0)
    agent.add_percept("human_start")
    agent.advance(5.0)
    for intention in agent.intentions:
        str(intention)


def _literal(path: Path) -> None:
    text = path.read_bytes().decode("utf-8", "replace")
    for parse in (bdi.parse_literal, bdi.parse_term):
        with told():
            bdi.parse(f"{parse(text)}.") if parse is bdi.parse_literal else str(parse(text))


def _study(path: Path) -> None:
    study = sim.Study.load(path)
    if len(study) <= 1000:
        study.row(len(study) - 1).trial.to_yaml(path.parent)


def _page(path: Path) -> None:
    recordings_in(path.read_text(encoding="utf-8", errors="replace"))


def _include(path: Path) -> None:
    bdi.parse_file(path.parent / "everything.asl")


def _map_image(path: Path) -> None:
    floorplan.load(path.parent / "map.yaml")


def _file(
    name: str,
    read: Callable[[Path], object],
    form: Form,
    *samples: str,
    others: tuple[type[Exception], ...] = (),
) -> Reader:
    """The reader of a file called `name` that lies beside all the samples."""
    contents = tuple((SAMPLES / sample).read_bytes() for sample in samples)
    return Reader(partial(_in_file, name, read, others), lambda: contents, form)


def _in_file(
    name: str, read: Callable[[Path], object], others: tuple[type[Exception], ...], data: bytes
) -> None:
    path = Path(_folder().name) / name
    before = path.read_bytes() if path.exists() else None
    path.write_bytes(data)
    try:
        with told(*others):
            read(path)
    finally:
        if before is None:
            path.unlink()
        else:
            path.write_bytes(before)


@cache
def _folder() -> tempfile.TemporaryDirectory[str]:
    """A folder with all the samples in it, there until the process ends."""
    folder = tempfile.TemporaryDirectory(prefix="fuzz-")
    shutil.copytree(SAMPLES, folder.name, dirs_exist_ok=True)
    return folder


def _png() -> tuple[bytes, ...]:
    from PIL import Image

    picture = io.BytesIO()
    with Image.open(SAMPLES / "map.pgm") as image:
        image.save(picture, "PNG")
    return (picture.getvalue(),)


def _recording(name: str) -> Reader:
    folder = recordings.RunFolder(name)
    return Reader(folder, lambda: (folder.sample(),), "lines" if name[-1] == "l" else "json")


def _results(name: str) -> Reader:
    folder = recordings.ResultsFolder(name, SAMPLES / "one.study.yaml")
    return Reader(folder, lambda: (folder.sample(),), "json" if name[-1] == "n" else "words")


READERS: dict[str, Reader] = {
    "trial": _file("t.trial.yaml", _trial, "yaml", "work.trial.yaml", "laws.trial.yaml"),
    "expectations": _file("t.trial.yaml", _trial, "yaml", "expectations.trial.yaml"),
    "run": _file("t.trial.yaml", _short_trial, "yaml", "short.trial.yaml", "laws.trial.yaml"),
    "ariac": _file("t.yaml", _trial, "yaml", "everything.ariac.yaml"),
    "rules": _file("r.yaml", sim.load_rules, "yaml", "ours.rules.yaml"),
    "study": _file("s.study.yaml", _study, "yaml", "many.study.yaml"),
    "floorplan": _file("f.yaml", floorplan.load, "yaml", "floor.yaml"),
    "wkt": _file("f.wkt", floorplan.load, "words", "holes.wkt", "parts.wkt"),
    "dxf": _file("f.dxf", floorplan.load, "words", "floor.dxf"),
    "ros_map": _file("f.yaml", floorplan.load, "yaml", "map.yaml"),
    "pgm": _file("map.pgm", _map_image, "words", "map.pgm"),
    "png": Reader(partial(_in_file, "map.pgm", _map_image, ()), _png, "bytes"),
    "program": _file("p.asl", _program, "words", "everything.asl", "running.asl"),
    "running_program": _file("p.asl", _running_program, "words", "running.asl"),
    "include": _file("other.asl", _include, "words", "other.asl"),
    "literal": _file("l.txt", _literal, "words", "literals.txt"),
    "percepts": _file("p.jsonl", read_percepts, "lines", "percepts.jsonl", others=(ValueError,)),
    **{name: _recording(name) for name in recordings.RUN_FILES},
    "page": Reader(
        partial(_in_file, "p.html", _page, (ValueError,)), lambda: (recordings.page(),), "words"
    ),
    **{name: _results(name) for name in recordings.STUDY_FILES},
    "bridge_server": Reader(
        bridges.Server(), lambda: (bridges.messages(bridges.TO_SERVER),), "lines"
    ),
    "bridge_agent": Reader(bridges.Agent(), lambda: (bridges.messages(bridges.TO_AGENT),), "lines"),
}
"""By name."""
