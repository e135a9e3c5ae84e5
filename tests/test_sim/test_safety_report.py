"""Safety reports: they state what happened, and their pages are accessible."""

import re
from dataclasses import replace

import numpy as np
import pytest
from run_events import record
from small_floors import GANTRY, on_floor

import sim
from sim.record.incidents import incidents, risk, time_on_floor, time_too_close
from sim.record.stops import machine_times
from sim.record.warm_up import after_warm_up
from sim.studies.comparison import sensitivities
from sim.studies.safety import MARGIN, TOO_NEAR, VIOLATIONS, findings, with_findings
from sim.views import film

TRIAL = on_floor(
    """\
boundary: [[0, 0], [20, 0], [20, 12], [0, 12]]
stations: {west: [2, 5], east: [18, 6]}
safe_zone: {at: [2, 5]}
zones: {middle: {x: [8, 12], y: [2, 9], max_speed: 0.8}}
"""
    + GANTRY,
    """\
name: cell
rules: {based_on: RULES, gantry_law: {fixed: 3.0}}
duration: 30
people: [{name: eve, max_speed: {normal: [1.34, 0.26]}}]
gantry: {controller: oblivious, jobs: [{wait: 8}, {move: [10, 5, 0]}]}
sources: {max_speed: "U. Weidmann, <Transporttechnik>, 1993"}
expect: {penalties: 0}
""",
)


def trial(rules="observe"):
    return sim.Trial.parse(TRIAL.replace("RULES", rules))


@pytest.fixture(scope="module")
def run():
    return sim.run(trial())


@pytest.fixture(scope="module")
def page(run, tmp_path_factory):
    file = tmp_path_factory.mktemp("report") / "report.html"
    sim.safety_report(run, file)
    return file.read_text(encoding="utf-8")


def test_incidents_have_the_least_margin_and_the_highest_speed(run):
    recorded = incidents(run)
    assert recorded and [one.begin for one in recorded] == sorted(
        begin for some in run.violations.values() for begin, _ in some
    )
    for one in recorded:
        t = np.linspace(one.begin, one.end, 4001)[:-1]
        apart = run.distance(one.person, one.machine, t)
        assert one.margin == pytest.approx((apart - 3.0).min(), abs=1e-5) and one.margin < 0
        assert one.begin <= one.worst_at <= one.end
        at_worst = run.distance(one.person, one.machine, one.worst_at) - 3.0
        assert one.margin == pytest.approx(at_worst, abs=1e-6)
        v = run.motions["gantry"].velocity(t) - run.motions["eve"].velocity(t)
        assert one.severity == pytest.approx(np.hypot(*v.T).max(), abs=0.03)
        assert one.at == pytest.approx(run.motions["eve"].position(one.begin))
        assert ("middle" in one.zones) == (8 <= one.at[0] <= 12)
        assert one.distance == pytest.approx(3.0, abs=1e-5) and one.led_to == ()
    assert time_too_close(run) == pytest.approx(sum(one.seconds for one in recorded))
    assert time_on_floor(run) == 30.0
    worst = max(one.severity for one in recorded)
    assert risk(run, "severity").max() == pytest.approx(worst, abs=0.03)


@pytest.mark.parametrize(
    ("rules", "led_to"),
    [
        ("paper", ("penalty", "gantry disabled for 8 s", "person taken to the safe zone")),
        ("protective_stop", (r"protective stop (of \d+\.\d s|until the end)",)),
    ],
)
def test_incidents_list_their_consequences(rules, led_to):
    first = incidents(sim.run(trial(rules)))[0]
    assert len(first.led_to) == len(led_to)
    assert all(re.fullmatch(*pair) for pair in zip(led_to, first.led_to, strict=True))


def test_a_report_has_every_violation_and_all_assumptions(run, page):
    for one in incidents(run):
        assert f"{one.begin:.3f}</td>" in page and f"−{-one.margin:.3f}</td>" in page
    assert "normal, mean 1.34, standard deviation 0.26" in page
    assert "U. Weidmann, &lt;Transporttechnik&gt;, 1993" in page
    assert "There is no source given for floorplan, rules" in page
    assert "S = 3 m" in page and "middle" in page and 'class="met">met' in page
    assert "http" not in re.sub(r'xmlns(:\w+)?="[^"]*"|<!--.*?-->', "", page)


