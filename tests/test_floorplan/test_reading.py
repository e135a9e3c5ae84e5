"""Files of users: only regular files of a sensible size, and how images and drawings are read."""

import os
import re
import socket
import subprocess
import sys

import numpy as np
import pytest
import shapely
from hypothesis import example, given, settings, strategies as st

import bdi
import floorplan
import sim
from floorplan import InputError
from floorplan.files.reading import read_bytes, read_lines, read_text
from floorplan.formats.raster import trace
from sim.commands.agent import read_percepts

posix = pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="needs a POSIX system")

READERS = {
    "floor.yaml": floorplan.load,
    "floor.wkt": floorplan.load,
    "floor.dxf": floorplan.load,
    "trial.yaml": sim.Trial.load,
    "rules.yaml": sim.load_rules,
    "study.yaml": sim.Study.load,
    "percepts.jsonl": read_percepts,
    "person.asl": bdi.parse_file,
}


@posix
@pytest.mark.parametrize("name", READERS)
def test_only_regular_files_are_read(tmp_path, name):
    path = tmp_path / name
    os.mkfifo(path)
    others = [path]
    for kind in ("folder", "device"):
        others.append(tmp_path / kind / name)
        others[-1].parent.mkdir()
    others[1].mkdir()
    others[2].symlink_to("/dev/zero")
    for other in others:
        with pytest.raises(ValueError, match="regular file"):
            READERS[name](other)


