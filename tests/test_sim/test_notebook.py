"""A run in a notebook, as IPython shows it."""

import io
import json
from dataclasses import replace

import pytest
from run_events import figures_in_words

import sim

formatters = pytest.importorskip("IPython.core.formatters")


@pytest.fixture(scope="module")
def run():
    return sim.run(sim.Trial.load("scene_antagonistic"))


def shown(value):
    """Return the representations of a value in a notebook, by MIME type."""
    data, _ = formatters.DisplayFormatter().format(value)
    return data


@pytest.mark.slow
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


def test_names_are_escaped():
    trial = sim.Trial.parse("{floorplan: warehouse, name: '<b>&\"bold\"', duration: 1}")
    html = shown(sim.run(trial))["text/html"]
    assert "<b>" not in html
    assert "&lt;b&gt;&amp;&quot;bold&quot;" in html


def test_an_interrupted_run_is_shown(run, tmp_path):
    recording = sim.Recording(tmp_path / "run")
    sim.run(sim.Trial.load("scene_antagonistic"), recording)
    recording.close()
    html = shown(sim.load_run(tmp_path / "run"))["text/html"]
    assert "iframe" in html and "penalties" not in html.partition("<iframe")[0]


def test_a_summary_with_missing_fields_is_shown(run):
    whole = json.loads(json.dumps(run.summary))
    complete = dict(figures_in_words(whole))
    person = whole["people"]["operator"]
    for part in (whole, whole["minimum_separation"], whole["violations"], whole["people"], person):
        for key, value in dict(part).items():
            for odd in (None, "odd", 1, [1]):
                part[key] = odd
                figures_in_words(whole)
            del part[key]
            assert dict(figures_in_words(whole)).keys() <= complete.keys()
            part[key] = value
    del whole["minimum_separation"]["time"]
    table = shown(replace(run, summary=whole))["text/html"].partition("<iframe")[0]
    assert "least distance to gantry" not in table and "walked" in table


def test_figures_are_pictures_without_pyplot(run):
    pytest.importorskip("matplotlib")
    from PIL import Image

    figure = run.plot.separation(width="single")
    with Image.open(io.BytesIO(shown(figure)["image/png"])) as picture:
        assert picture.size[0] == int(3.5 * 110)
