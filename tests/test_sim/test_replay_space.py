"""The replay page in three dimensions, in a real browser with WebGL in software."""

import copy
import io
import math
import random

import pytest
import replay_sample
from PIL import Image
from replay_sample import replay, replay_data
from shapely.geometry import LineString, Polygon

import sim

pytestmark = pytest.mark.slow  # browsers draw in software


@pytest.fixture(scope="module")
def recording():
    return replay_sample.recording()


@pytest.fixture(scope="module")
def shared(open_shared_page, recording):
    return open_shared_page(replay.render(recording), viewport={"width": 1000, "height": 700})


@pytest.fixture
def viewer(shared):
    """The sample in three dimensions, at its beginning."""
    shared.page.locator("#watch").select_option("0")
    shared.page.locator("#follow").select_option("")
    shared.page.evaluate("window.floorwalker.show('3d')")
    shared.page.locator("#fit").click()
    shared.seek(0.0)
    yield shared
    assert shared.complaints == []


SMALL = {"viewport": {"width": 640, "height": 480}}


def seen(viewer):
    """Return a screenshot of the floor."""
    box = viewer.page.locator("#views").bounding_box()
    png = viewer.page.screenshot(clip=box)
    return Image.open(io.BytesIO(png)).convert("RGB")


def place(viewer, x, y, z=0.0):
    return viewer.page.evaluate("p => window.floorwalker.place(...p)", [x, y, z])


def pose(viewer, name, t):
    return viewer.page.evaluate("([n, t]) => window.floorwalker.pose(n, t)", [name, t])


def color_of(viewer, name):
    text = viewer.page.evaluate(
        "n => getComputedStyle(document.documentElement).getPropertyValue(n)", f"--{name}"
    ).strip()
    return [int(text[i : i + 2], 16) for i in (1, 3, 5)]


def has_color_near(picture, at, color, reach=22, apart=60):
    """Return whether a picture has a colour within `reach` pixels of a place."""
    x, y = round(at[0]), round(at[1])
    part = picture.crop((x - reach, y - reach, x + reach, y + reach))
    return any(
        sum(abs(a - b) for a, b in zip(rgb, color, strict=True)) < apart
        for _, rgb in part.getcolors(1 << 20)
    )


def test_bodies_are_where_they_stand(viewer):
    for t in (2.0, 60.0):
        viewer.seek(t)
        picture = seen(viewer)
        for name, color, height in (("operator", "person-1", 1.2), ("gantry", "robot", 2.9)):
            at = pose(viewer, name, t)
            spot = place(viewer, at["x"], at["y"], height)
            assert has_color_near(picture, spot, color_of(viewer, color)), (name, t)


def test_a_click_selects_the_body_at_the_pointer(viewer):
    viewer.seek(60.0)
    box = viewer.page.locator("#views").bounding_box()
    for name, height, pair in (
        ("visitor", 1.0, "visitor – gantry"),
        ("operator", 1.0, "operator – gantry"),
    ):
        at = pose(viewer, name, 60.0)
        x, y = place(viewer, at["x"], at["y"], height)
        viewer.page.mouse.click(box["x"] + x, box["y"] + y)
        viewer.settle()
        chosen = viewer.page.locator("#watch option:checked").inner_text()
        assert chosen == pair


