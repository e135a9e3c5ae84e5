"""Studies and their results, which do not depend on processes, interruptions and backends."""

import csv
import json
import os
import shutil
import signal
import socket
import subprocess
import sys
from contextlib import suppress

import pytest
from hypothesis import given, settings, strategies as st
from processes import started
from waiting import HANG, until

import sim
from sim.studies import save_trial
from sim.studies.folder import StudyFolder
from sim.studies.table import ResultsTable

TRIAL = """\
floorplan: ariac2023
duration: 12
people: [{name: ada}, {name: ben, at: [-10, 0]}]
gantry:
  controller: "moody:moody"
  at: [-2.5, 0.5, 0.0]
  jobs: [{wait: 1.0}, {wait: 2.0}]
"""

CONTROLLER = """\
def moody(gantry):
    yield gantry.wait(1.0)
    if abs(gantry.position[0] + 2.5) > 0.01:
        raise ValueError("out of\\nsorts")
    while (task := (yield gantry.next_task())) is not None:
        yield gantry.do(task)
"""

STUDY = """\
trials: [short.trial.yaml]
grid:
  personality: [indifferent, antagonistic]
  gantry_at: [[-2.5, 0.5, 0], [-5, 1, 0]]
random:
  max_speed: {normal: [1.0, 0.2]}
repeat: 4
seed: 11
"""


def with_files(folder):
    """Return the folder with the files of a study."""
    (folder / "short.trial.yaml").write_text(TRIAL)
    (folder / "moody.py").write_text(CONTROLLER)
    (folder / "s.study.yaml").write_text(STUDY)
    return folder


@pytest.fixture
def folder(tmp_path):
    return with_files(tmp_path)


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    return sim.Study.load(with_files(tmp_path_factory.mktemp("study")) / "s.study.yaml")


@pytest.fixture(scope="module")
def finished_study(study):
    """Results of the study, in the folder `out` beside it."""
    return sim.run_study(study, study.folder / "out", jobs=1)


@pytest.fixture
def out(finished_study, tmp_path):
    """Copy of the folder of the finished study."""
    return shutil.copytree(finished_study.study.folder / "out", tmp_path / "out")


def lines(path):
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def command(folder, *arguments, **options):
    return started("study", "s.study.yaml", *arguments, cwd=folder, **options)


def finished(process):
    out, err = process.communicate(timeout=HANG)
    return process.returncode, out, err


def wait_for_rows(folder, process):
    """Wait until the study that `process` runs into `folder` has some rows."""
    results = folder / "results.jsonl"
    until(lambda: results.exists() and results.read_bytes().count(b"\n") > 3, process)


def test_every_row_has_the_figures_of_a_run_of_its_trial(study, finished_study, out):
    results, table = finished_study, lines(out / "results.csv")
    assert len(results) == len(table) == len(study) == 16
    for row, line in zip(study.rows(), table, strict=True):
        assert line["row"] == str(row.number)
        assert line["max_speed"] == str(row.parameters["max_speed"])
        assert line["gantry_at"] == " ".join(map(str, row.parameters["gantry_at"]))
        if row.parameters["gantry_at"][0] == -5:
            assert "moody" in line["error"] and "line 4): ValueError: out of sorts" in line["error"]
            assert line["penalties"] == line["people.ben.distance_walked"] == ""
            continue
        summary = sim.run(row.trial).summary
        assert line["error"] == ""
        assert line["penalties"] == str(summary["penalties"])
        assert line["jobs_done"] == str(summary["jobs_done"]) == "2"
        assert (
            float(line["minimum_separation.distance"])
            == (summary["minimum_separation"]["distance"])
        )
        ben = summary["people"]["ben"]
        assert float(line["people.ben.distance_walked"]) == ben["distance_walked"]
        assert line["people.ben.visits"] == str(len(ben["visits"]))
    assert [number for number, _ in results.failed.items()] == list(range(1, 16, 2))
    assert not {"cpu_seconds", "realtime_factor"} & set(results.columns)


