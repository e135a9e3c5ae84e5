"""Films show everybody where they are at every instant; they play as long as they should."""

import subprocess
import sys

import numpy as np
import pytest
from processes import in_a_process
from run_events import record

import sim
from sim.cli import main

pytest.importorskip("matplotlib")
from sim.views import browser as chromium, plots
from sim.views.plots.film import Film
from sim.views.plots.style import person_colour

TRIAL = """
floorplan: ariac2023
duration: 40.0
people: [{name: ada, personality: antagonistic}]
gantry: {controller: parked, at: [-5.0, 2.5, 0.0]}
agvs: {agv1: [{time: 2.0, to: assembly_front}]}
"""


@pytest.fixture(scope="module")
def run():
    return sim.run(sim.Trial.parse(TRIAL))


def centre(frame, colour):
    """The middle (column, row) of all pixels of a colour."""
    wanted = [int(colour[k : k + 2], 16) for k in (1, 3, 5)]
    rows, columns = np.nonzero((frame == wanted).all(axis=2))
    return columns.mean(), rows.mean()


def test_people_are_where_they_are(run):
    """Pixels are metres, stretched and moved; also from one side of a teleport to the other."""
    teleport, *_ = [event["t"] for event in run.events if event["kind"] == "teleport"]
    times = np.sort([*np.linspace(0.0, 38.0, 13), teleport - 0.01, teleport, teleport + 0.01])
    film = Film(run, width=600, mark=1.0)
    pixels = np.array([centre(film.at(t), person_colour(0)) for t in times.tolist()])
    metres = run.motions["ada"].position(times)
    assert np.hypot(*np.diff(metres, axis=0).T).max() > 5.0
    known = np.column_stack([metres, np.ones(len(times))])
    stretch, *_ = np.linalg.lstsq(known, pixels, rcond=None)
    assert np.abs(known @ stretch - pixels).max() < 1.5
    assert stretch[0, 0] == pytest.approx(-stretch[1, 1], rel=0.03)


def test_a_picture_is_the_same_wherever_the_film_begins(run):
    """Also the way behind people, which they went before that."""
    walked = run.motions["ada"].position([20.0, 30.0])
    assert np.hypot(*np.diff(walked, axis=0).T) > 1.0
    film = Film(run, width=400, mark=1.0)
    *_, late = [film.at(t) for t in (0.0, 15.0, 30.0)]
    assert (Film(run, width=400, mark=1.0).at(30.0) == late).all()


def test_a_film_is_as_long_and_as_large_as_asked_for(run, tmp_path):
    from PIL import Image

    told = []
    out = tmp_path / "run.gif"
    plots.render(run, out, speed=10.0, fps=10, width=401, within=(0.0, 12.0), progress=told.append)
    with Image.open(out) as film:
        assert film.size[0] == 400
        durations = []
        for k in range(film.n_frames):
            film.seek(k)
            durations.append(film.info["duration"])
    assert sum(durations) == 13 * 100
    assert told == pytest.approx([k / 13 for k in range(1, 14)])


def test_the_same_run_gives_the_same_film(run, tmp_path):
    for name in ("a.gif", "b.gif"):
        plots.render(run, tmp_path / name, width=240, within=(15.0, 25.0))
    assert (tmp_path / "a.gif").read_bytes() == (tmp_path / "b.gif").read_bytes()


@pytest.mark.slow
def test_an_mp4_has_all_pictures_and_the_same_bytes(run, tmp_path):
    av = pytest.importorskip("av")
    record(sim.Trial.parse(TRIAL), tmp_path / "run")
    words = ["run", "--fps", 10, "--width", 333, "--from", 0, "--to", 8]
    for name, litter in (("a.mp4", "0"), ("b.mp4", "1")):
        # What glibc leaves in memory that nobody has written to yet.
        env = {"MALLOC_PERTURB_": litter}
        done = in_a_process("render", *words, "--out", name, cwd=tmp_path, env=env)
        assert done.returncode == 0, done.stderr
    assert (tmp_path / "a.mp4").read_bytes() == (tmp_path / "b.mp4").read_bytes()
    with av.open(tmp_path / "a.mp4") as file:
        pictures = [picture.to_ndarray(format="rgb24") for picture in file.decode(video=0)]
        assert file.streams.video[0].average_rate == 10
    film = Film(run, width=333, mark=1.0)
    assert len(pictures) == 11
    for k, picture in enumerate(pictures):
        assert np.abs(picture - film.at(0.8 * k).astype(float)).mean() < 3.0