def test_a_drag_orbits_and_the_wheel_zooms(viewer):
    viewer.seek(30.0)
    box = viewer.page.locator("#views").bounding_box()
    middle = (box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    corner, other = (-22.0, -12.0), (2.0, 12.0)
    before = place(viewer, *corner), place(viewer, *other)
    viewer.page.mouse.move(*middle)
    viewer.page.mouse.down()
    viewer.page.mouse.move(middle[0] + 260, middle[1], steps=3)
    viewer.page.mouse.up()
    viewer.settle()
    turned = place(viewer, *corner), place(viewer, *other)
    assert math.dist(before[0], turned[0]) > 100
    viewer.page.mouse.wheel(0, -500)
    viewer.settle()
    near = place(viewer, *corner), place(viewer, *other)
    assert math.dist(*near) > 1.3 * math.dist(*turned)
    viewer.page.keyboard.press("0")
    viewer.settle()
    assert place(viewer, *corner) == pytest.approx(before[0], abs=0.5)


def test_a_followed_body_stays_in_the_middle(viewer):
    viewer.page.locator("#follow").select_option("operator")
    box = viewer.page.locator("#views").bounding_box()
    for t in (10.0, 60.0, 200.0):
        viewer.seek(t)
        at = pose(viewer, "operator", t)
        x, y = place(viewer, at["x"], at["y"], 0.9)
        assert (x, y) == pytest.approx((box["width"] / 2, box["height"] / 2), abs=2)


def test_the_view_from_the_eyes_of_a_person(viewer):
    viewer.page.keyboard.press("e")
    t = 61.0
    viewer.seek(t)
    at = pose(viewer, "operator", t)
    c, s = math.cos(at["rotation"]), math.sin(at["rotation"])
    box = viewer.page.locator("#views").bounding_box()
    ahead = place(viewer, at["x"] + 5 * c, at["y"] + 5 * s, 1.0)
    assert ahead[0] == pytest.approx(box["width"] / 2, abs=25)
    assert place(viewer, at["x"] - 5 * c, at["y"] - 5 * s, 1.0) is None
    left = place(viewer, at["x"] + 5 * c - s, at["y"] + 5 * s + c, 1.0)
    assert left[0] < ahead[0]
    assert viewer.page.locator("#eyes").get_attribute("aria-pressed") == "true"
    viewer.page.keyboard.press("e")
    assert viewer.page.locator("#space").get_attribute("aria-pressed") == "true"


def test_legs_step_as_far_as_the_body_goes(viewer, recording):
    """While a figure walks steadily, one of its feet is at rest."""
    slid = viewer.page.evaluate(
        """() => {
        const motion = new Motion([[0, 20, [0, 1.2], [0], [0]]]);
        const person = { motion, height: 1.75 };
        const colors = new Proxy({}, { get: () => [0.5, 0.5, 0.5] });
        const feet = t => {
            const pile = new Pile();
            addFigure(pile, person, t, [0, 0, 1], colors);
            const { numbers } = pile.of("trunk", "solid");
            // the first two trunks are the feet: their origins
            return [0, 1].map(i => [numbers[16 * i + 12], numbers[16 * i + 14]]);
        };
        let [moved, worst, lowest] = [0, 0, 1];
        for (let t = 5; t < 12; t += 0.02) {
            const [a, b] = [feet(t), feet(t + 0.02)];
            const planted = a[0][1] <= a[1][1] ? 0 : 1;
            worst = Math.max(worst, Math.abs(b[planted][0] - a[planted][0]));
            moved = Math.max(moved, Math.abs(b[1 - planted][0] - a[1 - planted][0]));
            lowest = Math.min(lowest, a[0][1], a[1][1]);
        }
        return { worst, moved, lowest };
    }"""
    )
    assert slid["worst"] < 0.012 < 0.024 < slid["moved"]  # the body moves 0.024 m in each step
    assert slid["lowest"] == pytest.approx(0.0, abs=0.02)


def test_lines_of_sight_against_shapely(viewer):
    rng = random.Random(4)
    cases = []
    for _ in range(300):
        ring = [
            (c * r, s * r)
            for c, s, r in (
                (math.cos(k * math.tau / 7), math.sin(k * math.tau / 7), rng.uniform(0.4, 2.0))
                for k in range(7)
            )
        ]
        ends = [[rng.uniform(-4, 4), rng.uniform(-4, 4), rng.uniform(0, 3)] for _ in range(2)]
        cases.append((ring, 0.5, 2.0, *ends))
    lines = viewer.page.evaluate(
        """cases => cases.map(([ring, low, high, a, b]) => {
            const share = entryInto(uprightSolid(ring, low, high), a, b);
            return share === Infinity ? null : share;
        })""",
        cases,
    )
    hits = 0
    for (ring, low, high, a, b), share in zip(cases, lines, strict=True):
        heights = sorted((z - a[2]) / (b[2] - a[2]) for z in (low, high))
        begin, end = max(0.0, heights[0]), min(1.0, heights[1])
        want = None
        if begin <= end:

            def at(u, a=a, b=b):
                return (a[0] + u * (b[0] - a[0]), a[1] + u * (b[1] - a[1]))

            common = LineString([at(begin), at(end)]).intersection(Polygon(ring))
            if not common.is_empty:
                nearest = min(
                    math.dist(p, a[:2])
                    for g in getattr(common, "geoms", [common])
                    for p in g.coords
                )
                want = nearest / math.dist(a[:2], b[:2])
        if want is None:
            assert share is None
        else:
            hits += 1
            assert share == pytest.approx(want, abs=1e-6)
    assert hits > 50


def test_any_footprint_is_cut_into_triangles(viewer):
    rings = [
        [[0, 0], [4, 0], [4, 1], [1, 1], [1, 4], [0, 4]],
        [[0, 0], [0, 3], [3, 3], [3, 2], [1, 2], [1, 1], [3, 1], [3, 0]],
    ]
    for ring in rings:
        area = viewer.page.evaluate(
            """ring => {
                const turned = signedArea(ring) > 0 ? ring : [...ring].reverse();
                const areas = trianglesIn(turned).map(signedArea);
                return [areas.reduce((a, b) => a + b), Math.min(...areas)];
            }""",
            ring,
        )
        twice = sum(
            a[0] * b[1] - b[0] * a[1] for a, b in zip(ring, ring[1:] + ring[:1], strict=True)
        )
        assert area[0] == pytest.approx(abs(twice) / 2)
        assert area[1] > 0


def test_without_webgl_there_is_the_floor_from_above_and_a_line(open_page, recording):
    html = replay.render(recording).replace(
        '"use strict";',
        """"use strict";
        const whole = HTMLCanvasElement.prototype.getContext;
        HTMLCanvasElement.prototype.getContext = function (kind, ...rest) {
            return kind === "webgl2" ? null : whole.call(this, kind, ...rest);
        };""",
        1,
    )
    viewer = open_page(html, **SMALL)
    assert viewer.page.locator("#notice").is_hidden()
    viewer.page.locator("#space").click()
    viewer.settle()
    assert "no WebGL 2" in viewer.text("#notice")
    assert viewer.page.locator("canvas.flat").is_visible()
    assert viewer.page.locator("#flat").get_attribute("aria-pressed") == "true"
    viewer.seek(30.0)
    assert viewer.text("[data-shows=time]") == "30.00 s"


def test_webgl_that_is_lost_can_be_restored(open_page, recording):
    viewer = open_page(replay.render(recording), **SMALL)
    viewer.page.keyboard.press("3")
    viewer.settle()
    viewer.page.evaluate(
        """() => document.querySelector("canvas.space").getContext("webgl2")
            .getExtension("WEBGL_lose_context").loseContext()"""
    )
    viewer.wait_until(lambda: viewer.page.locator("#notice").is_visible())
    assert viewer.page.locator("canvas.flat").is_visible()
    viewer.page.keyboard.press("3")
    viewer.settle()
    assert viewer.page.locator("canvas.marks").is_visible()
    assert viewer.page.locator("#notice").is_hidden()


def test_strange_names_and_old_recordings(open_page, recording):
    strange = copy.deepcopy(recording)
    for body in strange["bodies"]:
        for key in ("height", "bottom", "top", "rail_height", "shoulder", "arm_bottom"):
            body.pop(key, None)
    names = ["<b>&amp;</b>", "مرحبا بالعالم", "👷🏽‍♀️🤖", "n" * 200]
    for body, name in zip(strange["bodies"], names, strict=False):
        strange["motions"][name] = strange["motions"].pop(body["name"])
        for watch in strange["watches"]:
            for role in ("person", "other"):
                if watch[role] == body["name"]:
                    watch[role] = name
        body["name"] = name
    viewer = open_page(replay.render(strange), **SMALL)
    viewer.page.keyboard.press("3")
    viewer.seek(60.0)
    viewer.page.keyboard.press("e")
    viewer.settle()
    assert viewer.complaints == []


def test_a_run_is_seen_in_small_pages_and_beside_another(open_page):
    run = sim.run(sim.Trial.load("ariac2023"))
    html = replay.render(replay_data(run))
    assert len(html.encode()) < 600_000
    viewer = open_page(replay.render(replay_data(run), replay_data(run)), **SMALL)
    viewer.page.keyboard.press("3")
    viewer.seek(40.0)
    at = pose(viewer, "operator", 40.0)
    spot = place(viewer, at["x"], at["y"], 1.2)
    for k in range(2):
        canvas = viewer.page.locator("canvas.marks").nth(k)
        picture = Image.open(io.BytesIO(canvas.screenshot())).convert("RGB")
        assert has_color_near(picture, spot, color_of(viewer, "person-1"))
    viewer.page.locator("#stop-comparing").click()
    viewer.settle()
    assert viewer.complaints == []
