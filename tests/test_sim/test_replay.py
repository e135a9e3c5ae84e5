"""The replay page in a real browser, if there is one."""

import copy
import itertools
import json
import math
import re

import pytest
import replay_sample
from replay_sample import distinguished, replay, replay_data, rounded

import sim

INSTANTS = [0.0, 2.4, 9.93, 27.0, 61.7, 69.1, 140.25, 181.0, 274.9, 275.0]


@pytest.fixture(scope="module")
def recording():
    return replay_sample.recording()


@pytest.fixture(scope="module")
def shared(open_shared_page, recording):
    return open_shared_page(replay.render(recording))


@pytest.fixture
def viewer(shared):
    """The sample at its beginning."""
    shared.page.evaluate("window.floorwalker.pause()")
    shared.page.locator("#speed").select_option("1")
    shared.page.locator("#watch").select_option("0")
    shared.page.evaluate("document.activeElement.blur()")
    shared.seek(0.0)
    return shared


def embedded(html):
    [text] = re.findall(
        r'<script type="application/json" id="recording">(.*?)</script>', html, re.S
    )
    return json.loads(text)


# ── the page as text ──


def test_the_page_contains_the_recording_unchanged(recording):
    assert embedded(replay.render(recording)) == json.loads(json.dumps(recording))


def test_names_cannot_break_out_of_the_page(recording):
    hostile = copy.deepcopy(recording)
    hostile["title"] = "</title><script>alert(1)</script> {{recording}} {{title}}"
    hostile["floorplan"]["stations"][0]["name"] = "</script><!--<script>"
    html = replay.render(hostile)
    assert embedded(html) == json.loads(json.dumps(hostile))
    assert "<script>alert" not in html
    assert html.count("</script>") == replay.render(recording).count("</script>")


def test_a_long_run_makes_a_small_page(recording):
    assert recording["duration"] == 275.0
    assert len(replay.render(recording).encode()) < 1_000_000


def test_the_page_needs_no_network(recording):
    assert not re.search(r"https?:|\bimport\b|\bfetch\b|url\(", replay.render(recording))


@pytest.mark.slow
def test_a_long_recording_is_packed(recording, open_page, monkeypatch):
    thoughts = [{"t": k / 2, "believes": [f"seen({k})"], "steps": []} for k in range(300)]
    recording = rounded({**recording, "minds": {"operator": thoughts, "visitor": thoughts[:9]}})
    recording["motions"] = {
        name: [[begin, end, *map(replay.without_zeros, axes)] for begin, end, *axes in pieces]
        for name, pieces in recording["motions"].items()
    }
    monkeypatch.setattr(replay, "PACKED_FROM", 1000)
    html = replay.render(recording, recording)
    monkeypatch.undo()
    assert len(html) < len(replay.render(recording))
    assert replay.recordings_in(html) == [json.loads(json.dumps(recording))] * 2
    viewer = open_page(html)
    viewer.wait_until(lambda: viewer.page.evaluate("'floorwalker' in window"))
    viewer.seek(61.7)
    pair = [viewer.page.locator("[data-shows=distance]").nth(k).inner_text() for k in range(2)]
    assert pair[0] == pair[1] != ""
    assert viewer.page.evaluate("floorwalker.recording") == json.loads(json.dumps(recording))
    whole = json.loads(json.dumps(recording))
    monkeypatch.setattr(replay, "PACKED_FROM", 1000)
    html = replay.render(recording)
    first, motions, rest = (
        html.index(f'id="recording{part}"') for part in ("", "-motions", "-rest")
    )
    early, amid = first + 300, (motions + rest) // 2
    late = (rest + len(html)) // 2
    for damaged in (html[:early], html[:early] + "?" + html[early + 1 :]):
        trouble = open_page(damaged)
        trouble.wait_until(lambda page=trouble.page: page.locator("#trouble").is_visible())
        assert "cut off or damaged" in trouble.text("#trouble")
    shown = []
    damages = [html[:place] for place in (motions, amid, late)]
    for damaged in (*damages, html[:late] + "?" + html[late + 1 :]):
        part = open_page(damaged)
        assert "cut off or damaged; this is what there is" in part.text("#notice")
        unpacked = part.page.evaluate("floorwalker.recording")
        for name in ("events", "watches"):
            assert unpacked[name] == whole[name][: len(unpacked[name])]
        for kind in ("motions", "minds"):
            for name, things in unpacked[kind].items():
                assert things == whole[kind][name][: len(things)]
        shown.append(len(unpacked["bodies"]) + len(unpacked["events"]))
        assert part.complaints == []
    assert shown == sorted(shown)
    assert (shown[0], shown[-1]) == (0, len(whole["bodies"]) + len(unpacked["events"]))
    with pytest.raises(ValueError, match="damaged"):
        replay.recordings_in(html[:late] + "?" + html[late + 1 :])


@pytest.mark.parametrize("form", [None, "floorwalker-replay/2"])
def test_another_format_is_rejected(recording, form):
    with pytest.raises(ValueError, match="floorwalker-replay/1"):
        replay.render({**recording, "format": form})


@pytest.mark.parametrize("value", [math.nan, math.inf, {1, 2}])
def test_values_that_json_lacks_are_rejected(recording, value):
    with pytest.raises(ValueError, match="cannot be written as JSON"):
        replay.render({**recording, "summary": {"penalties": value}})


# ── the page at work ──


def test_the_page_loads_without_errors_or_requests(viewer):
    assert viewer.page.locator("#cut-off").count() == 0
    assert viewer.text("#title") == "ariac2023 · sample"
    assert viewer.page.title() == "ariac2023 · sample – Floorwalker replay"
    assert viewer.complaints == []
    assert [url for url in viewer.requests if not url.startswith(("file:", "data:"))] == []


