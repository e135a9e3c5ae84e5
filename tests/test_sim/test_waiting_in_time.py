"""Waiting in simulated time: events of one instant, people who arrive, tasks of a gantry."""

import itertools
import statistics

import numpy as np
import pytest

from sim.core.clock import Alarm, Clock, Turn
from sim.core.scenario import Source
from sim.machines.tasks import Step, Task, Tasks
from sim.people.person import LOOKS_AGAIN, Entrances


def test_many_events_may_happen_at_once_and_time_continues():
    clock = Clock(most=100)
    happened = []
    for t in range(50):
        for _ in range(100):
            clock.call_at(t * 0.0011, lambda t=t: happened.append(t))
    clock.run()
    assert len(happened) == 5000


def test_only_the_first_person_of_a_queue_looks_for_room():
    """Of 2,000 people in the queue, one enters in each second."""
    clock, looks, inside = Clock(most=100_000), [], []
    entrances = Entrances(clock)

    def came_in(k):
        looks.append((clock.now, k))
        if clock.now < len(inside) + 1:
            return False
        inside.append(k)
        return True

    for k in range(2000):
        entrances.join((0.0, 0.0), lambda k=k: came_in(k))
    clock.run(until=20.25)
    assert inside == [*range(20)]
    assert len(looks) < 100
    assert {t % LOOKS_AGAIN for t, _ in looks} == {0.0}


def test_the_times_between_arrivals_follow_the_rate():
    """They are those of a Poisson process: exponential, from the seed alone."""
    sources = [Source((1.0, 1.0), 0.5, stream="s", number=k) for k in range(1, 2001)]
    times = [source.time(7) for source in sources[::100]]
    assert times == sorted(times) and times != [source.time(8) for source in sources[::100]]
    gaps = np.diff([source.time(7) for source in sources[:400]])
    assert gaps.min() >= 0 and statistics.mean(gaps) == pytest.approx(2.0, rel=0.15)
    assert statistics.stdev(gaps) == pytest.approx(2.0, rel=0.2)


def test_the_time_of_an_arrival_depends_only_on_its_number():
    """It is independent of other arrivals and of the order of queries, and times are ordered."""

    def arrival(number):
        return Source("station1", 0.5, start=3.0, stream="visitor", number=number).time(7)

    arrivals = [arrival(k) for k in range(400, 0, -1)]
    assert arrivals == sorted(arrivals, reverse=True) and arrivals[-1] > 3.0
    assert [arrival(k) for k in (1, 400)] == [arrivals[-1], arrivals[0]]
    gaps = [a - b for a, b in itertools.pairwise(arrivals)]
    assert statistics.mean(gaps) == pytest.approx(2.0, rel=0.15)  # 1 / rate
    assert statistics.stdev(gaps) == pytest.approx(2.0, rel=0.15)  # exponential


def task(name, stage=0, **more):
    return Task("wait", [Step("wait")], stage=stage, fields={"name": name}, **more)


def names(tasks):
    return [task.fields["name"] for task in tasks.open]


def test_a_later_stage_of_tasks_waits_for_the_one_before():
    tasks = Tasks(Clock(0.0))
    first, second, third = task("a"), task("b"), task("c", 1)
    tasks.add([third, first, second])
    assert names(tasks) == ["a", "b"]
    first.advance()
    assert names(tasks) == ["b"]
    second.advance()
    assert names(tasks) == ["c"]


def test_a_group_of_tasks_can_be_first():
    tasks = Tasks(Clock(0.0))
    tasks.add([task("a")])
    tasks.add([task("urgent")], first=True)
    tasks.add([task("b")])
    assert names(tasks) == ["urgent", "a", "b"]


def test_a_task_that_is_not_ready_is_passed_over():
    there = []
    tasks = Tasks(Clock(0.0))
    tasks.add([task("a", ready=lambda: bool(there)), task("b")])
    assert names(tasks) == ["b"]
    there.append(1)
    assert names(tasks) == ["a", "b"]


def test_the_next_task_waits_for_later_tasks():
    clock = Clock(0.0)
    tasks = Tasks(clock)
    tasks.more_to_come = True
    taken = []

    def take():
        while (next_task := (yield tasks.next())) is not None:
            taken.append((clock.now, next_task.fields["name"]))
            next_task.advance()
            tasks.reconsider()
        taken.append((clock.now, None))

    def bring():
        yield clock.timeout(3.0)
        tasks.add([task("late")])
        yield clock.timeout(2.0)
        tasks.more_to_come = False
        tasks.reconsider()

    clock.process(take())
    clock.process(bring())
    clock.run()
    assert taken == [(3.0, "late"), (5.0, None)]


def test_a_task_has_at_least_one_step():
    with pytest.raises(ValueError, match="at least one step"):
        Task("wait", [])


def test_events_occur_at_the_exact_time_and_in_the_order_of_turns():
    clock, happened = Clock(), []
    for turn in (Turn.COMMAND, Turn.NOTICE, Turn.VIOLATION, Turn.MOTION_ENDS):
        clock.call_at(0.1 + 0.2, lambda turn=turn: happened.append((clock.now, turn)), turn)
    clock.run()
    assert happened == [(0.1 + 0.2, turn) for turn in sorted(turn for _, turn in happened)]


def test_a_process_receives_the_answer_of_the_time_at_which_it_is_due():
    clock, received = Clock(), []

    def wait():
        received.append((yield clock.ask(2.0, lambda: clock.now, Turn.NOTICE)))
        received.append((yield clock.happened("before")))
        yield clock.at(1.0)
        received.append(clock.now)

    clock.process(wait())
    clock.run()
    assert received == [2.0, "before", 2.0]


def test_an_error_of_a_process_is_raised_unless_another_process_handles_it():
    clock, handled = Clock(), []

    def fail():
        yield clock.at(1.0)
        raise ValueError("no part")

    def handle():
        try:
            yield clock.process(fail())
        except ValueError as why:
            handled.append(str(why))

    clock.process(handle())
    clock.run()
    assert handled == ["no part"]
    clock.process(fail())
    with pytest.raises(ValueError, match="no part"):
        clock.run()


def test_an_alarm_rings_once_at_the_last_time_set():
    clock, rung = Clock(), []
    alarm = Alarm(clock, lambda: rung.append(clock.now), Turn.MOTION_ENDS)
    for t in (1.0, 3.0, 2.0):
        alarm.set(t)
    clock.run(until=2.5)
    assert rung == [2.0] and alarm.time is None
    alarm.set(4.0)
    alarm.set(None)
    clock.run(until=5.0)
    assert rung == [2.0]