def test_figures_of_several_people_stand_in_columns(tmp_path):
    several = "people: [{name: crew, count: 3, at: anywhere}]"
    text = re.sub("people: .*", several, TRIAL).replace("duration: 30", "duration: 1")
    run = sim.run(sim.Trial.parse(text.replace("RULES", "observe")))
    sim.safety_report(run, tmp_path / "many.html")
    page = (tmp_path / "many.html").read_text(encoding="utf-8")
    table = page.partition(">People</")[2].partition(">People</")[2].partition("</table>")[0]
    rows = re.findall(r"<tr>(.*?)</tr>", table, re.DOTALL)
    heads, *lines = (re.findall(r"<t[hd][^>]*>(.*?)</t[hd]>", row, re.DOTALL) for row in rows)
    walked = heads.index("walked")
    assert {line[0]: line[walked] for line in lines} == {
        name: f"{one['distance_walked']:.1f} m" for name, one in run.summary["people"].items()
    }


@pytest.mark.slow
def test_the_same_run_gives_the_same_report(run, page, tmp_path):
    sim.safety_report(sim.run(trial()), tmp_path / "again.html")
    assert (tmp_path / "again.html").read_text(encoding="utf-8") == page


@pytest.mark.parametrize("scheme", ["light", pytest.param("dark", marks=pytest.mark.slow)])
def test_the_page_is_accessible(page, open_page, axe, scheme):
    viewer = open_page(page, color_scheme=scheme, viewport={"width": 390, "height": 800})
    assert viewer.page.evaluate("document.documentElement.scrollWidth") <= 390
    viewer.page.add_script_tag(content=axe)
    result = viewer.page.evaluate("axe.run(document, { resultTypes: ['violations'] })")
    assert [(v["id"], [n["html"] for n in v["nodes"]]) for v in result["violations"]] == []


def a_study(tmp_path, repeat):
    (tmp_path / "cell.trial.yaml").write_text(TRIAL.replace("RULES", "observe"))
    study = sim.Study.parse(
        "{trials: [cell.trial.yaml], grid: {rules.gantry_law.metres: [2.0, 3.0],"
        f" gantry.max_speed: [0.5, 1.0]}}, repeat: {repeat}}}",
        file="cell.study.yaml",
        folder=tmp_path,
    )
    return sim.run_study(study, tmp_path / "results", jobs=1)


def test_findings_of_a_study_join_all_its_runs(tmp_path):
    results = a_study(tmp_path, repeat=1)
    study = results.study
    runs = [sim.run(row.trial) for row in study.rows()]
    counts = [len(incidents(run)) for run in runs]
    joined = findings(study, set(), jobs=1)
    assert [joined.rows[k].count for k in range(4)] == counts
    seconds = np.add.reduce([risk(run, "time") for run in runs])
    assert np.allclose(joined.maps[0]["time"], seconds)
    least = min((one.margin, k) for k, run in enumerate(runs) for one in incidents(run))
    assert (joined.worst[0][1].margin, joined.worst[0][0]) == least
    trends = dict(sensitivities(with_findings(results.comparison, joined)))
    laws, _ = trends[VIOLATIONS]
    is_three = np.array([row.trial.rules.gantry_law.metres == 3.0 for row in study.rows()])
    means = [np.mean(np.array(counts)[is_three == chosen]) for chosen in (False, True)]
    assert [one.mean for one in laws.spreads] == pytest.approx(means)
    assert laws.swing == pytest.approx(abs(means[1] - means[0]))
    assert {TOO_NEAR, MARGIN} < {*trends}