def test_poses_equal_the_motions(viewer, recording):
    for name, pieces in recording["motions"].items():
        for t in [*INSTANTS, *(piece[0] for piece in pieces[:: len(pieces) // 12 + 1])]:
            shown = viewer.page.evaluate(
                "([name, t]) => Object.values(window.floorwalker.pose(name, t))", [name, t]
            )
            assert shown[:5] == pytest.approx(replay_sample.pose(pieces, t), abs=1e-9), (name, t)


def test_the_instant_before_a_change_shows_the_earlier_motion(viewer, recording):
    for name in ("operator", "gantry", "agv1"):
        pieces = recording["motions"][name]
        shown = viewer.page.evaluate(
            """name => {
                const pieces = window.floorwalker.recording.motions[name];
                const motion = new Motion(pieces);
                return pieces.map(piece => Object.values(motion.before(piece[1])).slice(0, 5));
            }""",
            name,
        )
        for piece, state in zip(pieces, shown, strict=True):
            assert state == pytest.approx(replay_sample.before([piece], piece[1]), abs=1e-9)


def test_the_path_ahead_ends_where_the_person_next_stops(viewer, recording):
    events = [e for e in recording["events"] if e.get("person") == "operator"]
    for goal, arrived in itertools.pairwise(events):
        if (goal["kind"], arrived["kind"]) != ("goal", "arrived"):
            continue
        middle = (goal["t"] + arrived["t"]) / 2
        [first, *_, last] = viewer.page.evaluate(
            "([pieces, t]) => new Track(new Motion(pieces)).ahead(t)",
            [recording["motions"]["operator"], middle],
        )
        assert last == pytest.approx(list(goal["at"]), abs=1e-6)
        here = replay_sample.pose(recording["motions"]["operator"], middle)
        assert first == pytest.approx(here[:2], abs=1e-9)


def test_dashes_of_the_path_ahead_lie_still_until_the_person_is_on_them(viewer, recording):
    goal = next(e for e in recording["events"] if e["kind"] == "goal")
    shown, fresh = viewer.page.evaluate(
        """([pieces, from, to]) => {
            const motion = new Motion(pieces);
            const person = { motion, track: new Track(motion) };
            const rows = copies => Array.from({ length: copies.count }, (_, i) => (
                [...copies.numbers.subarray(16 * i, 16 * i + 16)]));
            const at = (t, person) => {
                const pile = new Pile();
                addPathAhead(pile, person, t, 0.02, [1, 0, 0]);
                return rows(pile.of("square", "glow"));
            };
            const instants = Array.from({ length: 40 }, (_, k) => from + (to - from) * k / 40);
            const afresh = t => dashesOf(new Track(motion).ahead(t).reverse())
                .map(({ from, to }) => stripFrom(from, to, 0.02, DASH_WIDTH));
            return [instants.map(t => at(t, person)), instants.map(afresh)];
        }""",
        [recording["motions"][goal["person"]], goal["t"], goal["t"] + 8.0],
    )
    assert sum(map(len, shown)) > 100
    for drawn, expected in zip(shown, fresh, strict=True):
        # Shorter dashes are rounding.
        middles = [row[12:15] for row in drawn if math.hypot(row[0], row[1]) > 1e-4]
        assert middles == [
            pytest.approx(row[9:12], abs=1e-4) for row in expected if math.hypot(*row[:2]) > 1e-4
        ]


def test_a_stop_without_a_pause_ends_the_path_ahead(viewer):
    there_and_back = [[0, 1, [0, 2, -1], [0], [0]], [1, 2, [1, 0, -1], [0], [3]]]
    ahead = viewer.page.evaluate("p => new Track(new Motion(p)).ahead(0.5)", there_and_back)
    assert ahead[-1] == pytest.approx([1.0, 0.0])


def test_separations_equal_the_motions(viewer, recording):
    motions = recording["motions"]
    for k, watch in enumerate(recording["watches"]):
        for t in INSTANTS:
            shown = viewer.page.evaluate("([k, t]) => window.floorwalker.separation(k, t)", [k, t])
            distance, required = replay_sample.separation(
                motions[watch["person"]], motions[watch["other"]], watch["law"], t
            )
            assert shown["distance"] == pytest.approx(distance, abs=1e-9)
            assert shown["required"] == pytest.approx(required, abs=1e-9)
            assert shown["margin"] == pytest.approx(distance - required, abs=1e-9)
            within = any(begin <= t < end for begin, end in watch["violations"])
            assert shown["violated"] is within


@pytest.mark.parametrize("t", INSTANTS)
def test_the_numbers_shown_are_those_of_the_current_time(viewer, recording, t):
    motions = recording["motions"]
    viewer.seek(t)
    distance, required = replay_sample.separation(
        motions["operator"], motions["gantry"], replay_sample.LAW, t
    )
    assert viewer.number("[data-shows=time]") == pytest.approx(t, abs=0.00501)
    assert viewer.number("[data-shows=distance]") == pytest.approx(distance, abs=0.00501)
    assert viewer.number("[data-shows=required]") == pytest.approx(required, abs=0.00501)
    assert viewer.number("[data-shows=margin]") == pytest.approx(distance - required, abs=0.00501)
    for name, field in (
        ("operator", "[data-shows=person-speed]"),
        ("gantry", "[data-shows=other-speed]"),
    ):
        *_, vx, vy = replay_sample.pose(motions[name], t)
        assert viewer.number(field) == pytest.approx(math.hypot(vx, vy), abs=0.00501)


def test_another_watch_can_be_chosen(viewer, recording):
    names = viewer.page.locator("#watch option").all_inner_texts()
    machines = [f"{w['person']} – {w['other']}" for w in recording["watches"]]
    assert names == [*machines, "operator – visitor"]
    motions = recording["motions"]
    viewer.seek(101.0)
    viewer.page.locator("#watch").select_option(label="visitor – agv2")
    viewer.settle()
    distance, _ = replay_sample.separation(
        motions["visitor"], motions["agv2"], {"distance": 2.1}, 101.0
    )
    assert viewer.number("[data-shows=distance]") == pytest.approx(distance, abs=0.00501)
    assert viewer.text("[data-shows=required]") == "2.10 m"


def test_the_pair_of_the_least_margin_is_shown_first(open_page, recording):
    for person, machine in (("operator", "agv2"), ("operator", "gantry")):
        changed = copy.deepcopy(recording)
        changed["summary"]["least_margin"] = {"person": person, "machine": machine}
        viewer = open_page(replay.render(changed))
        assert viewer.page.locator("#watch option:checked").inner_text() == f"{person} – {machine}"


def test_a_page_without_width_has_no_errors(open_page, recording, tmp_path):
    (tmp_path / "replay.html").write_text(replay.render(recording), encoding="utf-8")
    address = (tmp_path / "replay.html").as_uri()
    frames = (f'<iframe src="{address}" style="width: {width}px"></iframe>' for width in (0, 60))
    viewer = open_page("<!DOCTYPE html><title>frames</title>" + "".join(frames))
    viewer.page.wait_for_load_state("networkidle")
    viewer.settle()
    assert viewer.complaints == []


def test_two_people_have_a_gap_and_no_required_distance(viewer, recording):
    viewer.seek(101.0)
    viewer.page.locator("#watch").select_option(label="operator – visitor")
    viewer.settle()
    at = [replay_sample.pose(recording["motions"][name], 101.0) for name in ("operator", "visitor")]
    distance = math.dist(at[0][:2], at[1][:2])
    assert viewer.number("[data-shows=distance]") == pytest.approx(distance, abs=0.00501)
    assert viewer.number("[data-shows=margin]") == pytest.approx(distance - 0.6, abs=0.00501)
    assert viewer.text("[data-shows=margin-word]") == "gap"
    assert viewer.text("[data-shows=state]") == "apart"
    assert "required" not in viewer.text("#legend")


CROWD = """
floorplan: {boundary: [[0, 0], [30, 0], [30, 4], [0, 4]]}
duration: 60
people: [{name: GUEST, source: {at: [1, 2], rate: 0.5, count: 4}, sink: [29, 2]}]
""".replace("GUEST", "guest" * 6)


def test_people_with_long_names_may_enter_and_leave(open_page):
    run = sim.run(sim.Trial.parse(CROWD, file="crowd.yaml"))
    viewer = open_page(replay.render(rounded(replay_data(run))))
    assert viewer.page.locator("#compare").bounding_box()["x"] < 1280
    assert viewer.page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    one, other = sorted(run.presence)[:2]
    entered = max(run.presence[name][0] for name in (one, other))
    for t, state in ((entered - 0.1, "not both on the floor"), (entered + 1, "apart")):
        viewer.seek(t)
        viewer.page.locator("#watch").select_option(label=f"{one} – {other}")
        viewer.settle()
        assert viewer.text("[data-shows=state]") == state
    assert viewer.complaints == []


def spread(distance):
    """Return the density (1/m²) of a person at this distance (m): a Gaussian, 1 m wide at half
    height.
    """
    sigma = 1.0 / (2.0 * math.sqrt(2.0 * math.log(2.0)))
    return math.exp(-(distance**2) / (2.0 * sigma**2)) / (2.0 * math.pi * sigma**2)


def test_density_and_speed_are_gaussian_profiles_of_people(viewer, recording):
    tracks = [recording["motions"][name] for name in ("operator", "visitor")]

    def expected(times, x, y):
        density = flow = 0.0
        for pieces, t in itertools.product(tracks, times):
            px, py, _, vx, vy = replay_sample.pose(pieces, t)
            share = spread(math.hypot(x - px, y - py)) / len(times)
            density, flow = density + share, flow + share * math.hypot(vx, vy)
        return density, flow / density

    def found(kind, t, x, y):
        return viewer.page.evaluate("a => floorwalker.field(...a)", [kind, t, x, y])

    def agree(prefix, times, t, x, y):
        cells = [found(prefix + kind, t, x, y) for kind in ("density", "speed")]
        want = expected(times, cells[0]["x"], cells[0]["y"])
        assert math.dist((x, y), (cells[0]["x"], cells[0]["y"])) < 0.15
        assert [cell["value"] for cell in cells] == pytest.approx(want, rel=1e-3, abs=1e-4)

    for t in (9.93, 61.7, 140.25):
        x, y, *_ = replay_sample.pose(tracks[0], t)
        for dx, dy in ((0.0, 0.0), (0.4, -0.3), (-0.8, 0.1)):
            agree("", [t], t, x + dx, y + dy)
    whole = [(k + 0.5) / 2750 * 275.0 for k in range(2750)]
    agree("run-", whole, 0.0, -10.8, -3.0)
    viewer.page.locator("#field").select_option("density")
    viewer.settle()
    words = viewer.text("#field-scale").split()
    assert words[:3] == ["density,", "1/m²", "0"]
    assert float(words[-1]) >= spread(0.0)
    viewer.page.locator("#field").select_option("")
    viewer.settle()
    assert viewer.page.locator("#field-scale").is_hidden()


VEHICLES_ALONE = """
floorplan: warehouse
duration: 40
people: []
machines:
  fork1: {kind: amr, at: [8.5, 2.0, 0.0], missions: [{go: dock}]}
  fork2: {kind: amr, at: [8.5, 18.0, 0.0], missions: [{wait: 3}, {go: packing}, {wait: 30}]}
"""


@pytest.mark.slow
def test_without_people_the_plot_shows_speeds_and_jobs_of_machines(open_page):
    alone = replay_data(sim.run(sim.Trial.parse(VEHICLES_ALONE)))
    viewer = open_page(replay.render(alone))
    assert viewer.text("#legend") == "speed of machines"
    viewer.seek(1.0)
    assert viewer.text("[data-shows=job]").endswith("since 0.00 s")
    viewer.seek(4.0)
    assert viewer.text("[data-shows=job-of]") == "job of fork2"
    assert viewer.text("[data-shows=job]") == "go to packing, since 3.00 s"
    plot = viewer.page.locator("#chart canvas").screenshot()
    for name in ("fork1", "fork2"):
        alone["motions"][name] = [
            [p[0], p[1], *(c[:1] for c in p[2:])] for p in alone["motions"][name]
        ]
    still = open_page(replay.render(alone))
    still.seek(4.0)
    assert still.differ(plot, still.page.locator("#chart canvas").screenshot())
    assert viewer.complaints == []


@pytest.mark.slow
def test_without_machines_the_plot_shows_speeds(open_page, recording):
    alone = copy.deepcopy(recording)
    alone["bodies"] = [body for body in alone["bodies"] if body["name"] == "operator"]
    alone["watches"] = []
    viewer = open_page(replay.render(alone))
    assert viewer.text("#legend") == "speed of people"
    plot = viewer.page.locator("#chart canvas").screenshot()
    for piece in alone["motions"]["operator"]:
        piece[2], piece[3] = piece[2][:1], piece[3][:1]
    still = open_page(replay.render(alone))
    assert still.differ(plot, still.page.locator("#chart canvas").screenshot())
    assert viewer.complaints == still.complaints == []


def test_the_summary_has_units_and_names(open_page, recording):
    trial = "{floorplan: ariac2023, duration: 20, people: [{name: crew, count: 2, at: anywhere}]}"
    summary = rounded(sim.run(sim.Trial.parse(trial)).summary)
    page = open_page(replay.render({**recording, "summary": summary})).page
    terms = "[...document.querySelectorAll('.summary dt')]"
    shown = dict(
        page.evaluate(f"{terms}.map(dt => [dt.textContent, dt.nextElementSibling.textContent])")
    )
    assert shown["stopping underestimated for"] == "gantry, agv1, agv2, agv3, agv4"
    assert shown["gantry idle time"] == f"{summary['gantry_idle_time']:g} s"
    assert shown["time lost to others"].endswith(" s")
    assert "(crew1 and crew2)" in shown["nearest people"]


def test_the_noticing_distance_has_its_own_law_and_cap(open_page, recording):
    strict = copy.deepcopy(recording)
    strict["watches"][0] |= {
        "notice": 1.75,
        "notice_cap": 3.0,
        "notice_law": {**replay_sample.LAW, "intrusion": 1.2},
    }
    viewer = open_page(replay.render(strict))
    notice = [
        viewer.page.evaluate("t => window.floorwalker.separation(0, t).notice", t)
        for t in (0.0, 5.0)
    ]
    assert notice == pytest.approx([1.75 * 1.2, 1.75 * 3.0])
    assert viewer.page.evaluate("window.floorwalker.separation(1, 0).notice") is None


def test_the_page_plays_and_pauses(viewer):
    viewer.page.locator("#play").click()
    viewer.wait_until(lambda: viewer.time > 0.2)
    viewer.page.locator("#play").click()
    assert viewer.stands()


def test_the_page_plays_faster_and_stops_at_the_end(viewer):
    viewer.seek(272.0)
    viewer.page.locator("#speed").select_option("64")
    viewer.page.locator("#play").click()
    viewer.wait_until(lambda: viewer.time == 275.0)
    viewer.settle()
    assert viewer.page.locator("#play").get_attribute("aria-label") == "Play"
    viewer.page.locator("#speed").select_option("1")
    viewer.page.locator("#play").click()
    viewer.wait_until(lambda: viewer.time < 200.0)


def test_the_keys_work(viewer):
    press = viewer.page.keyboard.press
    for key, t in (
        ("ArrowRight", 1.0),
        ("Shift+ArrowRight", 11.0),
        ("ArrowLeft", 10.0),
        ("Shift+ArrowLeft", 0.0),
        ("End", 275.0),
        ("ArrowRight", 275.0),
        ("Home", 0.0),
    ):
        press(key)
        assert viewer.time == t, key
    press("+")
    press("+")
    press("-")
    viewer.settle()
    assert viewer.page.locator("#speed").input_value() == "2"
    press("Space")
    viewer.wait_until(lambda: viewer.time > 0.0)
    press("Space")
    assert viewer.stands()
    press("?")
    assert viewer.page.locator("#help").is_visible()
    press("Escape")
    assert viewer.page.locator("#help").is_hidden()


def test_space_plays_after_a_click_on_a_button(viewer):
    viewer.page.locator(".events li button").nth(3).click()
    begun = viewer.time
    viewer.page.keyboard.press("Space")
    viewer.wait_until(lambda: viewer.time > begun)


def test_n_and_p_go_from_event_to_event(viewer, recording):
    times = sorted({event["t"] for event in recording["events"]})
    for t in times[1:9]:
        viewer.page.keyboard.press("n")
        assert viewer.time == t
    for t in reversed(times[:8]):
        viewer.page.keyboard.press("p")
        assert viewer.time == t


def test_the_mouse_scrubs(viewer):
    box = viewer.page.locator("#chart").bounding_box()
    x = {share: box["x"] + 52 + share * (box["width"] - 64) for share in (0.25, 0.5, 0.75)}
    y = box["y"] + 30
    viewer.page.mouse.click(x[0.5], y)
    assert viewer.time == pytest.approx(137.5, abs=0.5)
    viewer.page.mouse.move(x[0.25], y)
    viewer.page.mouse.down()
    viewer.page.mouse.move(x[0.75], y, steps=4)
    assert viewer.time == pytest.approx(0.75 * 275, abs=0.5)
    viewer.page.mouse.up()
    viewer.page.mouse.move(x[0.25], y)
    assert viewer.time == pytest.approx(0.75 * 275, abs=0.5)


def test_the_wheel_zooms_the_time(viewer):
    box = viewer.page.locator("#chart").bounding_box()
    left, width, y = box["x"] + 52, box["width"] - 64, box["y"] + 30
    viewer.page.mouse.move(left + width / 2, y)
    for _ in range(4):
        viewer.page.mouse.wheel(0, -300)
    viewer.settle()
    span = 275 * math.exp(-4 * 300 * 0.0015)
    for share in (0.1, 0.5, 0.9):
        viewer.page.mouse.click(left + share * width, y)
        assert viewer.time == pytest.approx(137.5 + (share - 0.5) * span, abs=0.1)
    viewer.seek(270.0)  # the time shown follows the zoom
    cursor = viewer.page.locator("#cursor").bounding_box()
    assert left <= cursor["x"] <= left + width
    viewer.page.mouse.dblclick(left + width / 2, y)
    viewer.settle()
    viewer.page.mouse.click(left + width / 4, y)
    assert viewer.time == pytest.approx(275 / 4, abs=0.5)
    assert viewer.complaints == []


def test_a_mark_on_the_timeline_jumps_to_its_exact_time(viewer, recording):
    [moved] = [e["t"] for e in recording["events"] if e.get("agv") == "agv2"]
    box = viewer.page.locator("#chart").bounding_box()
    x = box["x"] + 52 + moved / 275 * (box["width"] - 64) + 2
    y = box["y"] + box["height"] - 16 - 1.5 * 17
    viewer.page.mouse.move(x, y)
    viewer.page.mouse.down()
    viewer.page.mouse.move(x + 2, y)  # a click usually includes a small movement
    viewer.page.mouse.up()
    assert viewer.time == moved


def test_the_list_shows_every_event_and_jumps(viewer, recording):
    items = viewer.page.locator(".events li")
    assert items.count() == len(recording["events"])
    times = [float(text) for text in viewer.page.locator(".events time").all_inner_texts()]
    assert times == [pytest.approx(event["t"], abs=0.00501) for event in recording["events"]]
    index = next(i for i, e in enumerate(recording["events"]) if e["kind"] == "job_done")
    items.nth(index).locator("button").click()
    viewer.settle()
    assert viewer.time == recording["events"][index]["t"]
    current = viewer.page.locator(".events li[aria-current]")
    assert current.count() == 1
    assert "blue battery" in current.inner_text()


def lengthened(recording, times):
    """Return the recording, repeated `times` times in a row."""
    long = copy.deepcopy(recording)
    period = recording["duration"]
    long["duration"] = times * period
    for name, pieces in recording["motions"].items():
        long["motions"][name] = [
            [min(begin, period) + k * period, min(end, period) + k * period, *axes]
            for k in range(times)
            for begin, end, *axes in pieces
            if begin < period
        ]
    long["events"] = [
        {**event, "t": event["t"] + k * period}
        for k in range(times)
        for event in recording["events"]
    ]
    return long


@pytest.mark.slow
def test_a_shift_of_eight_hours_is_shown_in_parts(open_page, recording):
    viewer = open_page(replay.render(lengthened(recording, 105)))
    events = viewer.page.evaluate("window.floorwalker.recording.events")
    assert viewer.text("#clock-end") == "/ 8:01:15"
    for t in (20_000.0, 28_874.0, 310.0):
        viewer.seek(t)
        before = [event for event in events if event["t"] <= t + 1e-9]
        items = viewer.page.locator(".events li")
        assert items.count() < 1000 < len(events)
        current = viewer.page.locator(".events li[aria-current] time").inner_text()
        hours, minutes, rest = (["0"] * 2 + current.split(":"))[-3:]
        shown = 3600 * int(hours) + 60 * int(minutes) + float(rest)
        assert shown == pytest.approx(before[-1]["t"], abs=0.00501)
    first = viewer.page.locator(".events li time").first
    viewer.page.evaluate("""async () => {
        const list = document.querySelector(".events ol");
        for (let k = 0; k < 4; k++) {
            list.scrollTop = list.scrollHeight;
            await new Promise(done => requestAnimationFrame(() => setTimeout(done)));
        }
    }""")
    assert ":" in first.inner_text()  # the list scrolled on to later events
    assert viewer.complaints == []


def test_every_kind_of_event_has_a_mark_and_words(viewer, event_kinds):
    for table in ("LOOKS", "WORDS"):
        assert set(viewer.page.evaluate(f"Object.keys({table})")) >= set(event_kinds)


def test_every_kind_of_event_has_a_visible_mark(viewer):
    """Marks of the timeline and the list are 12 pixels wide, so they cover about 144 pixels at
    most.
    """
    marks = viewer.page.evaluate("""() => Object.entries(LOOKS).map(([kind, look]) => {
        const canvas = document.createElement("canvas");
        [canvas.width, canvas.height] = [24, 24];
        const context = canvas.getContext("2d");
        drawGlyph(context, look, 12, 12, { halo: "#ffffff", [look.color]: "#000000" });
        const { data } = context.getImageData(0, 0, 24, 24);
        const dark = data.filter((value, k) => k % 4 === 3 && value > 128 && data[k - 1] < 128);

        const svg = glyphElement(look);
        document.body.append(svg);
        const path = svg.firstElementChild;
        let inside = 0;
        for (let x = -6; x <= 6; x++) for (let y = -6; y <= 6; y++) {
            const at = new DOMPoint(x, y);
            const filled = path.getAttribute("fill") !== "none" && path.isPointInFill(at);
            inside += filled || path.hasAttribute("stroke") && path.isPointInStroke(at);
        }
        svg.remove();
        return [kind, dark.length, inside];
    })""")
    assert [kind for kind, dark, inside in marks if dark < 16 or inside < 12] == []


def test_the_current_event_stays_in_view(viewer):
    viewer.page.mouse.move(10, 10)
    viewer.seek(200.0)
    assert viewer.page.evaluate(
        """() => {
            const list = document.querySelector(".events ol").getBoundingClientRect();
            const item = document.querySelector(".events [aria-current]").getBoundingClientRect();
            return list.top <= item.top && item.bottom <= list.bottom && window.scrollY === 0;
        }"""
    )


def test_a_violation_is_described_in_words(viewer, recording):
    violation = next(e for e in recording["events"] if e["kind"] == "violation")
    viewer.seek(violation["t"])
    figures = " of ".join(distinguished(violation["distance"], violation["required"])) + " m"
    state = viewer.text("[data-shows=state]")
    assert state == f"violation at {violation['t']:.2f} s, too close: {figures}"
    viewer.seek(69.1)
    assert viewer.text("[data-shows=state]") == "too close: violation"
    viewer.seek(0.0)
    assert viewer.text("[data-shows=state]") == "enough distance"


@pytest.mark.parametrize(
    ("distance", "required", "shown"),
    [
        (2.31, 3.5, ("2.31", "3.50")),
        (3.4957, 3.5, ("3.496", "3.500")),
        (3.503, 3.5, ("3.503", "3.500")),
        (3.49999998, 3.5, ("just under 3.50", "3.50")),
        (3.5, 3.5, ("3.50", "3.50")),
    ],
)
def test_a_distance_that_is_too_short_looks_shorter(viewer, distance, required, shown):
    texts = viewer.page.evaluate("([d, r]) => toldApart(d, r)", [distance, required])
    assert (texts["distance"], texts["required"]) == distinguished(distance, required) == shown


def test_the_floor_is_drawn_from_the_time_shown(viewer):
    floor = viewer.page.locator(".view canvas.flat")
    early = floor.screenshot()
    viewer.seek(66.0)
    late = floor.screenshot()
    viewer.seek(0.0)
    assert viewer.differ(early, late)
    assert not viewer.differ(early, floor.screenshot())


def test_the_floor_zooms_pans_and_fits(viewer):
    floor = viewer.page.locator(".view canvas.flat")
    whole = floor.screenshot()
    floor.hover()
    viewer.page.mouse.wheel(0, -400)
    viewer.settle()
    zoomed = floor.screenshot()
    assert viewer.differ(whole, zoomed)
    viewer.page.mouse.down()
    viewer.page.mouse.move(300, 300, steps=3)
    viewer.page.mouse.up()
    viewer.settle()
    assert viewer.differ(zoomed, floor.screenshot())
    viewer.page.keyboard.press("0")
    viewer.page.mouse.move(5, 5)
    viewer.settle()
    assert not viewer.differ(whole, floor.screenshot())


def test_a_body_can_be_followed(viewer):
    viewer.page.locator("#follow").select_option("agv1")
    viewer.seek(70.0)
    before = viewer.page.locator(".view canvas.flat").screenshot()
    viewer.seek(77.0)
    assert viewer.differ(before, viewer.page.locator(".view canvas.flat").screenshot())
    viewer.page.locator("#fit").click()
    assert viewer.page.locator("#follow").input_value() == ""


def test_the_object_under_the_pointer_is_named(viewer):
    box = viewer.page.locator(".view canvas.flat").bounding_box()
    viewer.page.locator("#follow").select_option("agv3")
    viewer.settle()
    viewer.page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    assert viewer.text("#hint").startswith("agv3\n(−2.27, −1.20), 0.00 m/s")
    viewer.page.locator("#fit").click()


def test_light_and_dark(open_page, recording):
    html = replay.render(recording)
    viewer = open_page(html, color_scheme="dark")
    theme = viewer.page.locator("html")
    assert theme.get_attribute("data-theme") == "dark"
    viewer.page.emulate_media(color_scheme="light")
    viewer.wait_until(lambda: theme.get_attribute("data-theme") == "light")
    viewer.page.locator("#theme").click()
    assert theme.get_attribute("data-theme") == "dark"


def test_the_page_fits_on_a_phone(open_page, recording):
    viewer = open_page(
        replay.render(recording), viewport={"width": 390, "height": 844}, has_touch=True
    )
    assert viewer.page.evaluate("document.documentElement.scrollWidth") <= 390
    viewer.page.locator("#play").tap()
    viewer.wait_until(lambda: viewer.time > 0.0)
    box = viewer.page.locator("#chart").bounding_box()
    viewer.page.locator("#play").tap()
    viewer.page.touchscreen.tap(box["x"] + 52 + 0.5 * (box["width"] - 64), box["y"] + 40)
    assert viewer.time == pytest.approx(137.5, abs=1.5)
    assert viewer.complaints == []


LISTEN_TO_WORDS = """
() => {
  const plain = drawText;
  window.words = [];
  window.drawText = (context, text, x, y, look) => {
    const { size = 11, weight = 400, align } = look;
    const wide = textWidth(context, text, { size, weight });
    const inChart = context.canvas.closest("#chart") !== null;
    if (!inChart && align !== "left") {
      window.words.push([text, x - wide / 2, x + wide / 2, y - size / 2, y + size / 2]);
    }
    plain(context, text, x, y, look);
  };
}
"""


@pytest.mark.slow
@pytest.mark.parametrize("width", [390, 500, 1400])
def test_words_on_the_floor_are_whole_and_cover_no_station(open_page, recording, width):
    viewer = open_page(replay.render(recording), viewport={"width": width, "height": 900})
    viewer.settle()
    viewer.page.evaluate(LISTEN_TO_WORDS)
    viewer.page.locator("#theme").click()  # this redraws the floor
    viewer.settle()
    box = viewer.page.locator(".view canvas.flat").bounding_box()
    stations = {station["name"] for station in recording["floorplan"]["stations"]}
    places = [word for word in viewer.page.evaluate("window.words") if word[0] in stations]
    assert {name for name, *_ in places} == stations
    for t in (0.0, 20.0, 31.5, 61.7, 66.0, 69.1, 88.25, 140.0, 181.0, 250.0):
        viewer.page.evaluate("window.words.length = 0")
        viewer.seek(t)
        for text, left, right, top, bottom in viewer.page.evaluate("window.words"):
            if text in stations:
                continue
            assert left >= 0 and right <= box["width"], (t, text)
            if not text.endswith(" m"):
                continue
            for name, *place in places:
                across = min(right, place[1]) - max(left, place[0])
                down = min(bottom, place[3]) - max(top, place[2])
                assert across <= 0 or down <= 0, (t, text, name)


LISTEN_TO_PLATES = """
() => {
  const plain = drawPlate;
  window.plates = [];
  window.colours = [];
  window.drawPlate = (context, text, x, y, ...how) => {
    const [palette, color] = how;
    window.colours.push(palette.card, palette[color]);
    const half = plateWidth(context, text) / 2;
    window.plates.push([text, x - half, x + half, y - 10, y + 10]);
    plain(context, text, x, y, ...how);
  };
}
"""


def listening_to_plates(open_page, trial: str, space: bool):
    """Return the page of a trial at 3 s, from above or in space, with its plates recorded."""
    viewer = open_page(replay.render(rounded(replay_data(sim.run(sim.Trial.parse(trial))))))
    if space:
        viewer.page.keyboard.press("3")
    viewer.settle()
    viewer.page.evaluate(LISTEN_TO_PLATES)
    viewer.seek(3.0)
    viewer.settle()
    return viewer


@pytest.mark.parametrize("space", [False, True])
def test_a_distance_has_a_plate_in_the_colours_of_the_page(open_page, space):
    pair = "{floorplan: ariac2023, duration: 4, people: [{name: a}, {name: b, at: [-5, -3]}]}"
    viewer = listening_to_plates(open_page, pair, space)
    colours = viewer.page.evaluate("window.colours")
    assert colours and all(colours)


@pytest.mark.parametrize("space", [False, True])
def test_distances_of_a_crowd_do_not_cover_each_other(open_page, space):
    crowd = (
        "{floorplan: ariac2023, duration: 4, seed: 7, rules: observe,"
        " people: [{name: crew, count: 40, at: anywhere}]}"
    )
    viewer = listening_to_plates(open_page, crowd, space)
    plates = set(map(tuple, viewer.page.evaluate("window.plates")))
    own = viewer.page.locator("[data-shows=distance]").inner_text().removesuffix(" m")
    others = [box for text, *box in plates if own not in text]
    assert 0 < len(others) < len(plates)
    for a, b in itertools.combinations(others, 2):
        wide, high = min(a[1], b[1]) - max(a[0], b[0]), min(a[3], b[3]) - max(a[2], b[2])
        assert max(wide, 0) * max(high, 0) <= 5 * max(a[1] - a[0], b[1] - b[0])


LISTEN_TO_DISTANCES = """
() => {
  const plain = drawDistances;
  window.shown = [];
  window.drawDistances = (pen, watch, t) => {
    window.shown.push(watch.person.name);
    plain(pen, watch, t);
  };
}
"""


def test_in_a_crowd_only_distances_of_the_focus_and_of_people_near_are_shown(open_page):
    crowd = (
        "{floorplan: ariac2023, duration: 4, rules: observe,"
        " people: [{name: crew, count: 25, at: anywhere}]}"
    )
    run = sim.run(sim.Trial.parse(crowd))
    viewer = open_page(replay.render(rounded(replay_data(run))))
    assert viewer.text("#subtitle") == "ARIAC 2023 workcell · 25 × indifferent"
    viewer.page.evaluate(LISTEN_TO_DISTANCES)
    for t in (1.0, 3.0):
        viewer.page.evaluate("window.shown = []")
        viewer.seek(t)
        *near, focus = dict.fromkeys(viewer.page.evaluate("window.shown"))
        names = [person.name for person in run.scene.people if person.name != focus]
        margins = {name: float(run.margin(name, "gantry", [t])[0]) for name in names}
        assert near == sorted(margins, key=margins.get)[: len(near)] and 1 <= len(near) <= 3


WATCH_CANVASES = """
() => {
  window.painted = [];
  const small = new OffscreenCanvas(32, 32).getContext("2d", { willReadFrequently: true });
  for (const canvas of document.querySelectorAll("canvas")) {
    new ResizeObserver(() => {
      if (getComputedStyle(canvas).visibility === "hidden") return;
      small.clearRect(0, 0, 32, 32);
      small.drawImage(canvas, 0, 0, 32, 32);
      window.painted.push(small.getImageData(0, 0, 32, 32).data.some(value => value > 0));
    }).observe(canvas);
  }
}
"""


def test_no_canvas_is_painted_empty(open_page, recording):
    """An observer of sizes that is added last sees the canvas just before the browser paints."""
    viewer = open_page(replay.render(recording, recording))
    viewer.settle()
    viewer.page.evaluate(WATCH_CANVASES)
    for k, width in enumerate((1280, 1000, 900, 500), 1):
        viewer.page.set_viewport_size({"width": width, "height": 720})
        viewer.wait_until(lambda k=k: viewer.page.evaluate("window.painted.length") >= 3 * k)
    assert all(viewer.page.evaluate("window.painted"))
    assert viewer.complaints == []


@pytest.mark.slow
def test_two_fingers_zoom_the_floor(open_page, recording):
    viewer = open_page(
        replay.render(recording), viewport={"width": 390, "height": 844}, has_touch=True
    )
    viewer.settle()
    floor = viewer.page.locator(".view canvas.flat")
    whole = viewer.still(floor)
    box = floor.bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    fingers = viewer.context.new_cdp_session(viewer.page)
    for kind, spread in (("touchStart", 20), ("touchMove", 50), ("touchMove", 80)):
        points = [{"x": x - spread, "y": y, "id": 0}, {"x": x + spread, "y": y, "id": 1}]
        fingers.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})
    fingers.send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})
    viewer.wait_until(lambda: viewer.differ(whole, floor.screenshot()))

    def is_whole():
        # A browser ignores a tap right after a gesture, so repeat it until the floor is whole.
        viewer.page.locator("#fit").tap()
        return not viewer.differ(whole, floor.screenshot())

    viewer.wait_until(is_whole)


