"""Files that commands write: whole or not at all, and folders that nobody else takes."""

import os
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from threading import Barrier

import pytest
from run_events import record

import sim
from sim.core.output import replacing, write_whole

TRIAL = "floorplan: ariac2023\nduration: 3.0\npeople: [{name: ada}]\n"


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    folder = tmp_path_factory.mktemp("recorded")
    record(sim.Trial.parse(TRIAL), folder / "run")
    return folder / "run"


@pytest.mark.parametrize(
    ("command", "file"),
    [
        ("replay {run} --no-open --out {file}", "page.html"),
        ("export {run} --out {file}", "table.csv"),
        ("export {run} --out {file}", "people.sqlite"),
    ],
)
def test_a_full_disk_leaves_what_was_there_before(
    recorded, tmp_path, floorwalker, room_for, command, file
):
    (tmp_path / file).write_text("the one before")
    with room_for(4000):
        done = floorwalker(*command.format(run=recorded, file=file).split(), cwd=tmp_path)
    assert done.returncode == 1
    assert done.stderr.startswith(f"floorwalker: can't write {file}: ")
    assert [path.name for path in tmp_path.iterdir()] == [file]
    assert (tmp_path / file).read_text() == "the one before"


def test_a_file_takes_the_place_of_another_at_once(tmp_path):
    (tmp_path / "a").write_text("before")
    (tmp_path / "link").symlink_to(tmp_path / "a")
    with pytest.raises(KeyError), replacing(tmp_path / "a") as unfinished:
        unfinished.write_text("half")
        raise KeyError
    assert (tmp_path / "a").read_text() == "before"
    write_whole(tmp_path / "link", "after")
    assert (tmp_path / "link").is_symlink() and (tmp_path / "a").read_text() == "after"
    assert {path.name for path in tmp_path.iterdir()} == {"a", "link"}
    write_whole(Path(os.devnull), "nothing")


def test_runs_that_begin_at_once_get_folders_of_their_own(tmp_path):
    scene = sim.run(sim.Trial.parse(TRIAL)).scene
    together = Barrier(8)

    def begin():
        recording = sim.Recording(tmp_path / "runs" / "t", numbered=True)
        together.wait()
        recording.begin(scene)
        recording.close()
        return recording.folder.name

    with ThreadPoolExecutor(8) as threads:
        taken = [thread.result() for thread in [threads.submit(begin) for _ in range(8)]]
    assert sorted(taken) == sorted(["t", *(f"t-{k}" for k in range(2, 9))])
    (tmp_path / "file").write_text("")
    with pytest.raises(sim.OutputError):
        sim.Recording(tmp_path / "file" / "t", numbered=True).begin(scene)


@pytest.mark.parametrize(
    ("out", "why"), [("file", "it is no folder"), ("file/inside", "Not a directory")]
)
def test_a_run_that_can_not_be_written_says_so(tmp_path, floorwalker, out, why):
    (tmp_path / "file").write_text("")
    done = floorwalker("run", "--duration", "2", "--out", out, cwd=tmp_path)
    assert done.returncode == 1 and done.stdout == ""
    assert done.stderr == f"floorwalker: can't write to {out}: {why}\n"


def test_a_run_needs_no_stdout(tmp_path, floorwalker, monkeypatch):
    monkeypatch.setattr("sys.stdout", None)
    monkeypatch.setattr("sys.__stdout__", None)
    done = floorwalker("run", "--duration", "2", "--out", "run", cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert sim.load_run(tmp_path / "run").duration == 2.0