@posix
def test_a_path_that_is_no_file_is_named(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # the path of a socket is short
    with socket.socket(socket.AF_UNIX) as door:
        door.bind("door")
        with pytest.raises(InputError, match="is a socket; give a regular file"):
            read_bytes(tmp_path / "door", InputError)


@posix
def test_the_image_of_a_map_is_a_regular_file(tmp_path):
    os.mkfifo(tmp_path / "map.pgm")
    (tmp_path / "map.yaml").write_text(
        "{image: map.pgm, resolution: 0.05, origin: [0, 0, 0], negate: 0,"
        " occupied_thresh: 0.65, free_thresh: 0.2}"
    )
    with pytest.raises(floorplan.FloorplanError, match=r"map\.pgm': is a named pipe"):
        floorplan.load(tmp_path / "map.yaml")


@posix
def test_a_recording_is_of_regular_files(tmp_path):
    trial = sim.Trial.parse("{floorplan: ariac2023, duration: 1.0}")
    recording = sim.Recording(tmp_path / "run")
    recording.finish(sim.run(trial, recording))
    for name in ("motions.jsonl", "events.jsonl", "summary.json", "scene.json"):
        path = tmp_path / "run" / name
        content = path.read_bytes()
        path.unlink()
        os.mkfifo(path)
        with pytest.raises(InputError):
            sim.load_run(tmp_path / "run")
        path.unlink()
        path.write_bytes(content)
    assert sim.load_run(tmp_path / "run").duration == 1.0


def test_a_file_is_read_up_to_its_limit(tmp_path):
    path = tmp_path / "text"
    path.write_bytes(b"a\r\nb\rc\n")
    assert read_text(path, InputError) == "a\nb\nc\n"
    assert read_bytes(path, InputError, 7) == b"a\r\nb\rc\n"
    with pytest.raises(InputError, match="is larger than the 0 MB"):
        read_bytes(path, InputError, 6)
    # A hole takes no room on the disk.
    os.truncate(path, 10**12)
    with pytest.raises(InputError, match="is larger than the 16 MB"):
        read_text(path, InputError)
    with pytest.raises(InputError, match="line 3: is longer than the 64 MB"):
        list(read_lines(path, InputError))


def test_a_byte_order_mark_is_no_part_of_a_text(tmp_path):
    (tmp_path / "questions.csv").write_bytes(b"\xef\xbb\xbfx0,y0\r\n")
    assert read_text(tmp_path / "questions.csv", InputError) == "x0,y0\n"


def test_lines_are_read_one_by_one_and_a_torn_one_can_be_omitted(tmp_path):
    path = tmp_path / "lines"
    path.write_bytes(b"one\n\ntwo\nthr\xc3")
    assert list(read_lines(path, InputError, torn=True)) == ["one", "", "two"]
    with pytest.raises(InputError, match=r"line 4: is not UTF-8 text \(byte 3\)"):
        list(read_lines(path, InputError))


@posix
def test_a_pipe_from_a_shell_is_read(tmp_path):
    command = [sys.executable, "-m", "sim.cli", "run", "/dev/stdin", "--out", str(tmp_path / "run")]
    text = "{floorplan: ariac2023, duration: 1.0}"
    subprocess.run(command, input=text, text=True, check=True, capture_output=True)
    assert sim.load_run(tmp_path / "run").duration == 1.0
    reading, writing = os.pipe()
    os.write(writing, b"!go. +!go.")
    os.close(writing)
    try:
        assert len(bdi.parse_file(f"/dev/fd/{reading}").plans) == 1
    finally:
        os.close(reading)


@settings(max_examples=2 * settings.default.max_examples)
@given(st.integers(0, 2**32), st.integers(1, 14), st.integers(1, 14), st.floats(0, 1))
@example(11, 13, 11, 0.625)
def test_outlines_contain_the_set_cells(seed, rows, columns, share):
    cells = np.random.default_rng(seed).random((rows, columns)) < share
    exact = trace(cells, 0.0)
    assert exact.is_valid
    y, x = np.mgrid[0:rows, 0:columns]
    assert (shapely.contains_xy(exact, x + 0.5, y + 0.5) == cells).all()
    simple = trace(cells, 0.45)
    assert simple.is_valid
    # Where set cells touch at a corner, outlines avoid the corner and come nearer to their centres.
    middles = shapely.points(x + 0.5, y + 0.5)
    sure = ~cells | (shapely.distance(exact.boundary, middles) > 0.45)
    assert (shapely.contains(simple, middles) == cells)[sure].all()
    if cells.any():
        # No point moved by more than the limit.
        assert exact.boundary.hausdorff_distance(simple.boundary) <= 0.45 + 1e-9


def test_nested_rooms_and_obstacles_in_them():
    rings = np.ones((39, 39), bool)
    for k in range(0, 20, 2):
        rings[k : 39 - k, k : 39 - k] = k // 2 % 2 == 0
    outlines = trace(rings, 0.0)
    assert outlines.is_valid
    assert outlines.area == rings.sum()
    assert sorted(len(piece.interiors) for piece in outlines.geoms) == [1] * 5


def test_cells_that_touch_at_a_corner_are_apart():
    pieces = trace(np.eye(4, dtype=bool), 0.0)
    assert len(pieces.geoms) == 4
    assert len(trace(~np.eye(4, dtype=bool), 0.0).geoms) == 2


@pytest.mark.parametrize("version", ["R12", "R2018"])
def test_texts_are_not_read_and_everything_else_keeps_its_handle(version, tmp_path):
    ezdxf = pytest.importorskip("ezdxf")
    from floorplan.formats.dxf import TOLD, open_drawing

    drawing = ezdxf.new(version)
    block = drawing.blocks.new("PRESS")
    for space in (drawing.modelspace(), block):
        space.add_line((0, 0), (1, 1))
        space.add_text("0").set_placement((1, 0))
        space.add_point((0, 0))
        space.add_linear_dim((0, 2), (0, 0), (5, 0)).render()
        space.add_circle((0, 0), 1)
    press = drawing.modelspace().add_blockref("PRESS", (1, 1))
    press.add_attrib("NAME", "EOF", (0, 0))
    drawing.modelspace().add_line((2, 2), (1, 1))
    path = tmp_path / "shop.dxf"
    drawing.saveas(path)
    text = path.read_text(encoding="utf-8").replace("  0\nEOF", "999\nmade by hand\n  0\nEOF")
    head, blocks, entities = text.partition("\nBLOCKS\n")
    bare = head + blocks + re.sub(r"(?m)^  5\n.*\n", "", entities)
    for one in (text, bare) if version == "R12" else (text,):
        path.write_text(one, encoding="utf-8")
        whole, read = ezdxf.readfile(path), open_drawing(path)
        for layout in ("*Model_Space", "PRESS"):
            remaining = [str(entity) for entity in read.blocks.get(layout)]
            there = [entity for entity in whole.blocks.get(layout) if entity.dxf.handle]
            if one is bare:
                assert remaining == [str(entity) for entity in there]
            else:
                assert remaining == [
                    str(entity) for entity in there if entity.dxftype() not in TOLD
                ]
                assert len(remaining) < len(there)
