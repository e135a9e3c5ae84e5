"""Figures of a run, and expectations: met, unmet with a time, or invalid."""

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, strategies as st
from run_events import events, first

import sim
from sim.core.events import GoalChanged
from sim.record.figures import FIGURES as DECLARED, SummaryFigure
from sim.record.summary import figures_in_words
from sim.record.words import plain
from sim.trials.expectations import expectation_problems, summary_fields, verdicts
from sim.trials.timeline import NumberCondition, complement

TRIAL = """\
floorplan: ariac2023
duration: 60
people: [{name: operator, personality: antagonistic}]
gantry: {controller: oblivious, at: [-2.5, 0.5, 0.0], jobs: [{wait: 5.0}, {move: [-2.6, 0.5, 0]}]}
agvs: {agv1: [{time: 30.0, to: assembly_front}]}
"""


def verdict(run, text):
    """Return the verdict on one expectation of a run without expectations."""
    trial = sim.Trial.parse(TRIAL + "expect:\n" + text)
    (result,) = sim.Run(**{**vars_of(run), "trial": trial}).verdicts
    return result


def vars_of(run):
    names = ("scene", "duration", "summary", "events", "motions", "violations", "requirements")
    return {name: getattr(run, name) for name in names}


@pytest.mark.parametrize(
    "text",
    [
        "  penalties: '>= 1'",
        "  penalties: '> 0, < 10'",
        "  gantry_disabled_time: '>= 8'",
        "  duration: 60",
        "  duration: '59 ± 1'",
        "  duration: '60.1 +/- 0.2'",
        "  interrupted: false",
        "  jobs_done: 2",
        "  violations.person: '>= 1'",
        "  people.operator.violations.gantry: 0",
        "  minimum_separation: '3.5 ± 0.001'",
        "  minimum_separation.time: '> 10'",
        "  people.operator.minimum_separation.required: '3.5 ± 0.001'",
        "  people.operator.distance_walked: '> 20'",
        "  distance_walked: '> 20'",
        "  metrics.people.operator.path_length: '> 20'",
        "  metrics.people.operator.distance_to.gantry.minimum: '>= 3.4'",
        "  metrics.machines.gantry.distance_to_people.intimate_space_intrusions: 0",
        "  visits: [station4, station2]",
        "  visits: {begin_with: [station4]}",
        "  visits: {in_order: [station4, station4]}",
        "  visits: {never: [station3, station1]}",
        "  timeline: [{eventually: violation}]",
        "  timeline: [{eventually: {kind: arrived, station: station2}, within: 20}]",
        "  timeline: [{eventually: {kind: violation, with: gantry, distance: '< 4'}, times: 2}]",
        "  timeline: [{never: {kind: arrived, station: station1}}]",
        "  timeline: [{never: violation, before: 10}]",
        "  timeline: [{never: violation, before: gantry_detected}]",
        "  timeline: [{eventually: gantry_detected, before: violation}]",
        "  timeline: [{eventually: gantry_enabled, after: gantry_disabled, within: 8.001}]",
        "  timeline: [{never: gantry_enabled, after: gantry_disabled, within: 7.999}]",
        "  timeline: [{whenever: violation, then: teleport, within: 0.001}]",
        "  timeline: [{whenever: {kind: goal, person: operator}, then: arrived, within: 60}]",
        "  timeline: [{never: {near: [operator, gantry], metres: 3.4}}]",
        "  timeline: [{always: {apart: [operator, gantry], metres: 3.4}}]",
        "  timeline: [{always: {standing: gantry}, after: gantry_disabled, within: 7.9}]",
        "  timeline: [{always: {standing: agv1}, before: agv_moved}]",
        "  timeline: [{eventually: {moving: agv1}, after: 30, within: 0.1}]",
        "  timeline: [{never: {moving: agv1}, before: 30}]",
        "  timeline: [{whenever: agv_moved, then: {moving: agv1}, within: 0.1}]",
    ],
)
def test_true_expectations_are_met(run, text):
    result = verdict(run, text)
    assert result.met, str(result)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("  penalties: 0", "expected penalties = 0, but it is 2 (t = {violation:.3f} s, "),
        ("  jobs_done: '> 2'", "expected jobs_done > 2, but it is 2"),
        ("  interrupted: true", "expected interrupted true, but it is false"),
        (
            "  minimum_separation: '>= 4'",
            "expected minimum_separation >= 4, but it is 3.49999",
        ),
        (
            "  visits: [station4, station1]",
            "expected visits to begin with station4, station1, but they were station4, station2",
        ),
        ("  visits: {exactly: [station4]}", "to be exactly station4, but they were station4, st"),
        ("  visits: {never: [station2]}", "(station2 at t = 15.830 s)"),
        ("  visits: {in_order: [station2, station1]}", "to have in this order station2, station1"),
        ("  timeline: [{never: violation}]", "but it happened at t = {violation:.3f} s"),
        (
            "  timeline: [{eventually: {kind: violation, with: agv1}}]",
            "expected eventually violation (with agv1), but it never happened",
        ),
        (
            "  timeline: [{eventually: violation, before: gantry_detected}]",
            "expected eventually violation before gantry_detected, but it never happened",
        ),
        (
            "  timeline: [{eventually: violation, times: '>= 5'}]",
            "expected eventually violation >= 5 times, but it happened at t = {violation:.3f} s",
        ),
        (
            "  timeline: [{never: arrived, after: order_submitted}]",
            "order_submitted never happened",
        ),
        (
            "  timeline: [{never: {kind: violation, with: agv2}, after: 60}]",
            "expected never violation (with agv2) after 60 s, but the run ended at t = 60.000 s",
        ),
        (
            "  timeline: [{never: {kind: violation, with: agv2}, after: agv_moved, before: 20}]",
            "before 20 s, but agv_moved happened at t = 30.000 s only",
        ),
        (
            "  timeline: [{never: {kind: violation, penalty: true}}]",
            "expected never violation (penalty true), but it happened",
        ),
        (
            "  timeline: [{whenever: violation, then: arrived, within: 2}]",
            "but none followed violation at t = {violation:.3f} s",
        ),
        (
            "  timeline: [{always: {apart: [operator, gantry], metres: 3.6}}]",
            "expected always operator and gantry at least 3.6 m, but not so at t = ",
        ),
        (
            "  timeline: [{always: {moving: agv1}, after: 30, within: 1}]",
            "expected always agv1 moving after 30 s within 1 s, but not so at t = 30.000 s",
        ),
        (
            "  timeline: [{never: {near: [operator, gantry], metres: 3.6}}]",
            "expected never operator and gantry within 3.6 m, but it happened at t = ",
        ),
    ],
)
def test_an_unmet_expectation_is_reported_with_its_time(run, text, said):
    result = verdict(run, text)
    assert not result.met
    assert said.format(violation=first(run, "violation")["t"]) in str(result)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("  penaltys: 0", "line 7, expect.penaltys: a run has no such figure; the nearest are pen"),
        ("  timelin: []", "the nearest are timeline"),
        (
            "  metrics.people.operator.path_lenght: 1",
            "nearest are metrics.people.operator.path_",
        ),
        ("  penalties: '> 1, 2'", "expected a number or a comparison such as"),
        ("  penalties: '1 ± -2'", "expected a number or a comparison such as"),
        ("  penalties: true", "expected a number or a comparison such as"),
        (f"  penalties: {10**400}", "expected a number or a comparison such as"),
        (f"  timeline: [{{never: violation, before: {10**400}}}]", "before: expected seconds"),
        (
            f"  timeline: [{{never: {{near: [operator, gantry], metres: {10**400}}}}}]",
            "metres: exp",
        ),
        ("  penalties: .nan", "expected a number or a comparison such as"),
        ("  interrupted: 0", "expected true or false, found 0"),
        ("  visits: station4", "expected a list of stations"),
        ("  visits: [statoin4]", "did you mean 'station4'?"),
        ("  visits: {in_oder: [station4]}", "one of begin_with, in_order, exactly, never"),
        ("  timeline: {never: violation}", "expected a list"),
        (
            "  timeline:\n    - never: violation\n    - never: vilation",
            "line 9, expect.timeline[1]",
        ),
        ("  timeline: [{nevr: violation}]", "expected exactly one of never, always"),
        ("  timeline: [violation]", "expected keys with one of never"),
        ("  timeline: [{never: vilation}]", "did you mean 'violation'?"),
        ("  timeline: [{never: [violation]}]", "expected a kind of event, or keys"),
        ("  timeline: [{never: {kind: [violation]}}]", "no kind of event is called"),
        ("  timeline: [{never: violation, befor: 3}]", "did you mean 'before'?"),
        ("  timeline: [{never: violation, times: 3}]", "'never' takes no 'times'"),
        ("  violations: 0", "the nearest are violations"),
        ("  path_length: 9", "metrics.people.operator.path_length"),
        ("  timeline: [{never: violation, after: .inf}]", "after: expected seconds, found inf"),
        ("  timeline: [{never: violation, after: 9, before: 5}]", "more than the 9 s of after"),
        ("  timeline: [{always: {moving: gantry}, within: 0}]", "within: a state lasts"),
        ("  timeline: [{never: {near: [agv1, agv1], metres: 1}}]", "two bodies, found 'agv1' tw"),
        ("  timeline: [{never: {kind: violation, cause: gantri}}]", "did you mean 'gantry'?"),
        ("  timeline: [{never: {kind: teleport, reason: person}}]", "there are: gantry, agv"),
        ("  timeline: [{never: {kind: agv_moved, to: kiting}}]", "did you mean 'kitting'?"),
        (
            "  timeline: [{never: {kind: job_done, part: pump}}]",
            "no part is called 'pump'; there is",
        ),
        ("  timeline: [{never: {kind: job_done, to: bin}}]", "no place is called 'bin'; did you"),
        ("  timeline: [{never: {kind: job_done, job: pick}}]", "no kind of job is called 'pick'"),
        ("  timeline: [{never: {kind: order_submitted, order: 7}}]", "no order is called 7; there"),
        ("  timeline: [{never: {kind: order_submitted, type: kit}}]", "did you mean 'kitting'?"),
        (
            "  timeline: [{never: {kind: personality_changed, personality: helpfull}}]",
            "did you mean 'helpful'?",
        ),
        ("  timeline: [{never: violation, before: -1}]", "before: expected seconds, found -1"),
        ("  timeline: [{never: {kind: violation, wit: gantry}}]", "has no field 'wit'; did you"),
        ("  timeline: [{never: {kind: violation, with: operator}}]", "no machine is called"),
        ("  timeline: [{never: {kind: violation, penalty: 1}}]", "expected true or false"),
        ("  timeline: [{never: {kind: violation, distance: near}}]", "expected a number or a"),
        ("  timeline: [{never: {kind: arrived, at: [0, 0]}}]", "is a point; only single"),
        ("  timeline: [{never: {kind: gantry_enabled, by: x}}]", "'by'; there are: machine"),
        ("  timeline: [{always: violation}]", "expected a state"),
        ("  timeline: [{always: {near: [operator], metres: 1}}]", "the names of two bodies"),
        ("  timeline: [{always: {near: [operator, x], metres: 1}}]", "no body is called 'x'"),
        ("  timeline: [{always: {near: [operator, gantry], metres: 0}}]", "more than 0, found 0"),
        ("  timeline: [{always: {moving: gantri}}]", "did you mean 'gantry'?"),
        ("  timeline: [{whenever: violation, then: teleport}]", "needs then: what is to follow"),
    ],
)
def test_a_typo_is_an_error_with_its_place(text, message):
    with pytest.raises(sim.TrialError) as caught:
        sim.Trial.parse(TRIAL + "expect:\n" + text + "\n")
    assert message in str(caught.value)
    assert "expect" in str(caught.value)


