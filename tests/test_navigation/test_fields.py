"""Contacts with protective fields against dense sampling, and by hand."""

import math
from itertools import pairwise

import numpy as np
import pytest
from field_oracle import all_fields, changes, depth, random_case, touches

from floorplan import UserError
from navigation import (
    FieldSet,
    Intrusion,
    Motion,
    ProtectiveFields,
    VehicleLimits,
    first_intrusion,
    intrusions,
    join,
    standing,
    vehicle_path,
    vehicle_segment,
    vehicle_turn,
)

BOX = ((0.0, -0.5), (2.0, -0.5), (2.0, 0.5), (0.0, 0.5))
BEGIN, END = 0.0, 9.0
ACCURACY = 1e-6
"""Seconds."""

GRAZING = 1e-9
"""Metres."""


def fields_of(*sets):
    return ProtectiveFields(sets=sets)


def box(**keys):
    return fields_of(FieldSet(name="box", protective=BOX, **keys))


def moving(begin, end, a, b):
    return Motion.from_samples([begin, end], [a, b])


def check(seed, step):
    """Compare a random case with samples."""
    case = random_case(seed)
    fields, machine, person, radius = case
    found = intrusions(fields, machine, person, radius, BEGIN, END)
    for which, field in all_fields(case):
        mine = [(i.begin, i.end) for i in found if (i.set, i.field) == (which.name, field)]
        ends = np.array([t for span in mine for t in span])
        for t in changes(case, which, field, np.arange(BEGIN, END, step)):
            near = np.abs(ends - t).min(initial=math.inf)
            grazes = abs(depth(case, which, field, np.array([t - 1e-6, t, t + 1e-6]))).max()
            assert near <= ACCURACY or grazes <= GRAZING, (seed, which.name, field, t)
        for begin, end in mine:
            middle = (begin + end) / 2
            assert touches(case, which, field, middle) or end - begin <= ACCURACY
        for (_, end), (begin, _) in pairwise(mine):
            assert not touches(case, which, field, (end + begin) / 2)
    first = first_intrusion(fields, machine, person, radius, BEGIN, END)
    assert (first is not None) == bool(found)
    if found:
        assert first == (found[0].begin, found[0].field, found[0].set)


@pytest.mark.parametrize("first", range(0, 80, 20))
def test_contacts_are_those_of_dense_samples(first):
    for seed in range(first, first + 20):
        check(seed, 5e-3)


@pytest.mark.slow
@pytest.mark.parametrize("first", range(200, 800, 200))
def test_contacts_are_those_of_dense_samples_in_many_cases(first):
    for seed in range(first, first + 200):
        check(seed, 2e-3)


def test_a_person_walks_through_a_standing_field():
    person = moving(0.0, 10.0, (5.0, 0.0), (-5.0, 0.0))
    (found,) = intrusions(box(), standing((0.0, 0.0)), person, 0.3, 0.0, 20.0)
    assert found == Intrusion(pytest.approx(2.7), pytest.approx(5.3), "protective", "box")


def test_a_disc_touches_a_corner_on_its_arc():
    person = moving(0.0, 10.0, (2.18, 5.0), (2.18, -5.0))
    found = intrusions(box(), standing((0.0, 0.0)), person, 0.3, 0.0, 10.0)
    reach = 0.5 + math.sqrt(0.3**2 - 0.18**2)
    assert [(i.begin, i.end) for i in found] == [pytest.approx((5 - reach, 5 + reach))]


def test_a_turn_on_the_spot_sweeps_the_field_over_a_person():
    machine = vehicle_turn((0.0, 0.0, 0.0), math.pi, 1.0)
    found = first_intrusion(box(), machine, standing((0.0, 1.5)), 0.3, 0.0, 10.0)
    # The line y = 0.5 of the field, grown by the radius, passes the person.
    assert math.cos(float(machine.rotation(found.t))) * 1.5 == pytest.approx(0.8)


def test_a_person_in_a_notch_of_a_concave_field_does_not_touch_it():
    notched = ((0, -1), (3, -1), (3, 1), (0, 1), (0, 0.5), (2, 0.5), (2, -0.5), (0, -0.5))
    fields = fields_of(FieldSet(name="notched", protective=notched))
    rest = standing((0.0, 0.0))
    assert intrusions(fields, rest, standing((1.0, 0.0)), 0.49, 0.0, 1.0) == ()
    assert len(intrusions(fields, rest, standing((1.0, 0.0)), 0.51, 0.0, 1.0)) == 1