@pytest.mark.slow
def test_a_study_is_reported(tmp_path):
    results = a_study(tmp_path, repeat=2)
    sim.safety_report(results, tmp_path / "report.html", jobs=1)
    count = sum(one.count for one in findings(results.study, set(), jobs=1).rows.values())
    text = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert f"{count:,}</td>" in text and "S = 2 m" in text and "S = 3 m" in text
    assert "in 2 of 4 combinations" in text and text.count("<svg") > 8
    assert "Why machines stood still" in text and "job wait" in text
    later = findings(results.study, set(), jobs=1, warm_up=10.0)
    listed = [incidents(after_warm_up(sim.run(row.trial), 10.0)) for row in results.study.rows()]
    assert [one.count for one in later.rows.values()] == [*map(len, listed)]
    sim.safety_report(results, tmp_path / "report.html", jobs=1, warm_up=10.0)
    text = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "10 s: what happened before is in no count" in text


@pytest.mark.slow
def test_the_command_reports_recordings(floorwalker, tmp_path):
    (tmp_path / "cell.trial.yaml").write_text("{floorplan: ariac2023, duration: 2}")
    floorwalker("run", "cell.trial.yaml", "--out", "run", "--no-open", cwd=tmp_path)
    signed = ("--warm-up", "1", "--plant", "Hall 3", "--revision", "B")
    done = floorwalker("report", "run", *signed, "--out", "report.html", cwd=tmp_path)
    assert (done.returncode, done.stdout) == (0, "report.html\n")
    page = (tmp_path / "report.html").read_text()
    assert "A recording holds neither speeds" in page and "1 s: what happened before" in page
    assert ">Hall 3</td>" in page and ">B</td>" in page


def crowded(keys=""):
    """Run three people around a gantry that waits for them, one of them beside it at the start."""
    return sim.Trial.parse(
        "{floorplan: ariac2023, duration: 12, rules: observe, people:"
        " [{name: near, at: [-4, 0.7]}, {name: eve, personality: external, at: [-4, 4]},"
        " {name: amy, personality: external, at: [-6, 1]}],"
        " gantry: {controller: pausing, at: [-4, 0, 0],"
        f" jobs: [{{pick: bin2, place: agv1}}]}}{keys}}}"
    )


def rows_of(page, title):
    """Return the cells of the rows of the first table below a title."""
    table = page.partition(f">{title}<")[2].partition("</table>")[0]
    rows = re.findall(r"<tr>(.*?)</tr>", table, re.DOTALL)
    return [re.findall(r"<t[hd][^>]*>(.*?)</t[hd]>", row, re.DOTALL) for row in rows]


@pytest.fixture(scope="module")
def crowd():
    """Run of a crowded gantry with a warm-up."""
    return sim.run(crowded(", warm_up: 3"))


@pytest.fixture(scope="module")
def whole(crowd, tmp_path_factory):
    """Report of the run without its warm-up."""
    return report_of(crowd, tmp_path_factory.mktemp("whole"), warm_up=0.0)


def report_of(run, tmp_path, **keys):
    sim.safety_report(run, tmp_path / "report.html", **keys)
    return (tmp_path / "report.html").read_text(encoding="utf-8")


def test_a_report_omits_the_warm_up_with_a_note(crowd, whole, tmp_path):
    run = crowd
    all_of_them, later = (incidents(after_warm_up(run, t)) for t in (0.0, 3.0))
    assert any(one.begin == 0.0 and one.person == "near" for one in all_of_them)
    page = report_of(run, tmp_path)
    assert "3 s: what happened before is in no count" in page
    listed = rows_of(page, "8 Violations")[1:]
    assert sorted(row[0] for row in listed) == sorted(f"{one.begin:.3f}" for one in later)
    counts = {row[0]: row[1:] for row in rows_of(page, "Counts after the warm-up of 3 s")[1:]}
    pairs = [("violations with robots", True), ("violations with vehicles that move", False)]
    for what, is_robot in pairs:
        expected = [
            sum((one.machine == "gantry") == is_robot for one in some)
            for some in (later, all_of_them)
        ]
        assert counts[what] == [*map(str, expected)]
    assert counts["contacts with machines"][1] == str(run.summary["contacts"])
    assert "warm-up" not in whole and len(rows_of(whole, "8 Violations")) - 1 == len(all_of_them)
    with pytest.raises(ValueError, match="less than the duration of the run, 12 s, not 12 s"):
        report_of(run, tmp_path, warm_up=12.0)


