"""Films of the replay page: their frames, their duration and their files."""

import asyncio
import subprocess
import sys

import numpy as np
import pytest
from processes import in_a_process
from run_events import record

import sim
from floorwalker import main

pytest.importorskip("matplotlib")
pytest.importorskip("playwright")
from sim import plots

images = pytest.importorskip("PIL.Image")

needs_browser = pytest.mark.usefixtures("chromium")

TRIAL = """
floorplan: ariac2023
duration: 40.0
people: [{name: ada, personality: antagonistic}]
gantry: {controller: parked, at: [-5.0, 2.5, 0.0]}
agvs: {agv1: [{time: 2.0, to: assembly_front}]}
"""


def pictures_in(path):
    """Return the pictures of a GIF, and how long each is shown (ms)."""
    pictures, durations = [], []
    with images.open(path) as film:
        for k in range(film.n_frames):
            film.seek(k)
            durations.append(film.info["duration"])
            pictures.append(np.asarray(film.convert("RGB"), dtype=int))
    return pictures, durations


@needs_browser
def test_a_film_has_the_requested_duration_and_size(run, tmp_path):
    reported = []
    out = tmp_path / "run.gif"
    plots.render(
        run, out, speed=10.0, fps=2, width=401, within=(0.0, 25.0), progress=reported.append
    )
    pictures, durations = pictures_in(out)
    assert {picture.shape[1] for picture in pictures} == {400}
    assert sum(durations) == 6 * 500
    assert reported == pytest.approx([k / 6 for k in range(1, 7)])


@needs_browser
@pytest.mark.slow
def test_an_mp4_has_all_pictures_and_the_same_bytes(run, tmp_path):
    av = pytest.importorskip("av")
    record(sim.Trial.parse(TRIAL), tmp_path / "run")
    words = ["run", "--fps", 1, "--width", 333, "--from", 12, "--to", 36]
    for name, litter in (("a.mp4", "0"), ("b.mp4", "1")):
        # bytes that glibc leaves in uninitialized memory
        env = {"MALLOC_PERTURB_": litter}
        done = in_a_process("render", *words, "--out", name, cwd=tmp_path, env=env)
        assert done.returncode == 0, done.stderr
    assert (tmp_path / "a.mp4").read_bytes() == (tmp_path / "b.mp4").read_bytes()
    with av.open(tmp_path / "a.mp4") as file:
        pictures = [picture.to_ndarray(format="rgb24") for picture in file.decode(video=0)]
        assert file.streams.video[0].average_rate == 1
    options = {"speed": 8.0, "fps": 1, "width": 333, "within": (12.0, 36.0)}
    plots.render(run, tmp_path / "run.gif", **options)
    shown, _ = pictures_in(tmp_path / "run.gif")
    assert len(pictures) == len(shown) == 4
    for one, other in zip(pictures, shown, strict=True):
        assert np.abs(one - other.astype(float)).mean() < 3.0


@needs_browser
@pytest.mark.slow
def test_a_full_disk_is_reported_and_leaves_no_film(tmp_path):
    code = """
import resource, signal, sys
import sim
from sim import plots

run = sim.run(sim.Trial.parse(sys.argv[1]))
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)

def fill(_):  # the browser runs by now, which has no such limit
    resource.setrlimit(resource.RLIMIT_FSIZE, (4000, 4000))

try:
    plots.render(run, sys.argv[2], width=300, fps=2, within=(0.0, 16.0), progress=fill)
except sim.OutputError as why:
    print(why)
"""
    pytest.importorskip("av")
    for name in ("a.gif", "a.mp4"):
        command = [sys.executable, "-B", "-c", code, TRIAL, str(tmp_path / name)]
        done = subprocess.run(command, capture_output=True, text=True, check=True)
        assert done.stdout == f"can't write {tmp_path / name}: File too large\n"
    assert list(tmp_path.iterdir()) == []


@needs_browser
@pytest.mark.parametrize(
    ("words", "why"),
    [
        (("ariac2023", "--out", "a.avi"), "the name of a film ends in one of .gif, .mp4"),
        (("ariac2023", "--out", "no/a.gif"), "there is no folder no"),
        (("ariac2023", "--out", "a.gif", "--speed", "0"), "speed must be more than 0, not 0"),
        (("ariac2023", "--out", "a.gif", "--speed", "inf"), "speed must be more than 0, not inf"),
        (("ariac2023", "--out", "a.gif", "--fps", "60"), "fps must be from 1 to 50, not 60"),
        (("ariac2023", "--out", "a.gif", "--width", "9"), "from 200 to 4000 pixels, not 9"),
        (("ariac2023", "--out", "a.gif", "--speed", "0.01"), "550,001 pictures, more than 20,000"),
        (("ariac2023", "--out", "a.gif", "--from", "300"), "nothing between 300 and 275 s"),
        (("nowhere", "--out", "a.gif"), "nor a built-in trial"),
    ],
)
def test_wrong_arguments_of_films_are_reported_in_a_sentence(
    words, why, tmp_path, monkeypatch, capsys
):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", ["floorwalker", "render", *words])
    with pytest.raises(SystemExit, match="1"):
        main()
    stdout, stderr = capsys.readouterr()
    assert stdout == ""
    assert why in stderr and stderr.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


@needs_browser
@pytest.mark.parametrize(("package", "name"), [("av", "run.mp4"), ("playwright", "run.gif")])
def test_a_missing_package_is_named_with_its_extra(run, tmp_path, monkeypatch, package, name):
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(plots.MissingExtraError, match=rf"{package}.*floorwalker\[film\]"):
        plots.render(run, tmp_path / name)


def test_a_film_without_a_browser_is_rejected(run, tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", "")
    monkeypatch.delenv("CHROMIUM", raising=False)
    monkeypatch.setattr("sim.views.film.PLACES", ())
    with pytest.raises(plots.MissingExtraError, match="needs Chromium or Chrome"):
        plots.render(run, tmp_path / "run.gif", view="3d")


@needs_browser
def test_the_command_films_a_recording(tmp_path, monkeypatch, capsys):
    record(sim.Trial.parse(TRIAL), tmp_path / "run")
    out = tmp_path / "run.gif"
    words = ["render", str(tmp_path / "run"), "--out", str(out), "--from", "20", "--to", "24"]
    monkeypatch.setattr(sys, "argv", ["floorwalker", *words, "--width", "240", "--fps", "2"])
    with pytest.raises(SystemExit, match="0"):
        main()
    assert capsys.readouterr() == (f"{out}\n", "")
    assert out.read_bytes().startswith(b"GIF89a")


@needs_browser
def test_a_film_can_be_made_inside_an_event_loop(run, tmp_path):
    async def notebook():
        plots.render(run, tmp_path / "run.gif", fps=1, width=240, within=(0.0, 9.0))

    asyncio.run(notebook())
    pictures, _ = pictures_in(tmp_path / "run.gif")
    assert len(pictures) == 2


@pytest.mark.slow
@needs_browser
def test_every_view_of_the_page_is_filmed(run, tmp_path):
    def pictures(view, **options):
        out = tmp_path / f"{view}.gif"
        options = {"speed": 8.0, "fps": 1, "width": 320, "within": (12.0, 28.0), **options}
        plots.render(run, out, view=view, **options)
        return pictures_in(out)[0]

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
