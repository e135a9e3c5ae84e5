"""Random expectations of a run: a slack is negative exactly if its expectation is not met."""

import math
import operator
from dataclasses import replace
from random import Random

from navigation import minimum_separation
from sim.core.events import EVENT_KINDS
from sim.trials.expectations import summary_fields, verdicts

COMPARED = {
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
    "==": operator.eq,
    "!=": operator.ne,
}

STATEMENTS = 12
"""Number of expectations over time for each run."""

EXACT = 1e-6
"""Metres by which the slack of a distance may be off."""


def slack_faults(run):
    """Return expectations whose slack has another sign than their verdict, or another value."""
    random = Random(f"expectations {run.trial.name}")
    fields = summary_fields(run.trial)
    figures = {key: _figure(random, field, run) for key, field in fields.items()}
    timeline = [_statement(random, run) for _ in range(STATEMENTS)]
    expect = {key: wanted for key, (wanted, _) in figures.items()} | {"timeline": timeline}
    for verdict in verdicts(replace(run.trial, expect=expect), run):
        key, *number = verdict.place
        if (verdict.slack < 0) == verdict.met or math.isnan(verdict.slack):
            yield f"{key}: met is {verdict.met}, the slack is {verdict.slack}: {verdict}"
        if number:
            yield from _distance_faults(run, timeline[number[0]], verdict)
        elif figures[key][1] not in (None, verdict.met):
            yield f"{key}: met should be {figures[key][1]}: {verdict}"


def _figure(random, field, run):
    """Return a random expectation of a figure, and whether it is met (None for visits)."""
    value = field.value(run)
    if field.figure.form == "flag":
        wanted = random.random() < 0.5
        return wanted, value is wanted
    if field.figure.form == "visits":
        stations = [station.name for station in run.floorplan.stations]
        named = random.choices(stations, k=random.randint(1, 2)) if stations else []
        wanted = random.choice([named, value or named, [*(value or []), *named]])
        how = random.choice(["begin_with", "in_order", "exactly", "never"])
        return {how: [*wanted]}, None
    sign = random.choice([*COMPARED])
    bound = random.choice([0, 1, 2, round(random.uniform(-5.0, 40.0), 2)])
    if value is not None and random.random() < 0.6:
        step = random.choice([0, 1, -1, 0.5, math.ulp(value)])
        bound = value + step
    if not math.isfinite(bound):
        bound = 0
    met = value is not None and COMPARED[sign](value, bound)
    return f"{sign} {bound!r}", met


def _statement(random, run):
    """Return a random expectation over time."""
    kinds = sorted({event["kind"] for event in run.events} | {"violation", "arrived"})
    kinds = [kind for kind in kinds if kind in EVENT_KINDS]
    bodies = [*run.motions]
    begin = round(random.uniform(0.0, 0.6) * run.duration, 2)
    scopes = {
        "after": random.choice([begin, begin, random.choice(kinds)]),
        "before": random.choice(
            [round(begin + random.uniform(0.1, 40.0), 2), random.choice(kinds)]
        ),
        "within": round(random.uniform(0.1, 30.0), 2),
    }
    scopes = {key: value for key, value in scopes.items() if random.random() < 0.4}
    states = [{random.choice(["moving", "standing"]): random.choice(bodies)}]
    if len(bodies) > 1:
        metres = round(random.choice([random.uniform(0.2, 3.0), random.uniform(0.2, 20.0)]), 2)
        pair = {"metres": metres, random.choice(["near", "apart"]): random.sample(bodies, 2)}
        states += [pair, pair]
    event, state = random.choice(kinds), random.choice(states)
    form = random.choice(["never", "always", "eventually", "whenever"])
    if form == "whenever":
        scopes["within"] = round(random.uniform(0.1, 30.0), 2)
        return {"whenever": event, "then": random.choice([random.choice(kinds), state]), **scopes}
    if form == "eventually" and random.random() < 0.4:
        scopes["times"] = f"{random.choice([*COMPARED])} {random.randint(0, 3)}"
    return {form: state if form == "always" else random.choice([event, state, state]), **scopes}


def _distance_faults(run, written, verdict):
    """Check the slack of a state of two bodies between two times, in metres."""
    form = next(key for key in ("never", "always", "eventually", "whenever") if key in written)
    state = written[form]
    if verdict.unit != "m" or not isinstance(state, dict):
        return
    begin, end = written.get("after", 0.0), written.get("before", math.inf)
    if isinstance(begin, str) or isinstance(end, str):
        return
    end = min(end, run.duration, begin + written.get("within", math.inf))
    one, other = (run.motions[name] for name in state.get("near") or state["apart"])
    spare = minimum_separation(one, other, begin, end)[1] - state["metres"]
    slack = -spare if form == "eventually" else spare
    if abs(slack - verdict.slack) > EXACT:
        yield f"the slack is {verdict.slack}, the distance says {slack}: {verdict}"