def test_a_figure_is_reported_so_that_it_can_be_expected(run):
    result = verdict(run, "  distance_walked: 1")
    assert result.found == f"it is {run.summary['people']['operator']['distance_walked']!r}"
    assert verdict(run, f"  distance_walked: {result.found.removeprefix('it is ')}").met


def test_visits_are_to_stations_only():
    text = """
floorplan: ariac2023
duration: 90
people: [{name: operator, personality: scared}]
gantry: {controller: parked, at: [-5.0, 0.5, 0.0]}
expect:
  visits: {never: [%s]}
"""
    run = sim.run(sim.Trial.parse(text % "station1"))
    arrivals = events(run, "arrived")
    stations = [event for event in arrivals if event["station"] is not None]
    assert arrivals.index(stations[-1]) >= len(stations), "nobody came to elsewhere before"
    last = replace(run.trial, expect={"visits": {"never": [stations[-1]["station"]]}})
    (result,) = sim.Run(**{**vars_of(run), "trial": last}).verdicts
    first_there = next(e for e in stations if e["station"] == stations[-1]["station"])
    assert result.time == first_there["t"]
    for how in ("in_order", "exactly"):
        expecting = replace(run.trial, expect={"visits": {how: ["station4"] * 20}})
        assert not sim.Run(**{**vars_of(run), "trial": expecting}).verdicts[0].met


