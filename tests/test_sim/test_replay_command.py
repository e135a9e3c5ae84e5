"""The command `floorwalker replay`."""

import shutil

import pytest
from replay_sample import recordings_in, render, replay_data

import sim

TRIAL = "floorplan: ariac2023\nduration: 12\npeople: [{name: operator}]\n"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with a finished run and an interrupted one."""
    folder = tmp_path_factory.mktemp("runs")
    for name in ("whole", "broken"):
        recording = sim.Recording(folder / name)
        simulation = sim.Simulation(sim.Trial.parse(TRIAL), recording)
        simulation.advance(9.0)
        if name == "whole":
            recording.finish(simulation.finish())
        recording.close()
    return folder


def test_the_page_of_a_run_is_named(folder, floorwalker):
    done = floorwalker("replay", "whole", "--no-open", cwd=folder)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout == "whole/replay.html\n"


def test_an_interrupted_run_gets_its_page(folder, floorwalker):
    assert not (folder / "broken" / "replay.html").exists()
    done = floorwalker("replay", "broken", "--no-open", cwd=folder)
    assert (done.returncode, done.stderr) == (0, "")
    (recording,) = recordings_in((folder / "broken" / "replay.html").read_text(encoding="utf-8"))
    assert recording["events"][0]["kind"] == "trial_started"
    assert recording["minds"]["operator"]


def test_a_recording_can_be_extracted_from_its_page(folder):
    page = (folder / "whole" / "replay.html").read_text(encoding="utf-8")
    data = replay_data(sim.load_run(folder / "whole"))
    (extracted,) = recordings_in(page)
    assert extracted["motions"] == recordings_in(render(data))[0]["motions"]
    assert render(extracted) == page


def test_a_damaged_recording_is_shown_up_to_the_damage(folder, tmp_path, floorwalker):
    damaged = shutil.copytree(folder / "whole", tmp_path / "damaged")
    (damaged / "replay.html").unlink()
    events = (damaged / "events.jsonl").read_text(encoding="utf-8").splitlines()
    events[2] = "?"
    (damaged / "events.jsonl").write_text("\n".join(events), encoding="utf-8")
    done = floorwalker("replay", "damaged", "--no-open", cwd=tmp_path)
    assert (done.returncode, done.stdout) == (0, "damaged/replay.html\n")
    assert done.stderr.startswith("damaged: events.jsonl: line 3: is not JSON")
    text = (damaged / "replay.html").read_text(encoding="utf-8")
    (recording,) = recordings_in(text)
    assert recording["notices"] == [done.stderr.removeprefix("damaged: ").rstrip("\n")]
    assert len(recording["events"]) == 2
    (tmp_path / "cut.html").write_text(text[:-400], encoding="utf-8")
    done = floorwalker("replay", "cut.html", "--no-open", cwd=tmp_path)
    assert (done.returncode, done.stdout) == (0, "cut.html\n")
    assert "damaged" in done.stderr and "the page shows the part that is intact" in done.stderr


def test_two_runs_make_one_page(folder, tmp_path, floorwalker):
    file = tmp_path / "both.html"
    page = folder / "whole" / "replay.html"
    done = floorwalker("replay", "broken", page, "--out", file, "--no-open", cwd=folder)
    assert (done.returncode, done.stdout) == (0, f"{file}\n")
    html = file.read_text(encoding="utf-8")
    assert html.count('type="application/json"') == 2
    assert [one["folder"] for one in recordings_in(html)] == ["broken", "whole"]
    assert html.index('id="other"') < html.index('id="recording"')


def test_a_page_of_two_runs_keeps_both(folder, tmp_path, floorwalker):
    two, again = tmp_path / "two.html", tmp_path / "again.html"
    floorwalker("replay", "whole", "broken", "--out", two, "--no-open", cwd=folder)
    done = floorwalker("replay", two, "--out", again, "--no-open", cwd=folder)
    assert done.returncode == 0
    assert again.read_text(encoding="utf-8") == two.read_text(encoding="utf-8")
    done = floorwalker("replay", two, "whole", "--out", again, "--no-open", cwd=folder)
    assert (done.returncode, done.stdout) == (1, "")
    assert "a page shows at most two runs" in done.stderr


def test_a_page_that_cannot_be_written_is_reported(folder, tmp_path, floorwalker):
    done = floorwalker("replay", "whole", "--out", tmp_path, "--no-open", cwd=folder)
    assert (done.returncode, done.stdout) == (1, "")
    assert done.stderr == f"floorwalker: can't write {tmp_path}: Is a directory\n"


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda path: None, "no such file or folder"),
        (lambda path: path.mkdir(), "there is no scene.json in it"),
        (lambda path: path.write_text("<p>Hello"), "is not a replay page: it contains"),
        (lambda path: path.write_bytes(b"\xff\xfe\x00"), "is not UTF-8 text"),
        (lambda path: path.write_text(page('{"format": 1')), "the recording in it is damaged"),
        (lambda path: path.write_text(page("[" * 100_000)), "damaged: recursion limit exceeded"),
        (lambda path: path.write_text(page('{"format": "x"}')), "floorwalker-replay/1"),
    ],
)
def test_a_folder_without_a_run_is_reported(tmp_path, make, message, floorwalker):
    make(tmp_path / "thing")
    done = floorwalker("replay", "thing", "--no-open", cwd=tmp_path)
    assert done.returncode == 1
    assert done.stdout == ""
    assert done.stderr.startswith("floorwalker: thing")
    assert message in done.stderr
    assert "Traceback" not in done.stderr


def page(recording):
    return f'<script type="application/json" id="recording">{recording}</script>'


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--speed", "3"], "needs --watch"),
        (["--watch", "--speed", "0"], "must be more than 0"),
        (["--watch", "--speed", "nan"], "must be more than 0"),
    ],
)
def test_an_invalid_speed_leaves_no_file_behind(tmp_path, options, message, floorwalker):
    done = floorwalker("run", "--out", "run", *options, cwd=tmp_path)
    assert done.returncode == 2
    assert message in done.stderr
    assert list(tmp_path.iterdir()) == []