def test_sets_change_with_the_speed():
    slow = FieldSet(name="slow", protective=BOX, linear=(-0.1, 0.5))
    fast = FieldSet(name="fast", protective=[(3 * x, y) for x, y in BOX], linear=(0.5, 2.0))
    machine = vehicle_segment((0.0, 0.0, 0.0), (6.0, 0.0), limits=VehicleLimits(jerk=math.inf))
    spans = fields_of(slow, fast).applying(machine, 0.0, 20.0)
    # It accelerates at 0.7 m/s², and limits have a tolerance of 0.0001 m/s.
    switch = 0.5001 / 0.7
    assert [span.set.name for span in spans] == ["slow", "fast", "slow"]
    assert [span.begin for span in spans] == pytest.approx(
        [0.0, switch, machine.end - switch], abs=1e-8
    )
    person = standing((6.5, 0.0))
    found = intrusions(fields_of(slow, fast), machine, person, 0.3, 0.0, 30.0)
    assert [each.set for each in found] == ["fast", "slow"]
    assert found[0].end == found[1].begin
    assert found[1].end == 30.0


def test_the_turn_rate_chooses_a_set():
    straight = FieldSet(name="straight", protective=BOX, theta=(-0.1, 0.1))
    turning = FieldSet(name="turning", protective=BOX)
    machine = vehicle_path((0, 0, 0), [(1, 0, 0), (1, 0, 1)])
    spans = fields_of(straight, turning).applying(machine, 0.0, machine.end + 1.0)
    assert [span.set.name for span in spans] == ["straight", "turning", "straight"]
    for span in spans[1:]:
        rate = machine.cubics(span.begin)[2, 1]
        assert rate == pytest.approx(0.1001, abs=1e-6)


def test_the_direction_of_travel_chooses_a_set():
    ahead = FieldSet(name="ahead", protective=BOX, direction=(-math.pi / 4, math.pi / 4))
    other = FieldSet(name="other", protective=BOX, direction=(math.pi / 4, 7 * math.pi / 4))
    limits = VehicleLimits(side_speed=1.0)
    for angle, name in ((0.1, "ahead"), (1.5, "other"), (math.pi, "other"), (-1.0, "other")):
        to = (3 * math.cos(angle + 0.5), 3 * math.sin(angle + 0.5))
        machine = vehicle_segment((0.0, 0.0, 0.5), to, limits=limits)
        (span,) = fields_of(ahead, other).applying(machine, 1.0, 2.0)
        assert span.set.name == name


def test_the_load_chooses_a_set():
    empty = FieldSet(name="empty", protective=BOX, load=False)
    loaded = FieldSet(name="loaded", protective=[(2 * x, y) for x, y in BOX], load=True)
    pair = standing((0.0, 0.0)), standing((3.0, 0.0))
    fields = fields_of(empty, loaded)
    assert first_intrusion(fields, *pair, 0.3, 0.0, 1.0) is None
    assert first_intrusion(fields, *pair, 0.3, 0.0, 1.0, loaded=True).set == "loaded"


def test_without_a_set_that_fits_there_is_no_contact():
    fields = box(linear=(0.5, 1.0))
    pair = standing((0.0, 0.0)), standing((1.0, 0.0))
    assert intrusions(fields, *pair, 0.3, 0.0, 5.0) == ()
    assert [span.set for span in fields.applying(pair[0], 0.0, 5.0)] == [None]


def test_a_contact_at_rest_has_no_end():
    pair = standing((0.0, 0.0)), standing((1.0, 0.0))
    (found,) = intrusions(box(), *pair, 0.3, 2.0, math.inf)
    assert (found.begin, found.end) == (2.0, math.inf)


def test_both_fields_are_found():
    wide = [(2 * x, 2 * y) for x, y in BOX]
    fields = box(warning=wide)
    pair = standing((0.0, 0.0)), moving(0.0, 5.0, (6.0, 0.0), (1.0, 0.0))
    found = intrusions(fields, *pair, 0.3, 0.0, 9.0)
    assert [(i.begin, i.field) for i in found] == [
        (pytest.approx(1.7), "warning"),
        (pytest.approx(3.7), "protective"),
    ]
    for field, t in ((None, 1.7), ("warning", 1.7), ("protective", 3.7)):
        entry = first_intrusion(fields, *pair, 0.3, 0.0, 9.0, field=field)
        assert entry.t == pytest.approx(t)