def test_reactions_due_after_the_end_of_a_run_are_not_required(run):
    late = max(event["t"] for event in events(run, "goal"))
    delay = 60.0 - late + 0.5
    text = f"  timeline: [{{whenever: goal, then: said, within: {delay}, after: {late - 0.001}}}]"
    assert verdict(run, text).met


def test_one_of_several_people_is_named(run):
    text = TRIAL.replace("people: [", "people: [{name: ada}, ")
    trial = sim.Trial.parse(text + "expect: {people.ada.visits: [station4]}\n")
    assert len(trial.expect) == 1
    with pytest.raises(sim.TrialError, match="no such figure"):
        sim.Trial.parse(text + "expect: {visits: [station4]}\n")


def leaves(value, path=()):
    if isinstance(value, dict):
        for key, inner in value.items():
            yield from leaves(inner, (*path, key))
    else:
        yield path


def test_every_figure_of_the_summary_can_be_expected(run):
    fields = summary_fields(run.trial)
    names = {"trial", "floorplan", "rules", "law_audit", "seed", "personality"}
    names |= {"cpu_seconds", "realtime_factor", "person", "agv", "machine"}
    for path in leaves({**run.summary, "metrics": run.metrics}):
        if path[-1] not in names:
            assert ".".join(path).removesuffix(".distance") in fields or ".".join(path) in fields