@pytest.mark.slow
def test_results_do_not_depend_on_jobs_and_backend(study, tmp_path):
    written = set()
    with socket.socket() as taken:  # Dask's default port
        with suppress(OSError):  # another process has it
            taken.bind(("", 8787))
            taken.listen()
        for backend, jobs in (("sequential", 1), ("loky", 2), ("dask", 2)):
            out = tmp_path / backend
            sim.run_study(study, out, jobs=jobs, backend=backend)
            names = ("results.csv", "results.parquet", "report.html")
            written.add(tuple((out / name).read_bytes() for name in names))
    assert len(written) == 1


@pytest.mark.slow
def test_rows_run_on_the_cluster_of_the_current_client(study, tmp_path):
    from distributed import Client, LocalCluster

    with (
        LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address="localhost:0") as cluster,
        Client(cluster) as client,
    ):
        sim.run_study(study, tmp_path / "out", backend="dask")
        worked = client.run(lambda: "sim.studies.running" in sys.modules)
    assert list(worked.values()) == [True, True]
    assert len(lines(tmp_path / "out" / "results.csv")) == 16


def test_an_unknown_backend_is_rejected(study, tmp_path):
    with pytest.raises(ValueError, match="Invalid backend: lucky, expected one of"):
        sim.run_study(study, tmp_path / "out", backend="lucky")


WAITS = """\
import os
import time
from pathlib import Path
def moody(gantry):
    results = Path("killed/results.jsonl")
    runs = [Path(f"{os.getpid()}-run{k}") for k in range(6)]
    free = Path("held").exists() and next((run for run in runs if not run.exists()), None)
    if free:
        free.touch()  # the first few runs of each process do not wait for rows
    while Path("held").exists() and (
        not free or results.exists() and results.read_bytes().count(b"\\n") > 3
    ):
        time.sleep(0.01)
    yield from driven(gantry)
"""


@pytest.mark.slow
def test_a_killed_study_continues_and_ends_with_the_same_bytes(folder):
    (folder / "moody.py").write_text(CONTROLLER.replace("def moody", "def driven") + WAITS)
    (folder / "held").touch()  # with some rows, the controller waits until the test kills the study
    process = command(folder, "--out", "killed", "--jobs", "2", start_new_session=True)
    results = folder / "killed" / "results.jsonl"
    wait_for_rows(folder / "killed", process)
    os.killpg(process.pid, signal.SIGKILL)
    process.communicate()
    (folder / "held").unlink()
    assert results.read_bytes().count(b"\n") < 16
    with results.open("ab") as file:
        file.write(b'{"digest": "12')
    code, out, err = finished(command(folder, "--out", "killed", "--jobs", "1"))
    assert code == 1
    assert err.startswith("Continuing after ")
    assert "8 of 16 rows failed; row 1: ControllerError: the gantry controller" in err
    assert "killed/report.html" in out
    sim.run_study(sim.Study.load(folder / "s.study.yaml"), folder / "whole", jobs=1)
    for name in ("study.json", "results.csv", "results.parquet", "report.html"):
        assert (folder / "killed" / name).read_bytes() == (folder / "whole" / name).read_bytes()


LEAKY = """
from joblib.externals.loky.backend import resource_tracker
from sim.studies.running import backend_of

with backend_of("loky", 2):
    resource_tracker.register("/never-made", "semlock")
"""


def test_semaphores_are_cleaned_up_silently_after_an_interrupt():
    done = subprocess.run(
        [sys.executable, "-c", LEAKY], capture_output=True, text=True, timeout=HANG
    )
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")