def test_a_jump_into_a_field_is_a_contact_from_then_on():
    person = join([moving(0.0, 2.0, (9.0, 9.0), (8.0, 9.0)), standing((1.0, 0.0), start=2.0)])
    found = first_intrusion(box(), standing((0.0, 0.0)), person, 0.3, 0.0, 9.0)
    assert found.t == 2.0


def test_a_person_who_slides_along_an_edge_gets_a_result():
    person = moving(0.0, 10.0, (-5.0, 0.8), (5.0, 0.8))
    assert len(intrusions(box(), standing((0.0, 0.0)), person, 0.3, 0.0, 10.0)) <= 1


def test_gaps_between_sets_are_reported():
    slow = FieldSet(name="slow", protective=BOX, linear=(-0.1, 0.5))
    fast = FieldSet(name="fast", protective=BOX, linear=(0.7, 1.0), load=False)
    empty = [g for g in fields_of(slow, fast).gaps((-0.1, 1.2)) if not g.loaded]
    assert [gap.linear for gap in empty] == [(0.5, 0.7), (1.0, 1.2)]
    loaded = [g for g in fields_of(slow, fast).gaps((-0.1, 1.2)) if g.loaded]
    assert [gap.linear for gap in loaded] == [(0.5, 1.2)]
    assert fields_of(fast).gaps((0.7, 0.8))[0].loaded


def test_gaps_of_turn_rates_and_directions_are_reported():
    left = FieldSet(name="left", protective=BOX, theta=(0.0, 1.0))
    assert fields_of(left).gaps((0.0, 1.0), (-1.0, 1.0))[0].theta == (-1.0, 0.0)
    half = FieldSet(name="half", protective=BOX, direction=(0.0, math.pi))
    assert fields_of(half).gaps((0.0, 1.0))[0].direction == (math.pi, math.tau)
    around = FieldSet(name="around", protective=BOX, direction=(-math.pi, math.pi))
    assert fields_of(around).gaps((0.0, 1.0)) == ()


def test_a_set_applies_where_no_set_before_it_fits():
    slow = FieldSet(name="slow", protective=BOX, linear=(-0.5, 0.5))
    left = FieldSet(name="left", protective=BOX, theta=(0.0, math.inf))
    rest = FieldSet(name="rest", protective=BOX, linear=(-1.0, 1.0), theta=(-1.0, 1.0))
    fields = fields_of(slow, left, rest)
    parts = {(part.linear, part.theta) for part in fields.remaining("rest")}
    assert parts == {((-1.0, -0.5), (-1.0, 0.0)), ((0.5, 1.0), (-1.0, 0.0))}
    assert fields.remaining("rest", (-0.4, 0.4)) == ()
    assert fields.remaining("slow") == (slow,)
    assert fields_of(rest, slow).remaining("slow", theta=(-1.0, 1.0)) == ()


def test_the_load_and_the_direction_hide_a_set_together():
    keys = {"protective": BOX}
    loaded, empty = (FieldSet(name=str(on), load=on, **keys) for on in (True, False))
    every = FieldSet(name="every", **keys)
    assert fields_of(loaded, every).remaining("every") == (every,)
    assert fields_of(loaded, empty, every).remaining("every") == ()
    half = FieldSet(name="half", direction=(0.0, math.pi), **keys)
    other = FieldSet(name="other", direction=(-math.pi, 0.0), **keys)
    around = FieldSet(name="around", direction=(-math.pi, math.pi), **keys)
    (part,) = fields_of(half, around).remaining("around")
    assert part.direction == (-math.pi, 0.0)
    assert fields_of(half, other, around).remaining("around") == ()