@given(st.floats(-100, 100), st.floats(0, 10), st.floats(-120, 120))
def test_a_tolerance_includes_both_bounds(middle, more, figure):
    condition = NumberCondition.parse(f"{middle!r} ± {more!r}")
    low, high = (Fraction(repr(middle)) + sign * Fraction(repr(more)) for sign in (-1, 1))
    assert condition.passes(figure) == (float(low) <= figure <= float(high))


def test_a_tolerance_is_meant_in_decimals():
    condition = NumberCondition.parse("0.7 ± 0.1")
    assert condition.passes(0.8)
    assert condition.passes(0.6)
    assert not condition.passes(0.8000001)
    assert str(NumberCondition.parse("27.53674 +/- 0.000001")) == "27.53674 ± 0.000001"


@given(st.lists(st.floats(0, 10), max_size=8, unique=True))
def test_a_complement_and_the_intervals_fill_the_time(edges):
    edges = sorted(edges)
    intervals = list(zip(edges[::2], edges[1::2], strict=False))
    gaps = complement(intervals, 10.0)
    assert sum(e - b for b, e in intervals + gaps) == pytest.approx(10.0)
    for t in (0.5, 3.3, 9.99):
        inside = any(b < t < e for b, e in intervals)
        assert inside != any(b < t < e for b, e in gaps) or t in edges