def test_every_control_has_a_name(viewer):
    unnamed = viewer.page.evaluate(
        """() => [...document.querySelectorAll("button, select, canvas[role=img], [role=slider]")]
            .filter(e => !(e.getAttribute("aria-label") || e.innerText.trim() || e.labels?.length))
            .map(e => e.outerHTML)"""
    )
    assert unnamed == []
    viewer.seek(5.0)
    assert viewer.page.locator("#chart").get_attribute("aria-valuetext") == "5.0 seconds"
    assert "operator moving at 1.0 m/s" in viewer.page.locator(".view canvas.flat").get_attribute(
        "aria-label"
    )


def test_an_address_can_point_at_an_instant(open_page, recording, tmp_path):
    viewer = open_page(replay.render(recording))
    viewer.page.goto("about:blank")
    viewer.page.goto((tmp_path / "0.html").as_uri() + "#t=61.5")
    assert viewer.time == 61.5


def test_an_almost_empty_floor(open_page):
    bare = {
        "format": replay.FORMAT,
        "title": "bare",
        "duration": 10,
        "summary": {"minimum_separation": None, "people": {}},
        "floorplan": {
            "name": "bare",
            "boundary": [[0, 0], [4, 0], [4, 3], [0, 3]],
            "holes": [[[1, 1], [2, 1], [2, 2]]],
            "obstacles": [],
            "stations": [],
            "safe_zone": None,
            "lanes": [],
            "gantry": None,
        },
        "bodies": [{"name": "walker", "category": "person", "radius": 0.3, "personality": "calm"}],
        "motions": {"walker": [[2, 4, [0.5, 1], [0.5], [0]]]},
        "events": [{"t": 3, "kind": "never heard of"}],
        "watches": [],
    }
    viewer = open_page(replay.render(bare))
    viewer.seek(3)
    assert viewer.page.evaluate("window.floorwalker.pose('walker', 3).x") == 1.5
    assert viewer.page.evaluate("window.floorwalker.pose('walker', 9).speed") == 0
    assert viewer.text(".events li").endswith("never heard of")
    assert viewer.page.locator("[data-shows=distance]").is_hidden()
    assert viewer.complaints == []


