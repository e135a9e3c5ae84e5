"""Reports of studies: means with intervals, groups, and the page that shows them."""

import csv
import re
import statistics
from html.parser import HTMLParser

import pytest

import sim

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
    """Texts of the table cells of a page, row by row, and its links."""

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


def test_the_suggested_runs_have_the_least_separations(results):
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
    start = next(k for k, row in enumerate(page.rows) if "Walked, m" in row)
    heads = page.rows[start]
    shown = {(row[0], row[1]): row for row in page.rows[start + 1 : start + 5]}
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
    messages = []
    page.on("console", lambda message: messages.append(message.text))
    page.on("pageerror", lambda error: messages.append(str(error)))
    page.goto((results.folder / "report.html").as_uri())
    assert page.evaluate("document.documentElement.scrollWidth") <= 390
    page.locator("summary").first.click()
    assert page.locator("details table").first.is_visible()
    page.close()
    assert messages == []


def test_tables_and_charts_fit_on_a_screen(results, browser):
    """No table is wider than the page, and no mark of a chart is clipped."""
    page = browser.new_page(viewport={"width": 1300, "height": 900})
    page.goto((results.folder / "report.html").as_uri())
    section = page.locator("section", has=page.locator("h2", has_text="Side by side"))
    fits = "tables => tables.every(table => table.scrollWidth <= table.clientWidth)"
    assert section.locator(".scroll").evaluate_all(fits)
    page.emulate_media(media="print")
    page.set_viewport_size({"width": 690, "height": 1000})  # as wide as a printed page
    assert section.locator(".scroll").evaluate_all(fits)
    clipped = """
        () => [...document.querySelectorAll("figure svg, figure svg [clip-path]")]
            .map(getComputedStyle)
            .filter(style => style.clipPath !== "none" || style.overflow === "hidden").length
    """
    assert page.locator("figure svg [clip-path]").count() > 0
    assert page.evaluate(clipped) == 0
    page.close()


def test_measures_are_columns_of_the_results(results):
    columns = {measure.column for measure in results.comparison.spreads}
    assert {"penalties", "minimum_separation.distance", "jobs_done"} <= columns