def test_at_rest_and_in_directions_that_do_not_occur_nothing_is_missing():
    ahead = FieldSet(name="ahead", protective=BOX, direction=(-0.1, 0.1))
    assert fields_of(ahead).gaps((0.0, 0.0), (-1.0, 1.0)) == ()
    assert fields_of(ahead).gaps((0.0, 1.0), directions=(0.0,)) == ()
    gaps = fields_of(ahead).gaps((0.0, 1.0), directions=(0.0, math.pi))
    assert {gap.direction for gap in gaps} == {(math.pi, math.pi)}


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"protective": BOX[:2]}, "a: protective must have 3 corners or more, not 2"),
        (
            {"protective": [(0, 0), (1, 1), (1, 0), (0, 1)]},
            "a: protective must be a polygon whose edges do not cross or touch",
        ),
        (
            {"protective": [(0, 0), (1, 1), (1, math.nan)]},
            "a: protective must be finite, not (1.0, nan)",
        ),
        ({"warning": [(0, 0), (1, 1)]}, "a: warning must have 3 corners or more, not 2"),
        ({"protective": 3}, "a: protective must be a list of corners (x, y), not 3"),
        ({"linear": (1, 0)}, "a: linear must not begin above its end, found 1 to 0"),
        ({"linear": 1}, "a: linear must be a minimum and a maximum, not 1"),
        ({"theta": (math.nan, 0)}, "a: theta must not begin above its end, found nan to 0"),
        (
            {"direction": (0, 7)},
            "a: direction must be more than nothing and at most a turn, not (0, 7)",
        ),
        ({"load": 3}, "a: load must be true or false, not 3"),
        ({"name": ""}, "name of a field set must be a text, not ''"),
    ],
)
def test_an_invalid_set_is_rejected(keys, message):
    with pytest.raises(UserError) as why:
        FieldSet(**{"name": "a", "protective": BOX, **keys})
    assert str(why.value) == message


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"sets": ()}, "sets must have a field set"),
        (
            {"sets": [FieldSet(name="a", protective=BOX)] * 2},
            "sets must have different names, not 'a' twice",
        ),
        (
            {
                "sets": [
                    FieldSet(name="a", protective=BOX),
                    FieldSet(name="b", protective=BOX, direction=(0, 1)),
                ]
            },
            "either all sets must have a direction or none",
        ),
        (
            {"sets": [FieldSet(name="a", protective=BOX)], "response_time": -1},
            "response_time must be 0 or more, not -1",
        ),
    ],
)
def test_invalid_fields_are_rejected(keys, message):
    with pytest.raises(UserError) as why:
        ProtectiveFields(**keys)
    assert str(why.value) == message


def drive():
    """Return the motion of a vehicle that accelerates from rest, drives, and stops."""
    return vehicle_segment((0.0, 0.0, 0.0), (6.0, 0.0), limits=VehicleLimits(jerk=math.inf))


SLOW = FieldSet(name="slow", protective=BOX, linear=(-0.1, 0.5))
FAST = FieldSet(name="fast", protective=BOX, linear=(0.5, 2.0))


def test_at_the_instant_of_a_switch_the_next_set_applies():
    fields, machine = fields_of(SLOW, FAST), drive()
    _, (begin, _, fast), _ = fields.applying(machine, 0.0, 20.0)
    assert fields.applying(machine, begin, begin) == ((begin, begin, fast),)
    assert [s.set.name for s in fields.applying(machine, 0.0, 0.0)] == ["slow"]
    assert [s.set.name for s in fields.applying(machine, begin - 1e-6, begin)] == ["slow"]
    assert [s.set.name for s in fields.applying(machine, begin, begin + 1e-6)] == ["fast"]


def test_fields_of_different_kinds_are_compared_with_one_motion():
    machine = drive()
    for fields, names in (
        (fields_of(SLOW, FAST), ["slow", "fast", "slow"]),
        (box(), ["box"]),
        (fields_of(FAST), [None, "fast", None]),
        (fields_of(SLOW, FAST), ["slow", "fast", "slow"]),
    ):
        spans = fields.applying(machine, 0.0, 20.0)
        assert [span.set and span.set.name for span in spans] == names
        assert [a.end == b.begin for a, b in pairwise(spans)] == [True] * (len(names) - 1)


def covering(each, loaded, speed, turn, angle):
    """Return whether a set applies at a velocity, by its definition."""
    if each.load not in (None, loaded):
        return False
    if each.direction is not None:
        first, last = each.direction
        if not any(first <= angle + k * math.tau <= last for k in (-2, -1, 0, 1, 2)):
            return False
    (low, high), (left, right) = each.linear, each.theta
    return low <= speed <= high and left <= turn <= right