def test_names_are_shown_unchanged(open_page, recording):
    hostile = copy.deepcopy(recording)
    name = "<img src=x onerror=alert(1)>"
    hostile["title"] = name
    hostile["events"][3]["station"] = name
    hostile["summary"][name] = name
    viewer = open_page(replay.render(hostile))
    assert viewer.text("#title") == name
    assert name in viewer.text(".events li:nth-child(4)")
    assert viewer.page.locator("img").count() == 0
    assert viewer.complaints == []


# ── bad recordings ──


def broken(recording, change):
    """Return the page with its recording changed after it was written."""
    html = replay.render(recording)
    data = copy.deepcopy(recording)
    change(data)
    start = html.index('id="recording">') + len('id="recording">')
    return html[:start] + json.dumps(data) + "</script>"


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda r: r.update(format="something-else/1"), "this page reads floorwalker-replay/1"),
        (lambda r: r.pop("duration"), "duration: a number of seconds above 0 is missing"),
        (lambda r: r.pop("floorplan"), "floorplan: missing"),
        (lambda r: r["floorplan"].update(boundary=[[0, 0], [1]]), "floorplan.boundary"),
        (lambda r: r["motions"]["operator"][4].__setitem__(0, 1e6), "motions.operator[4]"),
        (lambda r: r["motions"]["gantry"][2][3].append("x"), "motions.gantry[2]"),
        (lambda r: r["bodies"][0].update(category="ghost"), "bodies[0].category"),
        (lambda r: r["bodies"][0].pop("radius"), "bodies[0]: needs numbers: radius"),
        (lambda r: r["events"].reverse(), "events[1]: needs a kind, and a time"),
        (lambda r: r["watches"][1].update(other="nobody"), 'there is no body called "nobody"'),
        (lambda r: r["watches"][0].update(law={"t1": 1}), "watches[0].law"),
        (lambda r: r["watches"][0].pop("violations"), "watches[0].violations"),
    ],
)
def test_faults_of_a_recording_are_reported(open_page, recording, change, message):
    viewer = open_page(broken(recording, change))
    assert message in viewer.text("#trouble")
    assert viewer.page.locator("#replay").is_hidden()
    assert viewer.complaints == []


