"""A run in a notebook, as IPython shows it."""

import io

import pytest

import sim

formatters = pytest.importorskip("IPython.core.formatters")


@pytest.fixture(scope="module")
def run():
    return sim.run(sim.Trial.load("scene_antagonistic"))


def shown(value):
    """What a notebook gets for a value, by MIME type."""
    data, _ = formatters.DisplayFormatter().format(value)
    return data


def test_a_run_shows_its_figures_and_its_replay(run, open_page):
    viewer = open_page(shown(run)["text/html"])
    table = viewer.page.locator("table").inner_text()
    assert f"{run.summary['penalties']}" in table
    assert "operator: personality\tantagonistic" in table
    replay = viewer.page.frame_locator("iframe")
    replay.locator("canvas").first.wait_for()
    frame = viewer.page.frames[1]
    viewer.wait_until(lambda: frame.evaluate("window.floorwalker !== undefined"))
    at = frame.evaluate(
        "floorwalker.pause(), floorwalker.seek(12.5), floorwalker.pose('operator', 12.5)"
    )
    assert (at["x"], at["y"]) == pytest.approx(tuple(run.motions["operator"].position(12.5)))
    assert viewer.complaints == []


def test_names_stay_text():
    trial = sim.Trial.parse("{floorplan: warehouse, name: '<b>&\"bold\"', duration: 1}")
    html = shown(sim.run(trial))["text/html"]
    assert "<b>" not in html
    assert "&lt;b&gt;&amp;&quot;bold&quot;" in html


def test_a_run_that_was_broken_off_is_shown(run, tmp_path):
    recording = sim.Recording(tmp_path / "run")
    sim.run(sim.Trial.load("scene_antagonistic"), recording)
    recording.close()
    html = shown(sim.load_run(tmp_path / "run"))["text/html"]
    assert "iframe" in html and "penalties" not in html.partition("<iframe")[0]


def test_figures_are_pictures_without_pyplot(run):
    pytest.importorskip("matplotlib")
    from PIL import Image

    figure = run.plot.separation(width="single")
    with Image.open(io.BytesIO(shown(figure)["image/png"])) as picture:
        assert picture.size[0] == int(3.5 * 110)
