"""Interrupts of controllers: at any time, no part is lost and no step counts twice."""

import itertools
from collections import Counter
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
import simpy
from hypothesis import given, settings, strategies as st
from run_events import events

import sim

TRIAL = sim.Trial.parse(
    """
floorplan: ariac2023
duration: 600
gantry:
  at: [-5.0, 2.0, 0.0]
  jobs:
    - {pick: bin2, place: agv1, part: first}
    - {pick: bin6, place: agv4, part: second}
    - {pick: bin2, place: agv1, part: third}
"""
)
REASONS = ("person_close", "disabled", "enabled")


def asks(gantry):
    gantry.interrupt_on("person_close", distance=6.0)
    gantry.interrupt_on("disabled")
    gantry.interrupt_on("enabled")


def goes_on_at_once(gantry):
    asks(gantry)
    while (task := (yield gantry.next_task())) is not None:
        while task.next_step is not None:
            try:
                yield gantry.move_to(*(yield gantry.locate(task)))
                yield gantry.handle(task)
            except simpy.Interrupt:
                pass


def stops_and_waits(gantry):
    asks(gantry)
    while (task := (yield gantry.next_task())) is not None:
        while task.next_step is not None:
            try:
                yield gantry.move_to(*(yield gantry.locate(task)))
                yield gantry.handle(task)
            except simpy.Interrupt:
                yield gantry.stop()
                yield gantry.wait(2.0)


def counts_steps_itself(gantry):
    asks(gantry)
    while (task := (yield gantry.next_task())) is not None:
        for _ in task.steps_left:
            while True:
                try:
                    yield gantry.move_to(*(yield gantry.locate(task)))
                    if (yield gantry.handle(task)):
                        break
                except simpy.Interrupt:
                    yield gantry.stop()


def does_tasks_whole(gantry):
    asks(gantry)
    while (task := (yield gantry.next_task())) is not None:
        try:
            yield gantry.do(task)
        except simpy.Interrupt as interrupt:
            if interrupt.cause == "person_close":
                yield gantry.stop()
            yield gantry.wait(1.0) | gantry.look(0.3)


def waits_on_for_its_move(gantry):
    asks(gantry)
    while (task := (yield gantry.next_task())) is not None:
        while task.next_step is not None:
            move = gantry.move_to(*(yield from patiently(gantry, gantry.locate(task))))
            try:
                yield gantry.look()
                yield move
            except simpy.Interrupt:
                yield move
            yield from patiently(gantry, gantry.handle(task))


def patiently(gantry, command):
    try:
        return (yield command)
    except simpy.Interrupt:
        return (yield command)


def steps_back(gantry):
    asks(gantry)
    while (task := (yield gantry.next_task())) is not None:
        while not task.finished:
            try:
                yield from attempt(gantry, task)
            except ApproachedError:
                try:
                    yield gantry.move_to(99.0, 0.0)
                except ValueError:
                    yield from retreat(gantry)


def attempt(gantry, task):
    try:
        yield gantry.move_to(*(yield gantry.locate(task)))
        yield gantry.handle(task)
    except simpy.Interrupt as interrupt:
        raise ApproachedError from interrupt


class ApproachedError(Exception):
    pass


def retreat(gantry):
    people = yield gantry.look()
    yield gantry.move_to(-12.0 + len(people), 0.0)


CONTROLLERS = [
    goes_on_at_once,
    stops_and_waits,
    counts_steps_itself,
    does_tasks_whole,
    waits_on_for_its_move,
    steps_back,
]


def run(controller, interrupts, trial=TRIAL):
    """Return the run with additional interrupts (seconds, reason)."""
    gantry = replace(trial.gantry, controller=controller)
    simulation = sim.Simulation(replace(trial, gantry=gantry))
    for t, reason in interrupts:
        simulation.clock.call_at(t, partial(simulation.gantry.interrupt, reason))
    simulation.advance(trial.duration)
    return simulation.finish()


def stays(run):
    """Return the places where the gantry stood, with begin and end (s)."""
    pieces = run.motions["gantry"].pieces
    moving = [p for p in pieces if any(p.x[1:]) or any(p.y[1:]) or any(p.rotation[1:])]
    begins = [0.0, *(piece.end for piece in moving)]
    ends = [*(piece.begin for piece in moving), run.duration]
    return [
        (run.motions["gantry"].position(begin), begin, end)
        for begin, end in zip(begins, ends, strict=True)
        if end > begin
    ]


