"""Reports of studies: means with intervals, groups, and the page that shows them."""

import csv
import math
import re
import statistics
from html.parser import HTMLParser

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

import sim
from sim.studies import figure
from sim.studies.comparison import Measure, compare, measures, spread

STUDY = """\
trials: [ariac2023]
grid: {personality: [indifferent, helpful], duration: [20, 30]}
random: {max_speed: {uniform: [0.8, 1.2]}}
repeat: 3
"""


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    study = sim.Study.parse(STUDY, file="pace.study.yaml")
    return sim.run_study(study, tmp_path_factory.mktemp("study"), jobs=1)


class Page(HTMLParser):
    """The texts of a page's table cells, row by row, and what it would load from elsewhere."""

    def __init__(self, text):
        super().__init__()
        self.rows, self.links, self._cell = [], [], None
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        self.links += [value for name, value in attributes if name in ("src", "href")]
        if tag == "tr":
            self.rows.append([])
        if tag in ("td", "th"):
            self._cell = []

    def handle_data(self, data):
        if self._cell is not None:
            self._cell.append(data)

    def handle_endtag(self, tag):
        if tag in ("td", "th"):
            self.rows[-1].append("|".join(self._cell))
            self._cell = None


def test_the_runs_to_look_at_have_the_least_separations(results):
    page = Page((results.folder / "report.html").read_text(encoding="utf-8"))
    named = [(int(row[0]), row[2]) for row in page.rows if len(row) == 3 and row[0].isdigit()]
    near = [k for k, (_, why) in enumerate(named) if why.startswith("least separation: ")]
    before = {row for row, _ in named[: near[0]]}
    distances = results.columns["minimum_separation.distance"]
    rest = sorted(set(range(len(distances))) - before, key=lambda k: distances[k])
    assert [named[k][0] for k in near] == rest[:3]


def test_the_page_has_the_means_of_every_combination(results):
    text = (results.folder / "report.html").read_text(encoding="utf-8")
    page = Page(text)
    heads = next(row for row in page.rows if row[:3] == ["personality", "duration", "runs"])
    shown = {(row[0], row[1]): row for row in page.rows if len(row) == len(heads)}
    with (results.folder / "results.csv").open(newline="") as file:
        lines = list(csv.DictReader(file))
    for personality in ("indifferent", "helpful"):
        for duration in (20, 30):
            rows = [
                float(line["people.operator.distance_walked"])
                for line in lines
                if line["personality"] == personality and float(line["duration"]) == duration
            ]
            row = shown[personality, str(duration)]
            assert row[heads.index("runs")] == "3"
            mean, interval = row[heads.index("Walked, m")].split("|")
            assert mean == f"{statistics.mean(rows):.2f}"
            low, high = (float(end) for end in interval.split(" … "))
            assert min(rows) - 0.01 <= low <= statistics.mean(rows) <= high <= max(rows) + 0.01
    assert page.links == []
    assert "http" not in re.sub(r'xmlns(:\w+)?="[^"]*"|<!--.*?-->', "", text)


def test_figures_that_never_change_have_no_chart(results):
    text = (results.folder / "report.html").read_text(encoding="utf-8")
    assert "<h2>Walked</h2>" in text
    assert "<h2>Gantry jobs done</h2>" not in text
    assert text.count("<svg") == text.count("<figure>") > 0
    assert "<dc:date>" not in text


def test_the_page_looks_right_on_a_phone(results, browser):
    page = browser.new_page(viewport={"width": 390, "height": 800})
    said = []
    page.on("console", lambda message: said.append(message.text))
    page.on("pageerror", lambda error: said.append(str(error)))
    page.goto((results.folder / "report.html").as_uri())
    assert page.evaluate("document.documentElement.scrollWidth") <= 390
    page.locator("summary").first.click()
    assert page.locator("details table").first.is_visible()
    page.close()
    assert said == []


def test_nothing_is_cut_off_on_a_screen(results, browser):
    """Neither the table nor, by the axes or the edge of a chart, a mark."""
    page = browser.new_page(viewport={"width": 1300, "height": 900})
    page.goto((results.folder / "report.html").as_uri())
    table = page.locator("section", has=page.locator("h2", has_text="Side by side"))
    fits = "element => element.scrollWidth <= element.clientWidth"
    assert table.locator(".scroll").evaluate(fits)
    clipped = """
        () => [...document.querySelectorAll("figure svg, figure svg [clip-path]")]
            .map(getComputedStyle)
            .filter(style => style.clipPath !== "none" || style.overflow === "hidden").length
    """
    assert page.locator("figure svg [clip-path]").count() > 0
    assert page.evaluate(clipped) == 0
    page.close()


