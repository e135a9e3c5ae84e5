"""Files that users give: regular ones of a size that makes sense, and what a shell hands over."""

import os
import socket
import subprocess
import sys

import pytest

import bdi
import floorplan
import sim
from floorplan import InputError
from floorplan.files.reading import read_bytes, read_lines, read_text
from sim.commands.agent import read_percepts

pytestmark = pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="needs a POSIX system")

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


def test_what_is_no_file_is_named(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # a socket's path is short
    with socket.socket(socket.AF_UNIX) as door:
        door.bind("door")
        with pytest.raises(InputError, match="is a socket; give a regular file"):
            read_bytes(tmp_path / "door", InputError)


def test_the_image_of_a_map_is_a_regular_file(tmp_path):
    os.mkfifo(tmp_path / "map.pgm")
    (tmp_path / "map.yaml").write_text(
        "{image: map.pgm, resolution: 0.05, origin: [0, 0, 0], negate: 0,"
        " occupied_thresh: 0.65, free_thresh: 0.2}"
    )
    with pytest.raises(floorplan.FloorplanError, match=r"map\.pgm': is a named pipe"):
        floorplan.load(tmp_path / "map.yaml")


def test_a_recording_is_of_regular_files(tmp_path):
    trial = sim.Trial.parse("{floorplan: ariac2023, duration: 1.0}")
    recording = sim.Recording(tmp_path / "run")
    recording.finish(sim.run(trial, recording))
    for name in ("motions.jsonl", "events.jsonl", "summary.json", "scene.json"):
        path = tmp_path / "run" / name
        kept = path.read_bytes()
        path.unlink()
        os.mkfifo(path)
        with pytest.raises(InputError):
            sim.load_run(tmp_path / "run")
        path.unlink()
        path.write_bytes(kept)
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


def test_lines_come_one_by_one_and_a_torn_one_can_be_left_out(tmp_path):
    path = tmp_path / "lines"
    path.write_bytes(b"one\n\ntwo\nthr\xc3")
    assert list(read_lines(path, InputError, torn=True)) == ["one", "", "two"]
    with pytest.raises(InputError, match=r"line 4: is not UTF-8 text \(byte 3\)"):
        list(read_lines(path, InputError))


def test_what_a_shell_hands_over_is_read(tmp_path):
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