@pytest.mark.slow
@pytest.mark.parametrize(
    ("change", "message", "bodies"),
    [
        (lambda r: r.update(format="floorwalker-replay/9"), "later format floorwalker-replay/9", 7),
        (lambda r: r["motions"].pop("agv1"), "without the motions of agv1", 6),
        (lambda r: r["motions"].update(operator=[]), "without the motions of operator", 6),
        (lambda r: r.update(notices=["line 3 is damaged"]), "line 3 is damaged", 7),
        (lambda r: r["motions"].clear(), "without the motions of operator, visitor, gantry", 0),
    ],
)
def test_the_rest_of_a_damaged_recording_is_shown_with_a_message(
    open_page, recording, change, message, bodies
):
    viewer = open_page(broken(recording, change), viewport={"width": 700, "height": 500})
    assert message in viewer.text("#notice")
    assert viewer.page.locator("#follow option").count() == 1 + bodies
    for view in ("3d", "eyes", "2d"):
        viewer.page.evaluate("view => window.floorwalker.show(view)", view)
        viewer.seek(61.7)
        assert message in viewer.text("#notice")
    assert viewer.complaints == []


@pytest.mark.slow
def test_a_truncated_page_shows_its_beginning(open_page, recording):
    """The page may be cut anywhere. A longer page shows a longer beginning of the recording."""
    html = replay.render(recording)
    start = html.index('id="recording">')
    viewer = open_page(html[: start + 200])
    assert "cut off" in viewer.text("#trouble")
    assert viewer.page.locator("#replay").is_hidden()
    text = json.dumps(recording)
    parsed = """text => {
        const { notices, motions, events, watches } = parseRecording(text);
        return [notices, motions, events, watches];
    }"""
    sizes = []
    for share in (0.3, 0.5, 0.7, 0.8, 0.9, 0.95, 0.99, 0.99999):
        notices, motions, *lists = viewer.page.evaluate(parsed, text[: round(share * len(text))])
        assert "this is what there is of it" in notices[0]
        whole = json.loads(text)
        for name, pieces in motions.items():
            assert pieces == whole["motions"][name][: len(pieces)]
        for beginning, key in zip(lists, ("events", "watches"), strict=True):
            assert beginning == whole[key][: len(beginning)]
        sizes.append(sum(map(len, [*motions.values(), *lists])))
    assert sizes == sorted(set(sizes))
    viewer = open_page(html[: start + round(0.8 * (len(html) - start))])
    assert "this is what there is of it" in viewer.text("#notice")
    for view in ("3d", "2d"):
        viewer.page.evaluate("view => window.floorwalker.show(view)", view)
        viewer.seek(61.7)
    assert viewer.complaints == []


