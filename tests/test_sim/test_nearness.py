"""Contacts, distances between people, and approaches: begins and ends in small floors."""

from types import SimpleNamespace

import pytest

import sim
from navigation import Motion, standing
from sim.core.body import Body
from sim.core.clock import Clock
from sim.safety.contacts import PersonContacts
from sim.safety.monitors import PersonWatches
from sim.safety.proximity import ApproachMonitor, Distancing

RADIUS = 0.3


class Stage(SimpleNamespace):
    """A stage of people and one machine that only records events."""

    def __init__(self, end=20.0):
        clock = Clock()
        human = SimpleNamespace(height=1.8, radius=RADIUS)
        super().__init__(
            clock=clock,
            end=end,
            floorplan=SimpleNamespace(human=human),
            people=[],
            events=[],
        )
        self.record = lambda event: self.events.append((clock.now, event))

    def person(self, name, at, **keys):
        """Add a person at a position."""
        body = Body(self.clock, name, "person", standing(at))
        defaults = {"started_at": 0.0, "away": False, "is_recorded": False, "radius": RADIUS}
        person = Person(name=name, body=body, **{**defaults, **keys})
        self.people.append(person)
        return person

    def machine(self, motion, category="vehicle"):
        """Return a machine of 1 × 0.6 m on a motion."""
        shape = sim.MachineShape(
            name="cart", kind="amr", category=category, length=1.0, width=0.6, top=0.5, top_speed=9
        )
        body = Body(self.clock, "cart", "amr", motion)
        return Machine(name="cart", body=body, shape=shape, touched=lambda: None)


class Person(SimpleNamespace):
    __hash__ = object.__hash__


class Machine(SimpleNamespace):
    __hash__ = object.__hash__


def along_x(*places, begin=0.0):
    """Return a motion between places on the x axis, two seconds each, with a stop at each."""
    times = [begin + 2.0 * k for k in range(len(places))]
    return Motion.from_samples(times, [(x, 0.0) for x in places])


def contacts_with(stage, person, machine):
    contacts = PersonContacts(stage)
    contacts.watch(person, machine, PersonWatches(person.body))
    contacts.started(person)
    return contacts


def test_a_vehicle_that_drives_into_a_person_touches_them_once():
    stage = Stage()
    contacts = contacts_with(
        stage, stage.person("ann", (5.0, 0.0)), stage.machine(along_x(0.0, 9.0))
    )
    stage.clock.run(until=19.0)
    ((t, contact),) = stage.events
    assert contacts.count == 1 and contact.person == "ann"
    assert along_x(0.0, 9.0).position(t)[0] + 0.5 + RADIUS == pytest.approx(5.0, abs=1e-4)


def test_absent_people_have_no_contacts():
    stage = Stage()
    person = stage.person("ann", (5.0, 0.0), away=True)
    contacts = contacts_with(stage, person, stage.machine(along_x(0.0, 9.0, 0.0)))
    stage.clock.run(until=1.9)
    assert contacts.count == 0
    person.away = False
    contacts.started(person)
    stage.clock.run(until=19.0)
    assert contacts.count == 1


def test_a_vehicle_that_stops_at_a_person_ends_the_contact():
    stage = Stage()
    machine = stage.machine(along_x(0.0, 4.5))
    contacts = contacts_with(stage, stage.person("ann", (5.0, 0.0)), machine)
    stage.clock.run(until=5.0)
    assert contacts.count == 1
    machine.body.follow(along_x(4.5, 4.6, begin=5.0))
    stage.clock.run(until=19.0)
    assert contacts.count == 2


@pytest.mark.parametrize("category", ["vehicle", "robot"])
def test_a_person_who_walks_away_in_time_is_not_touched(category):
    stage = Stage()
    machine = stage.machine(along_x(0.0, 9.0), category)
    person = stage.person("ann", (5.0, 0.0))
    contacts = contacts_with(stage, person, machine)
    stage.clock.run(until=0.5)
    away = [(5.0, 0.0), (5.0, 3.0)]
    person.body.follow(Motion.from_samples([0.5, 0.9], away))
    stage.clock.run(until=5.0)
    assert contacts.count == 0
    back = [(5.0, 3.0), (9.0, 0.0)]
    person.body.follow(Motion.from_samples([5.0, 9.0], back))
    stage.clock.run(until=19.0)
    assert contacts.count == (category == "robot")


@pytest.mark.parametrize(("category", "drive"), [("vehicle", (0, 4.5, 5.5)), ("robot", (0, 5.0))])
def test_a_contact_at_the_end_of_the_trial_is_counted_once(category, drive):
    stage = Stage(end=3.0)
    machine = stage.machine(along_x(*drive), category)
    contacts = contacts_with(stage, stage.person("ann", (5.0, 0.0)), machine)
    stage.clock.run(until=9.0)
    assert contacts.count == 1


def test_a_machine_less_than_a_millimetre_away_still_touches():
    for parts_by, count in ((0.0005, 1), (0.002, 2)):
        stage = Stage()
        touches = 5.0 - 0.5 - RADIUS
        drive = along_x(0.0, touches + 0.1, touches - parts_by, touches + 0.1)
        machine = stage.machine(drive, "robot")
        contacts = contacts_with(stage, stage.person("ann", (5.0, 0.0)), machine)
        stage.clock.run(until=19.0)
        assert contacts.count == count


@pytest.mark.parametrize(("parts_by", "count"), [(0.0005, 1), (0.002, 2)])
def test_people_who_part_by_less_than_a_millimetre_came_near_once(parts_by, count):
    stage = Stage()
    ann, bob = stage.person("ann", (5.0, 0.0)), stage.person("bob", (0.0, 0.0))
    near = 5.0 - 1.0 - 2 * RADIUS
    bob.body.follow(along_x(0.0, near + 0.1, near - parts_by, near + 0.1))
    distancing = Distancing(stage, [ann, bob], [RADIUS, RADIUS], 1.0)
    stage.clock.run(until=19.0)
    assert distancing.count == len(stage.events) == count


@pytest.mark.parametrize(("parts_by", "count"), [(0.09, 1), (0.11, 2)])
def test_an_approach_counts_again_after_parting_by_ten_centimetres(parts_by, count):
    stage = Stage()
    stage.person("ann", (5.0, 0.0))
    machine = stage.machine(along_x(0.0, 3.5, 3.0 - parts_by, 3.5))
    approaches = []
    monitor = ApproachMonitor(stage, machine, lambda: approaches.append(stage.clock.now))
    monitor.near(2.0)
    stage.clock.run(until=19.0)
    assert len(approaches) == count


def test_distances_are_between_surfaces():
    stage = Stage()
    ann, bob = stage.person("ann", (5.0, 0.0)), stage.person("bob", (0.0, 0.0))
    bob.body.follow(along_x(0.0, 4.0))
    Distancing(stage, [ann, bob], [RADIUS, RADIUS], 1.0)
    stage.clock.run(until=19.0)
    ((_, event),) = stage.events
    assert event.distance == pytest.approx(1.0, abs=1e-6) and event.required == 1.0
