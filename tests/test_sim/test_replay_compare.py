"""Two recordings side by side on the replay page."""

import copy
import json

import pytest
import replay_sample
from replay_sample import replay

pytestmark = pytest.mark.slow  # browsers draw in software


@pytest.fixture(scope="module")
def recording():
    return replay_sample.recording()


@pytest.fixture(scope="module")
def other():
    """The sample with the person elsewhere and an earlier end."""
    changed = copy.deepcopy(replay_sample.recording())
    changed["title"] = "the other"
    changed["duration"] = 200.0
    for piece in changed["motions"]["operator"]:
        piece[2][0] -= 1.5
    changed["summary"]["penalties"] = 7
    return changed


@pytest.fixture
def compared(open_page, recording, other, tmp_path):
    """A page of both recordings, with the other one chosen as a file."""
    viewer = open_page(replay.render(recording))
    file = tmp_path / "other.html"
    file.write_text(replay.render(other), encoding="utf-8")
    viewer.page.locator("#other-file").set_input_files(file)
    viewer.wait_until(lambda: viewer.page.locator(".view").count() == 2)
    return viewer


def distances(viewer):
    texts = viewer.page.locator("[data-shows=distance]").all_inner_texts()
    return [float(text.split()[0]) for text in texts]


def test_both_show_the_same_instant(compared, recording, other):
    for t in (0.0, 31.5, 88.25, 199.0):
        compared.seek(t)
        expected = [
            replay_sample.separation(
                r["motions"]["operator"], r["motions"]["gantry"], replay_sample.LAW, t
            )[0]
            for r in (recording, other)
        ]
        assert distances(compared) == pytest.approx(expected, abs=0.00501)
    assert compared.complaints == []


def test_two_fit_on_a_phone(open_page, recording, other):
    titles = ("cell · ariac2023", "a night shift · warehouse")
    one, two = ({**r, "title": t} for r, t in zip((recording, other), titles, strict=True))
    viewer = open_page(
        replay.render(one, two), viewport={"width": 390, "height": 844}, has_touch=True
    )
    viewer.settle()
    assert viewer.page.evaluate("document.documentElement.scrollWidth") <= 390


def test_a_page_can_hold_two_from_the_start(open_page, recording, other):
    viewer = open_page(replay.render(recording, other))
    assert viewer.page.locator(".view .title").all_inner_texts() == [
        recording["title"],
        other["title"],
    ]
    assert viewer.complaints == []


def test_runs_of_one_title_are_named_by_their_differences(open_page, recording):
    scared = copy.deepcopy(recording)
    scared["bodies"][0]["personality"] = "scared"
    one, two = {**recording, "folder": "monday"}, {**scared, "folder": "tuesday"}
    viewer = open_page(replay.render(one, two))
    titles = viewer.page.locator(".view .title").all_inner_texts()
    assert titles == ["operator: indifferent, monday", "operator: scared, tuesday"]
    assert viewer.page.locator("#focus button").all_inner_texts() == [
        "A operator: indifferent",
        "B operator: scared",
    ]
    one, two = ({**recording, "controller": name} for name in ("pausing", "avoiding"))
    viewer = open_page(replay.render(one, two))
    titles = viewer.page.locator(".view .title").all_inner_texts()
    assert titles == ["controller pausing", "controller avoiding"]


def test_the_longer_one_gives_the_end(compared, open_page, recording, other):
    compared.page.keyboard.press("End")
    assert compared.time == 275.0
    swapped = open_page(replay.render(other, recording))
    swapped.page.keyboard.press("End")
    assert swapped.time == 275.0


def test_both_floors_move_together(compared):
    views = compared.page.locator(".view canvas.flat")
    before = [views.nth(k).screenshot() for k in range(2)]
    views.first.hover()
    compared.page.mouse.wheel(0, -300)
    compared.settle()
    for k in range(2):
        assert views.nth(k).screenshot() != before[k]
    compared.page.keyboard.press("0")
    compared.page.mouse.move(2, 2)
    compared.settle()
    for k in range(2):
        assert not compared.differ(before[k], views.nth(k).screenshot())


def test_the_panels_show_the_chosen_run(compared, recording, other):
    assert compared.page.locator("#focus button").all_inner_texts() == [
        f"A {recording['title']}",
        f"B {other['title']}",
    ]
    compared.page.locator("#focus button").nth(1).click()
    shown = compared.page.locator(".panels:visible")
    assert shown.count() == 1
    assert shown.locator(".events li").count() == len(other["events"])