@pytest.mark.slow
@pytest.mark.parametrize("share", [0.3, 0.9])
def test_a_page_cut_off_in_the_middle_of_its_scripts_reports_it(open_page, recording, share):
    html = replay.render(recording)
    start, end = html.index("<script>"), html.index("</script>")
    viewer = open_page(html[: start + round(share * (end - start))])
    message = viewer.page.locator("#cut-off")
    viewer.wait_until(message.is_visible)
    assert "it was cut off on its way" in message.inner_text()


def test_a_page_without_its_recording_reports_it(open_page, recording):
    html = replay.render(recording)
    viewer = open_page(html[: html.index("<script type=")])
    assert "it holds no recording" in viewer.text("#trouble")


def test_a_law_of_motions_is_drawn_along_its_curve(open_page):
    rules = "{gantry_law: {iso_ts_15066_integral: {t1: 1.0, t2: 1.5, intrusion: 1.0}}}"
    trial = f"floorplan: ariac2023\nduration: 40\npeople: [{{name: a}}]\nrules: {rules}\n"
    run = sim.run(sim.Trial.parse(trial))
    viewer = open_page(replay.render(replay_data(run)))
    watch = next(k for k, pair in enumerate(run.violations) if pair == ("a", "gantry"))
    shown = "([watch, t]) => window.floorwalker.separation(watch, t)"
    for t in (0.05, 1.3, 5.1, 12.0, 22.7, 31.9):
        required = float(run.required("a", "gantry", t))
        separation = viewer.page.evaluate(shown, [watch, t])
        assert separation["required"] == pytest.approx(required, abs=1e-6)
        assert separation["notice"] == pytest.approx(2 * required, abs=1e-6)
    assert viewer.complaints == []