def test_a_report_states_why_a_gantry_stood_and_that_it_completed_no_job(crowd, whole, tmp_path):
    run, page = crowd, whole
    assert run.summary["jobs_done"] == 0
    assert "gantry: no job done beside 3 people, though there were jobs." in page
    heads, *rows = rows_of(page, "By cause")
    gantry = dict(zip(heads, rows[0], strict=True))
    (times,) = (one for one in machine_times(run) if one.machine == "gantry")
    assert (gantry["machine"], gantry["jobs done"]) == ("gantry", "0")
    assert gantry["people"].startswith(f"{times.stopped['people']:.1f} (")
    (cause, who), (count, seconds) = next(iter(times.whom.items()))
    line = ["gantry", cause, who, str(count), f"{seconds:.1f}"]
    assert line in rows_of(page, "For whom")
    alone = sim.run(replace(crowded(), people=(), duration=1.0))
    assert "no job done" not in report_of(alone, tmp_path)


FIELDS = """
floorplan:
  boundary: [[0, 0], [24, 0], [24, 8], [0, 8]]
  zones: {dock: {x: [20, 24], y: [0, 8], max_speed: 1}}
duration: 12
rules: {based_on: observe, between: surfaces}
PEOPLE
machines:
  fork: &fork {kind: amr, at: [2, 4, 0], size: [1.2, 0.8], missions: [{go: [22, 4, 0]}]}
  twin: {<<: *fork, at: [2, 7, 0], missions: []}
  cart: {kind: amr, at: [2, 1, 0]}
fields:
  fork: &fields
    response_time: 0.25
    restart_delay: 3
    muting: [dock]
    sets:
    - name: slow
      linear: [-0.1, 0.3]
      protective: [[1.9, 0.9], [-1.2, 0.9], [-1.2, -0.9], [1.9, -0.9]]
    - name: fast
      linear: [0.3, 1.5]
      load: false
      protective: [[1.1, 0.7], [-0.8, 0.7], [-0.8, -0.6], [1.1, -0.6]]
      warning: [[4.6, 0.8], [-0.8, 0.8], [-0.8, -0.8], [4.6, -0.8]]
  twin: *fields
"""


def fields_trial(people):
    return sim.Trial.parse(FIELDS.replace("PEOPLE", people))


def test_a_report_has_the_protective_fields_of_each_machine(tmp_path):
    run = sim.run(
        fields_trial("people: [{name: eve, personality: external, at: [14, 4], max_speed: 0.1}]")
    )
    assert run.summary["field_stops"] >= 1
    page = report_of(run, tmp_path)
    part = page.partition(">4 Protective fields<")[2].partition("</section>")[0]
    assert "cart" not in part and part.count("<h3>fork, twin</h3>") == 1
    facts = dict(rows_of(part, "fork, twin"))
    assert facts["response time"].startswith("0.25 s") and facts["muting"] == "in dock"
    assert facts["restart"].endswith("3 s") and "0.3 m/s" in facts["warning field"]
    assert all(words in part for words in ("ISO 13855:2024, clause 5", "ISO 3691-4:2020, 4.2 c)"))
    table = part.partition("</table>")[2].partition("</table>")[0]
    heads, slow, fast = rows_of(f">sets<{table}", "sets")
    slow, fast = (dict(zip(heads, row, strict=True)) for row in (slow, fast))
    assert (slow["speed, m/s"], slow["ahead, m"], slow["behind, m"]) == (
        "−0.1 … 0.3",
        "1.30",
        "0.60",
    )
    assert (fast["load"], fast["beside, m"], fast["warning, m"]) == (
        "not loaded",
        "0.20",
        "4.00",
    )
    assert slow["too short"] == "no" and fast["too short"].endswith(" m ahead")
    stops = dict(zip(*rows_of(page, "By cause")[:2], strict=True))
    assert float(stops["protective field"].split()[0]) > 0
    (law,) = rows_of(page, "Required distances")[1:]
    assert law[2] == "surface of the machine to surface of the person"


def test_fields_of_a_recording_are_not_checked(tmp_path):
    trial = replace(fields_trial("people: []"), duration=1.0)
    record(trial, tmp_path / "run")
    page = report_of(sim.load_run(tmp_path / "run"), tmp_path)
    assert page.count("not checked") == 2