@pytest.mark.slow
def test_a_full_disk_is_said_and_leaves_no_film(tmp_path):
    code = """
import resource, signal, sys
import sim
from sim import plots

run = sim.run(sim.Trial.parse(sys.argv[1]))
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (4000, 4000))
try:
    plots.render(run, sys.argv[2], width=300, within=(0.0, 16.0))
except sim.OutputError as why:
    print(why)
"""
    pytest.importorskip("av")
    for name in ("a.gif", "a.mp4"):
        command = [sys.executable, "-B", "-c", code, TRIAL, str(tmp_path / name)]
        done = subprocess.run(command, capture_output=True, text=True, check=True)
        assert done.stdout == f"can't write {tmp_path / name}: File too large\n"
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("words", "why"),
    [
        (("ariac2023", "--out", "a.avi"), "the name of a film ends in one of .gif, .mp4"),
        (("ariac2023", "--out", "no/a.gif"), "there is no folder no"),
        (("ariac2023", "--out", "a.gif", "--speed", "0"), "speed is more than 0, not 0"),
        (("ariac2023", "--out", "a.gif", "--speed", "inf"), "speed is more than 0, not inf"),
        (("ariac2023", "--out", "a.gif", "--fps", "60"), "1 to 50 pictures a second, not 60"),
        (("ariac2023", "--out", "a.gif", "--width", "9"), "200 to 4000 pixels wide, not 9"),
        (("ariac2023", "--out", "a.gif", "--speed", "0.01"), "550,001 pictures, more than 20,000"),
        (("ariac2023", "--out", "a.gif", "--from", "300"), "nothing between 300 and 275 s"),
        (("nowhere", "--out", "a.gif"), "nor a built-in trial"),
    ],
)
def test_what_makes_no_film_is_one_sentence(words, why, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", ["floorwalker", "render", *words])
    with pytest.raises(SystemExit, match="1"):
        main()
    stdout, stderr = capsys.readouterr()
    assert stdout == ""
    assert why in stderr and stderr.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def test_without_an_encoder_the_message_says_what_to_do(run, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "av", None)
    with pytest.raises(plots.MissingExtraError, match=r"needs the package av.*pip install"):
        plots.render(run, tmp_path / "run.mp4")


def test_the_command_films_a_recording(tmp_path, monkeypatch, capsys):
    record(sim.Trial.parse(TRIAL), tmp_path / "run")
    out = tmp_path / "run.gif"
    words = ["render", str(tmp_path / "run"), "--out", str(out), "--from", "20", "--to", "24"]
    monkeypatch.setattr(sys, "argv", ["floorwalker", *words, "--width", "240"])
    with pytest.raises(SystemExit, match="0"):
        main()
    assert capsys.readouterr() == (f"{out}\n", "")
    assert out.read_bytes().startswith(b"GIF89a")


@pytest.mark.slow
@pytest.mark.skipif(chromium.installed_chromium() is None, reason="no Chromium on this machine")
def test_the_page_is_filmed(run, tmp_path):
    from PIL import Image

    def pictures(view, **options):
        out = tmp_path / f"{view}.gif"
        options = {"speed": 8.0, "fps": 1, "width": 320, "within": (12.0, 28.0), **options}
        plots.render(run, out, view=view, **options)
        with Image.open(out) as film:
            found = []
            for k in range(film.n_frames):
                film.seek(k)
                found.append(np.asarray(film.convert("RGB"), dtype=int))
        return found

    above = pictures("2d")
    assert {picture.shape[1] for picture in above} == {320}
    assert len(above) == 3
    again = pictures("2d")
    assert all((one == other).all() for one, other in zip(above, again, strict=True))
    assert len({picture.tobytes() for picture in above}) == 3
    space = pictures("3d", follow="ada", dark=True)
    assert [picture.shape for picture in space] == [(180, 320, 3)] * 3
    assert space[0].mean() < 80 < above[0].mean()
    with pytest.raises(ValueError, match="nobody is called 'bob'"):
        pictures("eyes", follow="bob")


def test_a_film_of_the_page_without_a_browser_is_refused(run, tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", "")
    monkeypatch.setattr(chromium, "PLACES", ())
    with pytest.raises(plots.MissingExtraError, match="need Chromium or Chrome"):
        plots.render(run, tmp_path / "run.gif", view="3d")
    with pytest.raises(ValueError, match="give its view"):
        plots.render(run, tmp_path / "run.gif", follow="ada")