def stood(run, place, until):
    """Return the longest time (s) before `until` for which the gantry stood at a place."""
    return max(
        min(end, until) - begin
        for at, begin, end in stays(run)
        if np.allclose(at, PLACES[place], atol=1e-3)
    )


PLACES = {
    "bin2": (-1.9, 2.625),
    "bin6": (-1.9, -2.625),
    "agv1": (-2.27, 4.8),
    "agv4": (-2.27, -4.8),
}


def check_every_step_was_done_once(run):
    """Require that the gantry stood two seconds at each part that it picked or placed."""
    done = events(run, "job_done")
    assert [event["part"] for event in done] == ["first", "second", "third"]
    for event in done:
        assert stood(run, event["from"], event["t"] - 2.0) >= 2.0 - 1e-6
        assert stood(run, event["to"], event["t"]) >= 2.0 - 1e-6


UNDISTURBED = {controller: run(controller, []) for controller in CONTROLLERS[:1]}
STEPS_END = [
    t
    for event in UNDISTURBED[goes_on_at_once].events
    if event["kind"] == "job_done"
    for t in (event["t"] - 2.0, event["t"])
]
awkward = st.builds(
    lambda t, later: t + later,
    st.sampled_from(STEPS_END),
    st.sampled_from([-2.0, -1e-9, 0.0, 0.0, 1e-9, 0.1, 2.0]),
)
instants = st.floats(0.0, 60.0) | awkward
bursts = st.lists(st.tuples(instants, st.sampled_from(REASONS)), max_size=12)


@pytest.mark.parametrize("controller", CONTROLLERS, ids=lambda controller: controller.__name__)
@settings(max_examples=settings.default.max_examples // 2)
@given(bursts)
def test_no_interrupt_breaks_a_controller_or_counts_a_step_twice(controller, interrupts):
    result = run(controller, interrupts)
    check_every_step_was_done_once(result)
    assert run(controller, interrupts).events == result.events


@given(bursts)
def test_no_interrupt_comes_while_another_is_handled_and_none_is_lost(interrupts):
    got = []

    def controller(gantry):
        asks(gantry)
        while True:
            try:
                yield gantry.wait(1000.0)
            except simpy.Interrupt as interrupt:
                got.append((gantry.now, interrupt.cause))
                yield gantry.stop()
                yield gantry.wait(2.0)

    run(controller, interrupts)
    times = [t for t, _ in got]
    assert all(later - earlier > 2.0 - 1e-9 for earlier, later in itertools.pairwise(times))
    for t, reason in interrupts:
        # The current interrupt, and one of each other reason, may come first.
        assert any(t <= at <= t + 6.0 + 1e-9 and cause == reason for at, cause in got)
    assert Counter(reason for _, reason in got) <= Counter(reason for _, reason in interrupts)


def test_an_uncaught_interrupt_is_reported():
    def controller(gantry):
        asks(gantry)
        yield gantry.wait(100.0)

    with pytest.raises(sim.ControllerError, match=r"t = 3 s .*'disabled'.*except simpy.Interrupt"):
        run(controller, [(3.0, "disabled")])


def test_a_replaced_command_ends_unfinished():
    values = []

    def controller(gantry):
        task = yield gantry.next_task()
        whole = gantry.do(task)
        yield gantry.wait(1.0)
        yield gantry.stop()
        values.append((yield whole))
        pick = gantry.pick("bin2")
        yield gantry.wait(1.0)
        yield gantry.move_to(*(yield gantry.locate(task)))
        values.append((yield pick))
        handled = gantry.handle(task)
        yield gantry.wait(1.9)
        values.append((yield gantry.handle(task)))
        values.append((yield handled))
        values.append(len(task.steps_left))
        values.append((yield gantry.place("bin6")))

    result = run(controller, [])
    assert values == [False, False, True, False, 1, True]
    # The gantry moves and handles three times for two seconds. One of these ends after 1.9 s.
    assert result.summary["gantry_idle_time"] < result.duration - 1.9 - 2.0 - 2.0