NAMES = st.sampled_from(
    ["never", "always", "eventually", "whenever", "then", "after", "before", "within", "times"]
)
THINGS = st.sampled_from(
    ["kind", "near", "apart", "metres", "moving", "violation", "goal", "operator", "gantry", "with"]
)
FIGURES = st.sampled_from(["distance", "penalties", "visits", "in_order", "interrupted"])
WORDS = NAMES | THINGS | FIGURES | st.text(max_size=5)
VALUES = st.recursive(
    st.none() | st.booleans() | st.integers() | st.just(10**400) | st.floats() | WORDS,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(WORDS, inner, max_size=3),
    max_leaves=12,
)


@given(st.dictionaries(WORDS, VALUES, max_size=3), st.lists(VALUES, max_size=3))
def test_any_values_are_expectations_or_problems(run, values, timeline):
    trial = replace(run.trial, expect={**values, "timeline": timeline})
    problems = list(expectation_problems(trial))
    if not problems:
        assert verdicts(trial, run) is not None
    for message, place in problems:
        assert message
        assert place[0] in trial.expect


GOALS = """
floorplan: ariac2023
duration: 30
people: [{name: nina, personality: helpful}]
expect: {goals_set: "> 90", people.nina.waits: 0}
"""


@pytest.fixture
def own_figures(monkeypatch):
    """Two custom figures: one of the whole run, one of each person."""
    goals = SummaryFigure(
        path="goals_set",
        of=lambda run: sum(len(motion.pieces) > 1 for motion in run.motions.values()),
        label="goals set",
        words=plain,
        events=(GoalChanged, {}),
        measure="chief",
    )
    waits = SummaryFigure(path="people.NAME.waits", of=lambda run, person: 0, label="waits")
    for figure in (goals, waits):
        monkeypatch.setitem(DECLARED, figure.path, figure)


def test_a_figure_is_added_by_its_declaration_alone(own_figures, tmp_path):
    trial = sim.Trial.parse(GOALS)
    run = sim.run(trial)
    assert run.summary["goals_set"] >= 1
    assert run.summary["people"]["nina"]["waits"] == 0
    unmet = [verdict for verdict in run.verdicts if not verdict.met]
    assert [verdict.place for verdict in unmet] == [("goals_set",)]
    assert unmet[0].time == [e["t"] for e in run.events if e["kind"] == "goal"][-1]
    assert dict(figures_in_words(run.summary))["goals set"] == str(run.summary["goals_set"])
    study = sim.Study(name="own", trials=(trial,), repeat=2)
    results = sim.run_study(study, tmp_path / "study", jobs=1)
    assert results.columns["goals_set"] == [run.summary["goals_set"]] * 2
    assert results.columns["people.nina.waits"] == [0, 0]
    assert "Goals set" in [measure.title for measure in results.comparison.spreads]


def test_many_people_have_a_line_each():
    person = {"visits": ["press"], "distance_walked": 3.0, "time_standing": 0.0, "replans": 0}
    people = {f"p{k}": {"personality": "helpful", **person} for k in range(25)}
    lines = dict(figures_in_words({"people": people}))
    assert lines["p0"] == "helpful; visits press 1×; walked 3.0 m"
    assert len(lines) == 21 and lines["others"].startswith("5 people")
    few = dict(figures_in_words({"people": {"p0": people["p0"]}}))
    assert few["p0: walked"] == "3.0 m" and few["p0: replans"] == "0"


VEHICLES = """
floorplan: warehouse
duration: 20
rules: observe
people: PEOPLE
machines:
  cart: {kind: amr, at: [8.5, 2.0, 0.0], missions: [{wait: 4}, {go: dock}]}
  pod: {kind: amr, at: [12.5, 18.0, 0.0]}
"""


