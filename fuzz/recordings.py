"""Readers of what we have written ourselves: recordings, replay pages, folders of studies."""

from __future__ import annotations

import tempfile
from functools import cache
from pathlib import Path
from zlib import crc32

import sim
from sim.studies.folder import IDENTITY, StudyFolder
from sim.studies.report import write_report
from sim.studies.results import StudyResults
from sim.studies.table import read_table
from sim.views.replay import recordings_in, render
from sim.views.replay_data import replay_data

from .told import told

RUN_FILES = (
    "scene.json",
    "summary.json",
    "events.jsonl",
    "motions.jsonl",
    "thoughts.jsonl",
    "violations.jsonl",
)
STUDY_FILES = ("study.json", "results.csv", "results.sha256")

TRIAL = """
floorplan: ariac2023
duration: 12.0
people: [{name: ada, personality: antagonistic, at: [-4.5, 2.0]}]
gantry: {controller: oblivious, at: [-2.5, 0.5, 0.0], jobs: [{move: [-3, 1, 0]}]}
agvs: {agv1: [{time: 0.5, to: as1}]}
"""


class RunFolder:
    """Reads a recording in which one file is another."""

    def __init__(self, name: str) -> None:
        self._name = name

    def sample(self) -> bytes:
        """The file as it was recorded."""
        return (_run_folder() / self._name).read_bytes()

    def __call__(self, data: bytes) -> None:
        """Load the recording with `data` in the file, and look at it as the commands do."""
        path = _run_folder() / self._name
        before = path.read_bytes()
        path.write_bytes(data)
        try:
            with told():
                use(sim.load_run(path.parent))
        finally:
            path.write_bytes(before)


def use(run: sim.Recorded) -> None:
    """What the commands ask of a run: its page, some samples, its metrics."""
    recordings_in(render(replay_data(run)))
    if run.duration <= 1000:
        run.sample(rate=2.0)
        sim.metrics(run)


def page() -> bytes:
    """A replay page without its scripts."""
    text = render(replay_data(sim.load_run(_run_folder())))
    begin = text.index('<script type="application/json" id="recording">')
    return text[begin : text.index("</script>", begin) + len("</script>")].encode()


class ResultsFolder:
    """Goes on with a study in whose folder one file is another."""

    def __init__(self, name: str, study: Path) -> None:
        self._name = name
        self._study = study

    def sample(self) -> bytes:
        """The file as the study has left it."""
        return (_results(self._study) / self._name).read_bytes()

    def __call__(self, data: bytes) -> None:
        """Open the folder with `data` in the file and add a row; report on one table in ten."""
        folder = _results(self._study)
        files = {name: (folder / name).read_bytes() for name in STUDY_FILES}
        (folder / self._name).write_bytes(data)
        try:
            with told():
                study = _loaded(self._study)
                with StudyFolder(folder, study) as opened:
                    if opened.table.rows < len(study):
                        opened.table.add({"row": opened.table.rows, "error": None})
                    results = StudyResults(study, folder, read_table(folder / "results.csv"))
                    if self._name != IDENTITY and crc32(data) % 10 == 0:
                        write_report(results, folder / "report.html")
        finally:
            for name, content in files.items():
                (folder / name).write_bytes(content)


@cache
def _kept(name: str) -> tempfile.TemporaryDirectory[str]:
    """A folder that is there until the process ends."""
    return tempfile.TemporaryDirectory(prefix=f"fuzz-{name}-")


@cache
def _run_folder() -> Path:
    folder = Path(_kept("run").name) / "run"
    recording = sim.Recording(folder)
    recording.finish(sim.run(sim.Trial.parse(TRIAL), recording))
    return folder


@cache
def _loaded(study: Path) -> sim.Study:
    return sim.Study.load(study)


@cache
def _results(study: Path) -> Path:
    folder = Path(_kept("study").name) / "results"
    sim.run_study(_loaded(study), folder, jobs=1)
    return folder