@pytest.mark.parametrize(
    ("stop", "sent", "backend"),
    [
        (os.kill, signal.SIGTERM, "loky"),
        pytest.param(os.killpg, signal.SIGINT, "loky", marks=pytest.mark.slow),
        pytest.param(os.killpg, signal.SIGINT, "dask", marks=pytest.mark.slow),
    ],
)
def test_a_stopped_study_explains_how_to_continue(folder, stop, sent, backend):
    """It leaves no workers behind."""
    (folder / "s.study.yaml").write_text(STUDY.replace("repeat: 4", "repeat: 4000"))
    options = ("--out", "stopped", "--jobs", "2", "--backend", backend)
    process = command(folder, *options, start_new_session=True)
    wait_for_rows(folder / "stopped", process)
    stop(process.pid, sent)
    code, out, err = finished(process)
    assert (code, out) == (130, "")
    assert err == "Stopped. Finished rows are kept in stopped. Run the same command to continue.\n"
    with pytest.raises(ProcessLookupError):
        until(lambda: os.killpg(process.pid, 0))
    table = lines(folder / "stopped" / "results.csv")
    assert [line["row"] for line in table[:3]] == ["0", "1", "2"]


def test_a_finished_study_runs_no_row_again(study, out):
    table, reported = out / "results.csv", []
    before = (table.read_bytes(), table.stat().st_mtime_ns)
    results = sim.run_study(study, out, jobs=1, begin=reported.append, progress=reported.append)
    assert (reported, len(results)) == ([16], 16)
    assert (table.read_bytes(), table.stat().st_mtime_ns) == before


def test_a_changed_row_is_reported_and_removed_rows_are_run_again(study, out):
    rows, table = out / "results.jsonl", out / "results.csv"
    whole, csv_bytes = rows.read_bytes(), table.read_bytes()
    written = whole.splitlines(keepends=True)
    changed = written[3].replace(b'"seed": ', b'"seed": 7', 1)
    for lines in ([*written[:3], changed, *written[4:]], [*written[:3], *written[4:]]):
        rows.write_bytes(b"".join(lines))
        with pytest.raises(ValueError, match=r"results\.jsonl, line 4: row 3 is not as it was"):
            sim.run_study(study, out, jobs=1)
    rows.write_bytes(b"".join(written[:3]))
    begun = []
    sim.run_study(study, out, jobs=1, begin=begun.append)
    assert begun == [3]
    assert (rows.read_bytes(), table.read_bytes()) == (whole, csv_bytes)


def test_a_changed_table_is_restored_from_its_rows(study, finished_study, out):
    table = out / "results.csv"
    whole = table.read_bytes()
    table.write_bytes(whole.replace(b"\n3,", b"\n3;"))
    assert sim.run_study(study, out, jobs=1).columns == finished_study.columns
    assert table.read_bytes() == whole


@pytest.mark.parametrize(
    ("file", "change", "words"),
    [
        ("s.study.yaml", ("seed: 11", "seed: 12"), "the study"),
        ("s.study.yaml", ("0.2]", "0.3]"), "the study"),
        ("short.trial.yaml", ("wait: 2.0", "wait: 3.0"), "the trial short"),
        ("moody.py", ("1.0", "1.5"), "the controller moody:moody"),
    ],
)
def test_the_folder_of_another_study_is_rejected(folder, file, change, words):
    with StudyFolder(folder / "out", sim.Study.load(folder / "s.study.yaml")):
        pass
    text = (folder / file).read_text()
    (folder / file).write_text(text.replace(*change))
    other = sim.Study.load(folder / "s.study.yaml")
    with pytest.raises(sim.OutputError, match=rf"another study \(changed since: {words}\)"):
        sim.run_study(other, folder / "out", jobs=1)
    (folder / file).write_text(text)
    with StudyFolder(folder / "out", sim.Study.load(folder / "s.study.yaml")):
        pass