def test_terminals_show_no_gantry_where_there_is_none_and_units_of_machines():
    run = sim.run(sim.Trial.parse(VEHICLES.replace("PEOPLE", "[]")))
    shown = dict(figures_in_words(run.summary))
    idle = run.summary["machines"]["pod"]["idle_time"]
    assert shown["cart"] == "jobs done 1" and shown["pod"] == f"jobs done 0, idle time {idle:.1f} s"
    assert not [line for line in shown if "gantry" in line or "violations" in line]
    assert "penalties" not in shown
    people = "[{name: ann, at: [3.0, 10.0]}]"
    beside = sim.run(sim.Trial.parse(VEHICLES.replace("PEOPLE", people)))
    shown = dict(figures_in_words(beside.summary))
    assert shown["violations with vehicles"] == str(beside.summary["agv_violations"])
    assert not [line for line in shown if "gantry" in line]
    workcell = sim.run(
        sim.Trial.parse("{floorplan: ariac2023, duration: 9, people: [{name: eve}]}")
    )
    assert {"penalties", "violations with the gantry"} < dict(
        figures_in_words(workcell.summary)
    ).keys()


def test_a_margin_of_zero_has_no_sign():
    margin = {"value": -1e-5, "person": "ann", "machine": "cart", "time": 3.0}
    shown = dict(figures_in_words({"least_margin": margin}))
    assert shown["least margin"] == "0.000 m (ann and cart) at 3.0 s"


def test_only_moving_agvs_count_as_the_nearest_agv():
    trial = sim.Trial.parse(
        """\
floorplan: ariac2023
duration: 90
rules: {based_on: observe, agv_offset: 0.2}
people: [{name: crew, count: 3, at: anywhere}, {name: late, start: {event: job_done}}]
agvs:
  agv1: [{time: 10, to: assembly_front}, {time: 60, to: kitting}]
  agv2: [{time: 20, to: assembly_back}]
expect: {nearest_agv: "> 0", people.crew2.nearest_agv.required: "> 0"}
"""
    )
    run = sim.run(trial)
    assert run.unmet == []
    t = np.linspace(0.0, 90.0, 90_001)
    sampled = {}
    for person in ("crew1", "crew2", "crew3"):
        for agv in ("agv1", "agv2", "agv3"):
            drives = np.hypot(*run.motions[agv].velocity(t).T) > 0.0
            if drives.any():
                sampled[person, agv] = run.distance(person, agv, t[drives]).min()
        recorded = run.summary["people"][person]["nearest_agv"]
        least = min((apart, agv) for (who, agv), apart in sampled.items() if who == person)
        assert (recorded["distance"], recorded["agv"]) == (
            pytest.approx(least[0], abs=5e-3),
            least[1],
        )
        apart = run.distance(person, recorded["agv"], recorded["time"])
        assert recorded["distance"] == pytest.approx(float(apart), abs=1e-6)
        required = run.required(person, recorded["agv"], [recorded["time"]])
        assert recorded["required"] == pytest.approx(required[0], abs=0.05)
    nearest = run.summary["nearest_agv"]
    assert nearest["distance"] == pytest.approx(min(sampled.values()), abs=5e-3)
    assert run.summary["people"][nearest["person"]]["nearest_agv"]["agv"] == nearest["agv"]
    assert run.summary["people"]["late"]["nearest_agv"] is None
    shown = dict(figures_in_words(run.summary))["least distance to vehicle"]
    assert f"({nearest['person']} and {nearest['agv']}) at {nearest['time']:.1f} s" in shown


def test_without_moves_of_agvs_there_is_no_nearest_agv():
    run = sim.run(sim.Trial.parse("{floorplan: ariac2023, duration: 1, people: [{name: eve}]}"))
    assert "nearest_agv" not in run.summary
    later = (
        "{floorplan: ariac2023, duration: 1, people: [{name: eve}],"
        " agvs: {agv1: [{time: 5, to: assembly_front}]}}"
    )
    assert sim.run(sim.Trial.parse(later)).summary["nearest_agv"] is None


def test_a_state_after_an_event_whose_time_is_rounded_beyond_the_end():
    text = TRIAL.replace("duration: 60", "duration: 1.9999999996") + (
        "expect: {timeline: [{never: {near: [operator, gantry], metres: 1}, after: trial_ended}]}"
    )
    run = sim.run(sim.Trial.parse(text))
    assert run.events[-1]["t"] > run.duration
    assert [one.met for one in run.verdicts] == [True]