floats = st.lists(st.floats(-1e6, 1e6), min_size=1, max_size=30).map(np.array)


@given(floats)
def test_an_interval_holds_its_mean_and_stays_among_the_values(values):
    found = spread(values)
    slack = 1e-9 * (1 + np.abs(values).max())
    assert found.mean == pytest.approx(statistics.fmean(values), abs=slack)
    assert values.min() - slack <= found.low <= found.high <= values.max() + slack
    assert found.least == values.min() and found.most == values.max()
    assert found.median == pytest.approx(statistics.median(values), abs=slack)


@settings(max_examples=20)
@given(st.integers(0, 2**32 - 1))
def test_intervals_are_as_wide_as_theory_has_it(seed):
    values = np.random.default_rng(seed).normal(5.0, 2.0, size=400)
    found = spread(values)
    half = 1.96 * values.std(ddof=1) / math.sqrt(len(values))
    assert (found.high - found.low) / 2 == pytest.approx(half, rel=0.12)
    assert (found.high + found.low) / 2 == pytest.approx(values.mean(), abs=0.1 * half)


def test_intervals_hold_the_true_mean_as_often_as_they_say():
    rng = np.random.default_rng(1)
    held = 0
    for _ in range(300):
        found = spread(rng.exponential(1.0, size=40))
        held += found.low <= 1.0 <= found.high
    assert 0.88 <= held / 300 <= 0.98


def test_missing_figures_are_left_out():
    assert spread(np.array([math.nan, math.nan])) is None
    assert spread(np.array([1.0, math.nan, 3.0])).mean == 2.0
    columns = {"row": [0, 1, 2], "side": ["a", "b", "a"], "penalties": [1, None, 3]}
    compared = compare(columns, ["side"])
    assert [group.label for group in compared.groups] == ["a", "b"]
    penalties = next(measure for measure in compared.spreads if measure.column == "penalties")
    first, second = compared.spreads[penalties]
    assert (first.mean, second) == (2.0, None)
    assert compared.constant(penalties) is None
    assert compared.label_of(1) == "b"


def test_figures_of_all_people_are_added_up():
    columns = {"people.ada.visits": [1, 2], "people.ben.visits": [10, None], "people.ben.x": [5, 5]}
    assert Measure("", "people.NAME.visits").values(columns).tolist() == [11.0, 2.0]
    assert Measure("", "people.NAME.replans").values(columns) is None


def test_figures_of_zones_are_compared_zone_by_zone():
    columns = {
        "row": [0, 1],
        "zones.aisle.entries": [1, 2],
        "zones.dock.entries": [10, 20],
        "zones.lab.entries": [0, 0],
    }
    values = compare(columns, []).values
    assert {measure.title: list(of_rows) for measure, of_rows in values.items()} == {
        "Entries into aisle": [1.0, 2.0],
        "Entries into dock": [10.0, 20.0],
        "Entries into lab": [0.0, 0.0],
    }


def test_figures_of_machines_that_a_trial_adds_are_compared():
    columns = {
        "row": [0, 1],
        "machines.tug.speed": [1.0, 2.0],
        "error": [None, None],
        "machines.tug.kind": ["tug", "tug"],
        "machines.tug.full_rounds": [3, 5],
        "machines.tug.ends": ["here", "there"],
        "machines.cart.kind": ["agv", "agv"],
        "machines.cart.runs": [1, 2],
    }
    found = {measure.title: measure.chief for measure in compare(columns, []).spreads}
    assert found == {"tug: full rounds": True, "cart: runs": False}


def test_measures_are_columns_of_the_results(results):
    known = {measure.column for measure in results.comparison.spreads}
    assert {"penalties", "minimum_separation.distance", "jobs_done"} <= known
    assert len({measure.column for measure in measures()}) == len(measures())


@pytest.mark.parametrize(
    ("value", "shown"),
    [(0.0, "0"), (3.0, "3"), (0.1234, "0.123"), (12.345, "12.35"), (123.45, "123.5"),
     (12345.6, "12,346"), (None, "–"), (math.nan, "–"), (-2.5, "−2.50"),
     (-0.0, "0"), (-6e-8, "0.000")],
)  # fmt: skip
def test_numbers_are_shown_with_the_digits_that_count(value, shown):
    assert figure(value) == shown
