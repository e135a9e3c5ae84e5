"""Files that commands write: whole or not at all, and folders that nobody else takes."""

import ast
import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from threading import Barrier

import pytest

import sim
from sim.core.output import replacing, write_whole

ROOT = Path(__file__).resolve().parents[2]
TRIAL = "floorplan: ariac2023\nduration: 3.0\npeople: [{name: ada}]\n"

FULL_DISK = """
import resource, signal, sys
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (4000, 4000))
from sim.cli import main
main()
"""


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    folder = tmp_path_factory.mktemp("recorded")
    recording = sim.Recording(folder / "run")
    recording.finish(sim.run(sim.Trial.parse(TRIAL), recording))
    return folder / "run"


@pytest.mark.parametrize(
    ("command", "file"),
    [
        ("replay {run} --no-open --out {file}", "page.html"),
        ("export {run} --out {file}", "table.csv"),
        ("export {run} --out {file}", "people.sqlite"),
    ],
)
def test_a_full_disk_leaves_what_was_there_before(recorded, tmp_path, command, file):
    """A limit on the size of files stands for the disk."""
    pytest.importorskip("resource")
    (tmp_path / file).write_text("the one before")
    arguments = command.format(run=recorded, file=file).split()
    done = subprocess.run(
        [sys.executable, "-c", FULL_DISK, *arguments],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        timeout=120,
    )
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


WRITES = {
    "navigation/benchmark/reports.py": "to a path that the command gives, which is replaced",
    "sim/exports/csv_file.py": "to a path that is replaced",
    "sim/exports/mcap_file.py": "to a path that is replaced",
    "sim/record/lines.py": "line by line, each whole or not at all",
    "sim/core/output.py": "the one place",
    "sim/runs/recording.py": "to a path that is replaced",
    "sim/studies/digests.py": "line by line",
    "sim/studies/table.py": "line by line, or to a path that is replaced",
}
"""Which modules write files, and how they see to it that none is cut."""


def test_every_module_that_writes_is_known():
    found = set()
    for package in ("bdi", "floorplan", "navigation", "sim"):
        for path in (ROOT / package).rglob("*.py"):
            if any(map(_writes, ast.walk(ast.parse(path.read_text(encoding="utf-8"))))):
                found.add(path.relative_to(ROOT).as_posix())
    assert found == WRITES.keys()


def _writes(node):
    if not (isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute)):
        return False
    if node.func.attr in ("write_text", "write_bytes"):
        return True
    modes = [one.value for one in node.args[:1] if isinstance(one, ast.Constant)]
    return node.func.attr == "open" and any(set(str(mode)) & set("wax+") for mode in modes)


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