def test_a_report_without_people_has_no_empty_sections(tmp_path):
    run = sim.run(replace(fields_trial("people: []"), duration=1.0))
    page = report_of(run, tmp_path)
    titles = re.findall(r"<h2>\d+ (.*?)</h2>", page)
    assert titles == [
        *("In short", "Assumptions", "Rules", "Protective fields", "Figures"),
        *("Why machines stood still", "How it was computed", "What this report does not say"),
        "Sign-off",
    ]


def test_a_report_has_a_block_to_sign(tmp_path):
    signed = crowded(", sign_off: {plant: Hall 3, date: 2026-11-24}")
    run = sim.run(replace(signed, people=(), duration=1.0))
    page = report_of(run, tmp_path, sign_off=sim.SignOff(plant="Hall <4>", author="A. Muster"))
    head = page.partition("</header>")[0]
    assert all(words in head for words in ("Hall &lt;4&gt;", "2026-11-24", "A. Muster"))
    assert head.count('class="blank"') == 1 and "An annex to a risk assessment" in head
    assert [row[0] for row in rows_of(page, "signature")] == ["prepared", "checked", "approved"]


def test_the_command_rejects_wrong_arguments_before_it_runs(floorwalker, tmp_path):
    for words, message in {
        "report run --out report.txt": "ends in one of .html, .pdf",
        "report run --out nowhere/report.html": "there is no folder nowhere",
        "report gone.yaml --out report.html": "gone.yaml",
        "report run --jobs 2 --out report.html": "is for studies only",
    }.items():
        done = floorwalker(*words.split(), cwd=tmp_path)
        assert done.returncode in (1, 2) and message in done.stderr


def test_a_pdf_needs_a_browser(run, tmp_path, monkeypatch):
    monkeypatch.delenv("CHROMIUM", raising=False)
    monkeypatch.setattr(film, "NAMES", ("no_such_browser",))
    monkeypatch.setattr(film, "PLACES", ())
    with pytest.raises(ImportError, match="a PDF needs Chromium or Chrome"):
        sim.safety_report(run, tmp_path / "report.pdf")


@pytest.mark.slow
def test_a_pdf_is_printed_where_there_is_a_browser(run, tmp_path):
    pytest.importorskip("playwright")
    if film.installed_chromium() is None:
        pytest.skip("no Chromium on this machine")
    sim.safety_report(run, tmp_path / "report.pdf")
    printed = (tmp_path / "report.pdf").read_bytes()
    assert printed.startswith(b"%PDF") and printed.count(b"/Type /Page\n") > 3


def test_sources_are_written_and_rejected_for_unknown_values():
    before = replace(trial(), rules=sim.PAPER)
    assert sim.Trial.parse(before.to_yaml()).sources == before.sources != {}
    with pytest.raises(sim.TrialError, match="'speed' is not an assumed value"):
        sim.Trial.parse("{floorplan: ariac2023, sources: {speed: me}}")


@pytest.mark.parametrize(
    ("law", "words"),
    [
        ("{iso_ts_15066: {t1: 0.25, t2: 1.5}}", "T<sub>1</sub> = 0.25 s"),
        ("{iso_ts_15066_integral: {t1: 0.25, t2: 1.5}}", "clause 5.5.4.2.3, integral form"),
        ("{iso_13855: {time: 0.25}}", "T = 0.25 s, from sensing"),
        ("{fixed: 0.25}", "S = 0.25 m"),
    ],
)
def test_laws_of_all_kinds_are_written_out(tmp_path, law, words):
    text = TRIAL.replace("RULES", "observe").replace("{fixed: 3.0}", law)
    alone = replace(sim.Trial.parse(text), people=(), duration=1.0)
    assert words in report_of(sim.run(alone), tmp_path)


@pytest.mark.filterwarnings("error")
def test_names_that_the_font_lacks_give_no_warning(tmp_path):
    text = (
        TRIAL.replace("RULES", "observe")
        .replace("west", "組立")
        .replace("duration: 30", "duration: 2")
    )
    sim.safety_report(sim.run(sim.Trial.parse(text)), tmp_path / "report.html")
    assert "組立" in (tmp_path / "report.html").read_text(encoding="utf-8")