def test_the_summaries_stand_side_by_side(compared, recording):
    summary = compared.page.locator(".panels:visible .summary")
    if summary.locator("h2 button").get_attribute("aria-expanded") == "false":
        summary.locator("h2 button").click()
    cells = summary.locator("dt:text-is('penalties') ~ dd").all_inner_texts()[:2]
    assert cells == [str(recording["summary"]["penalties"]), "7"]


def renamed(recording, who, name):
    """Return a recording in which a person has another name."""
    return json.loads(json.dumps(recording).replace(f'"{who}"', f'"{name}"'))


def test_figures_name_their_owner_if_names_differ(open_page, recording, other):
    viewer = open_page(replay.render(recording, renamed(other, "operator", "ada")))
    viewer.seek(31.5)
    pairs = viewer.page.locator(".readout .pair")
    assert pairs.nth(0).is_hidden()
    assert pairs.nth(1).inner_text() == "ada – gantry"
    hint = viewer.page.locator("#hint")
    viewer.page.locator("#chart").hover()
    assert "\nB ada – gantry:\ndistance" in hint.inner_text()
    viewer.page.locator("#watch").select_option(label="visitor – agv2")
    viewer.settle()
    assert pairs.nth(1).is_hidden()
    assert len(viewer.page.locator("[data-shows=distance]:visible").all()) == 2
    assert viewer.complaints == []


def test_there_are_no_figures_if_the_other_run_has_no_such_pair(open_page, recording, other):
    alone = copy.deepcopy(other)
    alone["watches"] = [watch for watch in alone["watches"] if watch["other"] == "gantry"]
    viewer = open_page(replay.render(recording, alone))
    viewer.page.locator("#watch").select_option(label="visitor – agv2")
    viewer.settle()
    shown = viewer.page.locator(".readout").nth(1)
    assert shown.locator(".pair").inner_text() == "no such pair"
    assert shown.locator("[data-shows=distance]").is_hidden()
    assert shown.locator("[data-shows=state]").is_hidden()
    viewer.page.locator("#watch").select_option("0")
    viewer.settle()
    assert shown.locator(".pair").is_hidden()
    assert shown.locator("[data-shows=distance]").is_visible()
    assert viewer.complaints == []


def test_the_comparison_can_be_ended(compared):
    compared.page.locator("#stop-comparing").click()
    compared.settle()
    assert compared.page.locator(".view").count() == 1
    assert len(distances(compared)) == 1
    assert compared.page.locator("#focus").is_hidden()
    compared.page.keyboard.press("End")
    assert compared.time == 275.0


DROP = """
text => {
  const data = new DataTransfer();
  data.items.add(new File([text], "dropped.json"));
  for (const type of ["dragover", "drop"]) {
    const event = new DragEvent(type, { dataTransfer: data, bubbles: true, cancelable: true });
    document.getElementById("stage").dispatchEvent(event);
  }
}
"""


def test_a_recording_can_be_dropped_on_the_page(open_page, recording, other):
    viewer = open_page(replay.render(recording))
    viewer.page.evaluate(DROP, json.dumps(other))
    viewer.wait_until(lambda: viewer.page.locator(".view").count() == 2)
    assert viewer.text("#title") == f"A: {recording['title']}; B: {other['title']}"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "cut off or damaged"),
        ('{"format": "floorwalker-replay/1"}', "floorplan: missing"),
        ("<!DOCTYPE html><p>Hello", "this is not a replay page"),
        ("\x00\x01", "cut off or damaged"),
    ],
)
def test_unreadable_files_are_reported_and_the_page_stays(open_page, recording, text, message):
    viewer = open_page(replay.render(recording))
    viewer.page.evaluate(DROP, text)
    dialog = viewer.page.locator("#drop-trouble")
    viewer.wait_until(dialog.is_visible)
    assert "dropped.json can't be shown" in dialog.inner_text()
    assert message in dialog.inner_text()
    viewer.page.keyboard.press("Escape")
    viewer.wait_until(dialog.is_hidden)  # until then the dialog receives the keys
    assert viewer.page.locator(".view").count() == 1

    def at_the_end():
        viewer.page.keyboard.press("End")
        return viewer.time == 275.0

    viewer.wait_until(at_the_end)
    assert viewer.complaints == []