def test_a_program_that_changes_while_a_study_runs_is_reported(tmp_path):
    (tmp_path / "calm.asl").write_text("!rest. +!rest <- true.")
    text = "floorplan: ariac2023\nduration: 1\npeople: [{name: ada, personality: calm.asl}]\n"
    study = sim.Study("calm", (sim.Trial.parse(text, folder=tmp_path),), repeat=2)

    def edit(_):
        (tmp_path / "calm.asl").write_text("!rest. +!rest <- .wait(10).")

    with pytest.raises(sim.OutputError, match=r"while they were made: the program calm\.asl"):
        sim.run_study(study, tmp_path / "out", jobs=1, progress=edit)


def test_an_unusable_folder_is_rejected(study, tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(sim.OutputError, match="can't write to"):
        sim.run_study(study, tmp_path / "file")
    (tmp_path / "old").mkdir()
    (tmp_path / "old" / "results.csv").write_text("row\n")
    with pytest.raises(sim.OutputError, match=r"holds results, but no study\.json"):
        sim.run_study(study, tmp_path / "old")
    (tmp_path / "torn").mkdir()
    endless = json.dumps({"floorwalker" * 10_000: "x"})
    for damaged in ('{"flo', '{"floorwalker": ' + "[" * 100_000, endless):
        (tmp_path / "torn" / "study.json").write_text(damaged)
        with pytest.raises(sim.OutputError, match=r"study\.json|changed since: floorwalker") as why:
            sim.run_study(study, tmp_path / "torn")
        assert len(str(why.value)) < 1000


def test_a_study_continues_after_a_full_disk_is_reported(study, out, tmp_path, room_for):
    for room in (100, 400, 1500):
        full = pytest.raises(sim.OutputError, match=r"can't write to .*full: File too large")
        with full, room_for(room):
            sim.run_study(study, tmp_path / "full", jobs=1)
        left = {path.name for path in (tmp_path / "full").iterdir()}
        assert left <= {"study.json", "results.csv", "results.jsonl"}
    sim.run_study(study, tmp_path / "full", jobs=1)
    full = tmp_path / "full" / "results.csv"
    assert full.read_bytes() == (out / "results.csv").read_bytes()


def test_two_processes_cannot_work_on_one_folder(study, tmp_path):
    with (
        StudyFolder(tmp_path, study),
        pytest.raises(sim.OutputError, match="another process works on"),
    ):
        sim.run_study(study, tmp_path, jobs=1)


@pytest.mark.slow
def test_a_worker_that_dies_is_reported(folder):
    (folder / "moody.py").write_text("import os\ndef moody(gantry): yield os._exit(7)\n")
    code, out, err = finished(command(folder, "--out", "out", "--jobs", "2"))
    assert (code, out) == (1, "")
    assert err.startswith("floorwalker: a worker process was killed or ran out of memory")
    assert "Traceback" not in err


def test_the_trial_of_a_row_repeats_its_figures(study, out, folder, floorwalker):
    done = floorwalker("study", "s.study.yaml", "--row", "6", "--out", "row", cwd=folder)
    assert (done.returncode, done.stdout, done.stderr) == (0, "row/trials/000006.yaml\n", "")
    assert not (folder / "row" / "results.csv").exists()
    trial = sim.Trial.load(folder / "row" / "trials" / "000006.yaml")
    line = lines(out / "results.csv")[6]
    summary = sim.run(trial).summary
    assert line["seed"] == str(trial.seed)
    walked = summary["people"]["ben"]["distance_walked"]
    assert float(line["people.ben.distance_walked"]) == walked
    with pytest.raises(ValueError, match="has rows 0 to 15, but no row 16"):
        save_trial(study, 16, folder)


def test_requested_metrics_are_columns(folder):
    text = STUDY.replace("repeat: 4", "repeat: 1\nmetrics: true")
    study = sim.Study.parse(text, folder=folder)
    results = sim.run_study(study, folder / "out", jobs=1)
    metrics = sim.metrics(sim.run(study.row(0).trial))
    column = results.columns["metrics.people.ada.path_length"]
    assert column[0] == metrics["people"]["ada"]["path_length"]
    assert column[1] is None


def test_parquet_and_csv_contain_the_same_table(finished_study, out):
    import pandas

    results, frame = finished_study, pandas.read_parquet(out / "results.parquet")
    assert list(frame.columns) == list(results.columns)
    assert frame["penalties"].sum() == sum(v or 0 for v in results.columns["penalties"])
    assert frame["personality"].tolist() == results.columns["personality"]
    assert frame["error"].isna().sum() == 8


def test_check_accepts_studies(folder, floorwalker):
    checked = floorwalker("check", "s.study.yaml", cwd=folder)
    assert checked.returncode == 0
    assert checked.stdout.endswith("s.study.yaml: a study of 1 trial, 16 rows\n")
    (folder / "s.study.yaml").write_text(STUDY.replace("seed", "sed").replace("4", "0"))
    checked = floorwalker("check", "s.study.yaml", cwd=folder)
    assert checked.returncode == 1
    assert "2 problems" in checked.stderr


RECORDS = [
    {"row": 0, "name": "a, b", "error": None, "x": 1.5},
    {"row": 1, "name": 'c"', "error": "it broke"},
    {"row": 2, "name": "d", "error": None, "x": 2.0, "y": 7, "z": "ü"},
    {"row": 3, "name": "e", "error": None, "x": -1e-9, "y": None},
]


def written(folder, records):
    table = ResultsTable(folder)
    for record in records[table.rows :]:
        table.add(record)
    table.write_csv()
    columns = table.columns()
    table.close()
    return (folder / "results.jsonl").read_bytes(), (folder / "results.csv").read_text(), columns


@settings(max_examples=60)
@given(cut=st.integers(0, 400))
def test_a_table_cut_anywhere_is_continued(cut, tmp_path_factory):
    folder = tmp_path_factory.mktemp("table")
    whole, text, columns = written(folder, RECORDS)
    assert text == (
        'row,name,error,x,y,z\n0,"a, b",,1.5,,\n1,"c""",it broke,,,\n2,d,,2.0,7,ü\n3,e,,-1e-09,,\n'
    )
    assert columns["x"] == [1.5, None, 2.0, -1e-9]
    assert columns["y"] == [None, None, 7, None]
    assert columns["name"][1] == 'c"'
    (folder / "results.jsonl").write_bytes(whole[:cut])
    assert written(folder, RECORDS) == (whole, text, columns)


def test_a_defect_in_a_row_is_distinguished_from_a_mistake_of_the_user():
    from sim.studies.running import error_in

    def failing(cause):
        try:
            cause()
        except Exception as why:
            return error_in(why)["error"]

    def mistake():
        sim.Trial.load("no_such_trial")

    assert failing(mistake).startswith("TrialError: no_such_trial: no such file")
    defect = failing(lambda: (1, 2).index(3))
    assert "defect of Floorwalker" in defect
    assert "ValueError: tuple.index(x): x not in tuple (test_study.py, line " in defect


def test_a_failure_of_a_program_names_row_action_and_reason(tmp_path, floorwalker):
    (tmp_path / "far.asl").write_text("+human_start <- move(9.5, 3, 0).")
    (tmp_path / "far.trial.yaml").write_text(
        "floorplan: {boundary: [[0, 0], [10, 0], [10, 6], [0, 6]],"
        " obstacles: {wall: {x: [5, 5.2], y: [0, 6], z: [0, 3]}}}\n"
        "duration: 5\npeople: [{name: ada, personality: far.asl, at: [1, 1]}]\n"
    )
    (tmp_path / "far.study.yaml").write_text("trials: [far.trial.yaml]\nrepeat: 2\n")
    done = floorwalker("study", "far.study.yaml", "--jobs", 2, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    notices = [line for line in done.stderr.splitlines() if "an intention ended" in line]
    assert sorted(line.partition(":")[0] for line in notices) == ["row 0", "row 1"]
    for line in notices:
        assert "failed at far.asl:1 in move(9.5,3,0): action_failed; no way, however narrow" in line
