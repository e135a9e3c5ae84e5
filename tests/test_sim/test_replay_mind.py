"""The agent of a person and the gantry's job on the replay page, compared with the recording."""

import copy
import itertools
import re

import pytest
from replay_sample import replay, replay_data
from run_events import beliefs_after

import sim

pytestmark = pytest.mark.slow  # browsers draw in software

TRIAL = """
floorplan: ariac2023
duration: 90
people:
  - {name: operator, personality: antagonistic}
  - {name: visitor, personality: curious, at: [-12.0, -8.0]}
gantry:
  controller: oblivious
  jobs:
    - {pick: bin2, place: agv1, part: purple pump}
    - {wait: 5}
    - {pick: bin6, place: agv4, part: blue battery}
    - {submit: order1}
"""


class Curious(sim.Listener):
    wants_thoughts = True


@pytest.fixture(scope="module")
def run():
    return sim.run(sim.Trial.parse(TRIAL), Curious())


@pytest.fixture(scope="module")
def recording(run):
    return replay_data(run)


@pytest.fixture(scope="module")
def viewer(open_shared_page, recording):
    return open_shared_page(replay.render(recording))


def thoughts_until(run, person, t):
    return [x for x in run.thoughts if x["person"] == person and x["t"] <= t]


def shown(viewer, selector):
    """Return the full texts of items from their tooltips, because long values are shortened."""
    return viewer.page.locator(f".mind {selector} code").evaluate_all(
        "all => all.map(e => e.title)"
    )


def instants(run):
    times = sorted({thought["t"] for thought in run.thoughts})
    return [0.0, *(t + d for t in times[1::3] for d in (-0.01, 0.0, 0.01)), run.duration]


@pytest.mark.parametrize("person", ["operator", "visitor"])
def test_the_beliefs_shown_are_those_of_the_time(viewer, run, person):
    viewer.page.locator("#watch").select_option(label=f"{person} – gantry")
    for t in instants(run):
        viewer.seek(t)
        past = thoughts_until(run, person, t)
        assert set(shown(viewer, ".beliefs")) == beliefs_after(past), t
        intends = next((x["intends"] for x in reversed(past) if "intends" in x), [])
        assert shown(viewer, ".intentions") == [s for one in intends for s in one["stack"]], t
        steps = [
            step[1]
            for thought in past
            for step in thought.get("steps", ())
            if not (step[0] == "percept" and step[1].startswith("-"))
        ]
        titles = [title.partition("  ")[0] for title in shown(viewer, ".steps")]
        assert titles == steps[-6:], t


def test_the_panel_names_the_person_of_the_agent(viewer):
    viewer.page.locator("#watch").select_option(label="visitor – gantry")
    viewer.seek(10.0)
    assert viewer.text(".mind .whose") == "visitor, curious"


def test_a_change_of_personality_is_shown(open_page, recording):
    changed = copy.deepcopy(recording)
    event = {"t": 20.0, "kind": "personality_changed", "person": "operator"}
    changed["events"].append({**event, "personality": "helpful"})
    changed["events"].sort(key=lambda event: event["t"])
    viewer = open_page(replay.render(changed))
    for t, personality in ((19.0, "antagonistic"), (80.0, "helpful"), (5.0, "antagonistic")):
        viewer.seek(t)
        assert viewer.text(".mind .whose") == f"operator, {personality}"


def test_long_figures_are_shortened(viewer, run):
    viewer.page.locator("#watch").select_option(label="operator – gantry")
    viewer.seek(60.0)
    texts = viewer.page.locator(".mind code").all_inner_texts()
    assert texts
    assert not [text for text in texts if re.search(r"\.\d{3,}", text)]


def test_the_gantrys_job_is_shown_while_it_lasts(viewer, run):
    jobs = [e for e in run.events if e["kind"] in ("job_started", "job_done", "order_submitted")]
    assert {e["kind"] for e in jobs} >= {"job_started", "job_done"}
    for before, after in itertools.pairwise(jobs):
        if after["t"] <= before["t"]:
            continue
        viewer.seek((before["t"] + after["t"]) / 2)
        if before["kind"] == "job_started":
            job = before["job"].replace("_", " ")
            assert viewer.text("[data-shows=job-of]") == "job of gantry"
            assert viewer.text("[data-shows=job]").startswith(job)
            assert viewer.text("[data-shows=job]").endswith(f"since {before['t']:.2f} s")
        else:
            assert viewer.text("[data-shows=job]") == "none"


def test_a_panel_folds_and_unfolds(viewer):
    heading = viewer.page.locator(".mind h2 button")
    heading.click()
    assert viewer.page.locator(".mind .body").is_hidden()
    assert heading.get_attribute("aria-expanded") == "false"
    heading.click()
    assert viewer.page.locator(".mind .body").is_visible()


def test_a_click_on_a_person_shows_their_beliefs(viewer, run):
    viewer.page.locator("#watch").select_option(label="operator – gantry")
    viewer.page.locator("#follow").select_option("visitor")
    viewer.seek(5.0)
    box = viewer.page.locator(".view canvas.flat").bounding_box()
    viewer.page.mouse.click(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    viewer.settle()
    assert viewer.page.locator("#watch option:checked").inner_text() == "visitor – gantry"
    viewer.page.locator("#fit").click()
    assert viewer.complaints == []


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda minds: minds["operator"].reverse(), "minds.operator[1]: needs a time t"),
        (lambda minds: minds.update(operator={}), "minds.operator: a list is missing"),
        (lambda minds: minds["operator"][0].update(believes=[3]), "minds.operator[0]"),
        (lambda minds: minds["operator"][0].update(intends=[{}]), "minds.operator[0]"),
        (lambda minds: minds["operator"][0].update(steps="?"), "minds.operator[0]"),
    ],
)
def test_faults_of_thoughts_are_reported(open_page, recording, change, message):
    broken = copy.deepcopy(recording)
    change(broken["minds"])
    viewer = open_page(replay.render(broken))
    assert message in viewer.text("#trouble")
    assert viewer.complaints == []


def test_four_agvs_for_275_seconds_make_a_small_page():
    agvs = {
        f"agv{k}": [(30.0 * k, "assembly_back"), (30.0 * k + 60, "kitting")] for k in (1, 2, 3, 4)
    }
    text = TRIAL.replace("duration: 90", "duration: 275").replace(
        "  jobs:", "  repeat: true\n  jobs:"
    )
    lines = [
        f"  {name}: [{', '.join(f'{{time: {t}, to: {to}}}' for t, to in moves)}]"
        for name, moves in agvs.items()
    ]
    trial = sim.Trial.parse(text + "agvs:\n" + "\n".join(lines) + "\n")
    page = replay.render(replay_data(sim.run(trial, Curious())))
    assert len(page.encode()) < 500_000