@pytest.mark.parametrize("seed", range(40))
def test_gaps_contain_exactly_the_velocities_without_a_set(seed):
    rng = np.random.default_rng(seed)
    directed = bool(seed % 2)
    sets = []
    for k in range(rng.integers(1, 5)):
        keys = {
            "linear": tuple(sorted(rng.choice(np.arange(-6, 7) / 4, 2, replace=False).tolist())),
            "theta": tuple(sorted(rng.choice(np.arange(-6, 7) / 4, 2, replace=False).tolist())),
            "load": [None, True, False][rng.integers(3)],
        }
        if directed:
            first = float(rng.uniform(-4, 4))
            keys["direction"] = (first, first + float(rng.uniform(0.5, math.tau)))
        sets.append(FieldSet(name=f"s{k}", protective=BOX, **keys))
    gaps = fields_of(*sets).gaps((-1.0, 1.25), (-0.75, 1.5))
    for speed, turn, angle in rng.uniform([-1, -0.75, 0], [1.25, 1.5, math.tau], (80, 3)):
        for loaded in (False, True):
            inside = [
                gap
                for gap in gaps
                if gap.loaded == loaded
                and gap.linear[0] <= speed <= gap.linear[1]
                and gap.theta[0] <= turn <= gap.theta[1]
                and (gap.direction is None or gap.direction[0] <= angle <= gap.direction[1])
            ]
            applies = any(covering(each, loaded, speed, turn, angle) for each in sets)
            assert len(inside) == (not applies), (speed, turn, angle, loaded)


def test_a_gap_is_one_range_of_speeds_however_many_sets_end_within_it():
    left = FieldSet(name="left", protective=BOX, linear=(0.0, 1.0), theta=(0.0, 1.0))
    gaps = fields_of(left).gaps((-1.0, 2.0), (-1.0, 1.0))
    assert [(g.linear, g.theta) for g in gaps if not g.loaded] == [
        ((-1.0, 2.0), (-1.0, 0.0)),
        ((-1.0, 0.0), (0.0, 1.0)),
        ((1.0, 2.0), (0.0, 1.0)),
    ]


@pytest.mark.parametrize(("between", "count"), [(0.0, 0), (1e-9, 0), (5e-5, 0), (2e-3, 2)])
def test_rounding_between_two_directions_is_no_gap(between, count):
    one = FieldSet(name="one", protective=BOX, direction=(0.0, 2.0))
    other = FieldSet(name="other", protective=BOX, direction=(2.0 + between, math.tau))
    assert len(fields_of(one, other).gaps((0.0, 1.0))) == count


def test_gaps_tolerate_the_rounding_of_limits():
    rounded = FieldSet(name="rounded", protective=BOX, linear=(-0.99995, 0.99995))
    assert fields_of(rounded).gaps((-1.0, 1.0)) == ()
    short = FieldSet(name="short", protective=BOX, linear=(-0.9, 0.9998))
    assert [g.linear for g in fields_of(short).gaps((-1.0, 1.0)) if g.loaded] == [
        (-1.0, -0.9),
        (0.9998, 1.0),
    ]


def test_the_reach_is_the_farthest_corner_of_any_field():
    wide = FieldSet(name="wide", protective=BOX, warning=[(3.0, -4.0), (3.0, 4.0), (-1.0, 0.0)])
    assert fields_of(FieldSet(name="box", protective=BOX), wide).reach == pytest.approx(5.0)
    assert box().reach == pytest.approx(math.hypot(2.0, 0.5))


def test_a_set_may_cover_all_directions_and_repeat_its_first_corner():
    around = FieldSet(name="all", protective=[*BOX, BOX[0]], direction=(0.0, math.tau))
    assert around.protective == BOX
    for wrong in ((1.0, 1.0), (0.0, math.tau + 0.01)):
        with pytest.raises(UserError, match="direction"):
            FieldSet(name="all", protective=BOX, direction=wrong)
    with pytest.raises(UserError, match="response_time"):
        ProtectiveFields(sets=[around], response_time=math.inf)


class CountedReads:
    """Motion that counts accesses to its table."""

    def __init__(self, motion):
        self.start, self.end, self._table, self.count = motion.start, motion.end, motion.table, 0

    @property
    def table(self):
        self.count += 1
        return self._table


def test_the_switches_of_a_motion_are_computed_once_for_all_people_beside_it():
    fields, machine = fields_of(SLOW, FAST), CountedReads(drive())
    first = fields.applying(machine, 0.0, 20.0)
    reads = machine.count
    assert [fields.applying(machine, 0.0, 20.0) for _ in range(2)] == [first, first]
    assert machine.count == reads
    fields.applying(machine, 0.0, 20.0, loaded=True)
    assert machine.count > reads
