"""Every view draws a custom machine by its box and its course."""

import io
import json

import pytest
from replay_sample import render, replay_data
from run_events import Figure, Recorded, Scene

import floorplan
import sim
from navigation import standing, walk

PRESS = sim.MachineShape(
    name="press", kind="press", category="robot", length=2.0, width=1.0, top=2.4, top_speed=0.0
)
CART = sim.MachineShape(
    name="cart",
    kind="tugger_train",
    category="vehicle",
    length=1.2,
    width=0.6,
    top=0.9,
    top_speed=1.0,
    course=((2.0, 1.0), (8.0, 1.0), (8.0, 3.0)),
)


@pytest.fixture(scope="module")
def run():
    plan = floorplan.parse("{boundary: [[0, 0], [10, 0], [10, 4], [0, 4]]}")
    starts = {"ada": (1.0, 2.0, 0.0), "press": (5.0, 2.5, 0.0), "cart": (2.0, 1.0, 0.0)}
    ada = Figure("ada", personality="calm", radius=0.3, height=1.7)
    scene = Scene(
        trial="own",
        seed=0,
        floorplan=plan,
        rules=sim.PAPER,
        people=(ada,),
        starts=starts,
        machines=(PRESS, CART),
    )
    motions = {
        "ada": walk([(1.0, 2.0), (4.0, 2.0)], 0.0, max_speed=1.0, max_acceleration=2.5),
        "press": standing((5.0, 2.5)),
        "cart": walk(CART.course, 1.0, max_speed=1.0, max_acceleration=0.5),
    }
    violations = {("ada", "press"): ((1.0, 9.0),), ("ada", "cart"): ((2.0, 3.0),)}
    events = (
        {"t": 1.0, "kind": "violation", "person": "ada", "with": "press", "required": 3.5},
        {"t": 1.0, "kind": "gantry_disabled", "machine": "press", "seconds": 4.0},
        {"t": 5.0, "kind": "gantry_enabled", "machine": "press"},
    )
    return Recorded(scene, 9.0, summary={}, events=events, motions=motions, violations=violations)


def test_pictures_show_custom_machines(run):
    pytest.importorskip("matplotlib")

    (axes,) = run.plot.trails().axes
    _, labels = axes.get_legend_handles_labels()
    assert {"ada", "press", "tugger train"} <= set(labels)
    assert any(line.get_xdata().tolist() == [2.0, 8.0, 8.0] for line in axes.lines)
    (axes,) = run.plot.separation().axes
    assert axes.get_title("left") == "ada and press"
    assert "press disabled" in axes.get_legend_handles_labels()[1]
    run.plot.separation(machine="cart").savefig(io.BytesIO(), format="svg")
    assert len(run.plot.space_time().axes[0].collections) == 3


def test_the_replay_page_shows_custom_machines(run, browser, tmp_path):
    recording = json.loads(json.dumps(replay_data(run)))
    cart = next(body for body in recording["bodies"] if body["name"] == "cart")
    assert cart["category"] == "vehicle" and cart["course"] == [[2, 1], [8, 1], [8, 3]]
    page = browser.new_page()
    errors = []
    page.on("pageerror", lambda error: errors.append(error))
    (tmp_path / "own.html").write_text(render(recording), encoding="utf-8")
    page.goto((tmp_path / "own.html").as_uri() + "#t=4")
    page.wait_for_function("floorwalker.time === 4")
    assert page.locator("#trouble").is_hidden()
    assert page.locator("#watch option").all_inner_texts() == ["ada – press", "ada – cart"]
    assert "press disabled" in page.locator(".events ol").inner_text()
    page.evaluate("() => new Promise(requestAnimationFrame)")
    page.close()
    assert errors == []


@pytest.mark.parametrize("ending", [".mcap", "", ".sqlite"])
def test_exports_contain_custom_machines(run, tmp_path, ending):
    if ending != ".sqlite":
        pytest.importorskip("foxglove" if ending else "rosbags")
        from sim.exports import scene as drawing

        things = {thing.name: thing for thing in (*drawing.floor(run), *drawing.bodies(run))}
        press, cart = things["press"].shapes[0], things["cart"].shapes[0]
        assert press.size == (2.0, 1.0, 2.4) and cart.size == (1.2, 0.6, 0.9)
        assert press.color != cart.color
        assert len(things["lane cart"].shapes[0].points) == 3
    sim.export(run, tmp_path / f"run{ending}")
