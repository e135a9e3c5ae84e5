"""Claimants alone: their claims, waits and evasions."""

import math

import pytest
import shapely
from traffic_parts import LIMITS, Floor, area_of

import navigation
from sim.core.body import TRAFFIC
from sim.machines.traffic.areas import CLEAR
from sim.machines.traffic.evading import Evasion
from sim.machines.traffic.waiting import Driving, GivingWay, WaitingForMachines

FAR = (40.0, 40.0)


@pytest.fixture
def floor():
    return Floor()


def clear_of(cart, begin, end):
    """Return the area that a cart covers, enlarged by its distance from claims."""
    return cart.covered(begin, end).buffer(CLEAR, join_style="mitre")


def test_a_machine_claims_the_next_second_and_every_stop_from_there(floor):
    cart, other = floor.cart("cart", 0.0), floor.cart("other", *FAR)
    of = floor.traffic(cart, other)
    cart.drive((20.0, 0.0, 0.0))
    for k in range(1, 8):
        floor.until(k + 0.5)
        claim = area_of(of["cart"].claim)
        motion, end = cart.body.motion, float(k + 1)
        stop = cart.stopping(motion.state(end), end)
        ahead = float(stop.position(stop.end)[0]) + 0.5 + CLEAR
        behind = float(motion.position(float(k))[0]) - 0.5 - CLEAR
        assert claim.bounds == pytest.approx((behind, -0.31, ahead, 0.31), abs=1e-6)


def test_a_machine_at_rest_claims_its_footprint_alone(floor):
    cart, other = floor.cart("cart", 0.0), floor.cart("other", *FAR)
    of = floor.traffic(cart, other)
    cart.drive((2.0, 0.0, 0.0))
    end = cart.body.motion.end
    floor.until(end + 0.001)
    claim = area_of(of["cart"].claim)
    assert claim.bounds == pytest.approx((1.49, -0.31, 2.51, 0.31), abs=1e-6)


def test_a_stopped_machine_claims_its_braking_and_then_its_footprint(floor):
    cart, other = floor.cart("cart", 0.0), floor.cart("other", *FAR)
    of = floor.traffic(cart, other)
    cart.drive((20.0, 0.0, 0.0))
    floor.until(3.2)
    cart.stand_for("people", True)
    begin, end = (float(cart.body.motion.position(t)[0]) for t in (3.2, cart.body.motion.end))
    assert area_of(of["cart"].claim).bounds == pytest.approx(
        (begin - 0.51, -0.31, end + 0.51, 0.31), abs=1e-6
    )
    floor.until(cart.body.motion.end + 0.01)
    assert area_of(of["cart"].claim).bounds == pytest.approx(
        (end - 0.51, -0.31, end + 0.51, 0.31), abs=1e-6
    )
    floor.until(9.0)
    cart.stand_for("people", False)
    assert area_of(of["cart"].claim).bounds[2] > end + 0.6


def test_the_course_of_a_machine_that_was_stopped_leads_to_its_goal(floor):
    cart, other = floor.cart("cart", 0.0), floor.cart("other", *FAR)
    of = floor.traffic(cart, other)
    cart.drive((20.0, 0.0, 0.0))
    floor.until(3.0)
    left_at = float(cart.body.motion.position(3.0)[0])
    assert of["cart"].course.bounds[2] == pytest.approx(20.51, abs=1e-3)
    cart.stand_for("people", True)
    for t in (6.0, 9.0):
        floor.until(t)
        # Replace the motion of the stopped cart, as a correction of its position does.
        cart.body.follow(navigation.standing(cart.body.at, start=t))
        course = area_of(of["cart"].course)
        way = shapely.LineString([cart.body.at, (20.0, 0.0)])
        assert course.covers(way)
    cart.stand_for("people", False)
    floor.until(12.0)
    x = cart.body.at[0]
    assert area_of(of["cart"].course).bounds[0] == pytest.approx(x - 0.51, abs=1.6)
    assert not area_of(of["cart"].course).covers(shapely.Point(left_at, 0.0))


def test_a_path_is_no_course_unless_it_leads_to_the_goal(floor):
    cart, other = floor.cart("cart", 0.0), floor.cart("other", *FAR)
    of = floor.traffic(cart, other)
    cart.drive((10.0, 0.0, 0.0))
    floor.until(1.0)
    cart.body.follow(cart.stopping(cart.body.state, 1.0))
    assert of["cart"].course.bounds[2] == pytest.approx(10.51, abs=1e-3)
    floor.until(4.0)
    cart.to = None
    cart.body.follow(navigation.standing(cart.body.at, start=4.0))
    assert of["cart"].course.bounds[2] == pytest.approx(cart.body.at[0] + 0.51, abs=1e-3)


def test_a_wide_course_has_the_distance_that_others_keep(floor):
    cart, other = floor.cart("cart", 0.0), floor.cart("other", *FAR)
    of = floor.traffic(cart, other)
    bounds = shapely.union_all(of["cart"].wide_course).bounds
    assert bounds == pytest.approx((-0.61, -0.41, 0.61, 0.41), abs=1e-6)


@pytest.mark.parametrize(
    ("beside", "waits"), [(0.6, True), (0.64, True), (0.67, False), (0.8, False)]
)
def test_a_machine_keeps_five_centimetres_from_the_claims_of_others(floor, beside, waits):
    cart, other = floor.cart("cart", 0.0), floor.cart("other", 5.0, beside)
    of = floor.traffic(cart, other)
    cart.drive((10.0, 0.0, 0.0))
    floor.until(8.0)
    assert (of["cart"].waiting is not None) is waits
    assert cart.waits is waits
    assert cart.covered(0.0, 8.0).disjoint(other.covered(0.0, 8.0))


def test_a_machine_that_is_nearer_already_leaves_with_a_smaller_distance(floor):
    cart, other = floor.cart("cart", 0.0), floor.cart("other", 0.0, 0.625)
    of = floor.traffic(cart, other)
    cart.drive((10.0, 0.0, 0.0))
    floor.until(1.0)
    assert of["cart"].waiting is None and cart.body.state.speed > 0.0


def test_a_machine_waits_continues_and_counts_its_time(floor):
    cart, other = floor.cart("cart", 0.0), floor.cart("other", 6.0)
    of = floor.traffic(cart, other)
    cart.drive((12.0, 0.0, 0.0))
    floor.until(10.0)
    ((since, waiting),) = floor.recorded("MachineWaiting")
    assert (waiting.machine, waiting.for_machine) == ("cart", "other")
    assert cart.body.at[0] < 5.0 - 0.06
    other.drive((6.0, 0.0, math.pi / 2), (6.0, 5.0, math.pi / 2))
    floor.until(30.0)
    ((until, proceeds),) = floor.recorded("MachineProceeds")
    assert proceeds.waited == pytest.approx(until - since)
    assert of["cart"].waiting_time == pytest.approx(until - since)
    assert cart.body.at == pytest.approx((12.0, 0.0), abs=1e-6)
    assert cart.times("detour") == [] or min(cart.times("detour")) > since


def test_a_wait_until_the_end_of_the_trial_is_counted(floor):
    cart, other = floor.cart("cart", 0.0), floor.cart("other", 6.0)
    of = floor.traffic(cart, other)
    cart.drive((12.0, 0.0, 0.0))
    floor.until(40.0)
    ((since, _),) = floor.recorded("MachineWaiting")
    floor.of.close()
    assert of["cart"].waiting_time == pytest.approx(40.0 - since)
    assert floor.of.waiting_times == {"cart": of["cart"].waiting_time, "other": 0.0}


def test_a_stationary_machine_is_asked_to_make_way_before_a_detour(floor):
    cart, other = floor.cart("cart", 0.0), floor.cart("other", 6.0)
    floor.traffic(cart, other)
    cart.drive((12.0, 0.0, 0.0))
    floor.until(400.0)
    ((_, wait),) = floor.recorded("MachineWaiting")
    assert wait.for_machine == "other"
    first, *_ = cart.times("detour")
    # The first search is at rest. Each later interval doubles, up to two minutes.
    gaps = [0.0, 5.0, 15.0, 35.0, 75.0, 155.0, 275.0, 395.0]
    expected = [first + gap for gap in gaps if first + gap < 400.0]
    assert [*dict.fromkeys(cart.times("detour"))] == pytest.approx(expected)
    assert other.times("make_way") == pytest.approx(expected)
    allowed = [most for kind, _, _, most in cart.asked if kind == "detour"]
    assert set(allowed[:3]) == {5.0} and set(allowed[3:]) == {math.inf}


def test_detours_are_searched_around_claims_with_three_margins(floor):
    cart, other, far = (floor.cart(name, x) for name, x in (("cart", 0), ("other", 6), ("far", 90)))
    floor.traffic(cart, other, far)
    cart.drive((12.0, 0.0, 0.0))
    floor.until(cart_rests(cart, floor) + 0.1)
    taken = [areas for kind, _, areas, _ in cart.asked if kind == "detour"]
    assert [len(areas) for areas in taken] == [1, 1, 1]
    widths = [areas[0].bounds[3] - 0.3 for areas in taken]
    assert widths == pytest.approx([0.06, 0.02, 0.01], abs=1e-6)


def cart_rests(cart, floor):
    """Return when a waiting cart comes to rest (s)."""
    t = 0.0
    while not cart.waits:
        t += 0.25
        floor.until(t)
    return cart.body.motion.end


def test_a_detour_ends_the_wait(floor):
    cart, other = floor.cart("cart", 0.0), floor.cart("other", 6.0)
    of = floor.traffic(cart, other)
    cart.drive((12.0, 0.0, 0.0))
    rests = cart_rests(cart, floor)
    cart.can_detour = True
    there = float(cart.body.motion.position(rests)[0])
    cart.left = (
        (there, 0.0, math.pi / 2),
        (there, 2.0, math.pi / 2),
        (there, 2.0, 0.0),
        (12.0, 2.0, 0.0),
    )
    floor.until(30.0)
    ((t, evades),) = floor.recorded("MachineEvades")
    assert t == pytest.approx(rests) and (evades.machine, evades.for_machine) == ("cart", "other")
    assert of["cart"].waiting is None and cart.body.at == pytest.approx((12.0, 2.0))


def test_a_controller_that_leaves_ends_the_wait(floor):
    cart, other = floor.cart("cart", 0.0), floor.cart("other", 6.0)
    of = floor.traffic(cart, other)
    cart.drive((12.0, 0.0, 0.0))
    rests = cart_rests(cart, floor)
    floor.until(rests + 1.0)
    x = cart.body.at[0]
    cart.left = ()
    cart.stand_for(TRAFFIC, False)  # as a command to a machine that only waits does
    cart.drive((x - 2.0, 0.0, 0.0))
    floor.until(rests + 1.5)
    assert of["cart"].waiting is None and len(floor.recorded("MachineProceeds")) == 1
    floor.until(rests + 20.0)
    assert cart.body.at[0] == pytest.approx(x - 2.0)


def two_head_on(floor, **keys):
    """Two carts that drive at each other on one line, and a third one far away."""
    left, right = floor.cart("left", 0.0, **keys), floor.cart("right", 20.0, rotation=math.pi)
    of = floor.traffic(left, right, floor.cart("far", *FAR))
    left.drive((19.0, 0.0, 0.0))
    right.drive((1.0, 0.0, math.pi))
    return left, right, of


def test_machines_that_cannot_evade_are_a_deadlock_at_their_second_search(floor):
    left, right, _ = two_head_on(floor)
    floor.until(60.0)
    ((t, deadlock),) = floor.recorded("TrafficDeadlock")
    assert sorted(deadlock.machines) == ["left", "right"] and floor.of.deadlocks == 1
    rests = max(one.body.motion.end for one in (left, right))
    assert t >= rests + 4.0
    assert left.times("evade") and right.times("evade")
    assert left.covered(0.0, 60.0).disjoint(right.covered(0.0, 60.0))


@pytest.mark.parametrize("priority", [0, 1])
def test_the_machine_of_lower_rank_is_asked_first_to_evade(floor, priority):
    left, right, _ = two_head_on(floor, priority=priority)
    floor.until(20.0)
    first = [(name, one.times("evade")[0]) for name, one in (("left", left), ("right", right))]
    earliest = min(first, key=lambda pair: (pair[1], 0))
    assert earliest[1] == max(one.times("evade")[0] for one in (left, right)) or earliest[0]
    # At equal priority, the first machine in the trial has the right of way.
    assert left.asked and right.asked


def test_an_evading_machine_lets_machines_of_higher_rank_pass(floor):
    left, right, of = two_head_on(floor)
    rests = max(cart_rests(one, floor) for one in (left, right))
    x = right.body.motion.position(99.0)[0]
    right.evasion = Evasion(aside=(x, 1.2, math.pi / 2))
    right.left = (
        (x, 0.0, math.pi / 2),
        (x, 1.2, math.pi / 2),
        (x, 0.0, math.pi / 2),
        (x, 0.0, math.pi),
        (1.0, 0.0, math.pi),
    )
    floor.until(rests + 0.5)
    ((_, evades),) = floor.recorded("MachineEvades")
    assert (evades.machine, evades.for_machine, evades.to) == ("right", "left", (x, 1.2))
    assert of["right"].lets_pass == {of["left"]: left.goal}
    assert of["left"].lets_pass == {}
    floor.until(60.0)
    assert left.body.at == pytest.approx((19.0, 0.0))
    assert right.body.at == pytest.approx((1.0, 0.0), abs=1e-6)
    # The right cart waited at the passing place until the left one had passed.
    waits, proceeds = (
        floor.recorded(f"Machine{kind}", machine="right") for kind in ("Waiting", "Proceeds")
    )
    assert waits[-1][1].for_machine == "left"
    assert left.body.track().position(proceeds[-1][0])[0] > x
    assert floor.of.deadlocks == 0


def claimants(floor, count, *, priorities=()):
    """Return carts at rest with goals, far from each other, and their claimants."""
    carts = [
        floor.cart(f"c{k}", 3.0 * k, priority=priorities[k] if priorities else 0)
        for k in range(count)
    ]
    of = floor.traffic(*carts)
    for k, cart in enumerate(carts):
        floor.until(0.01 * (k + 1))
        cart.drive((3.0 * k, 0.0, 1.0 - 0.1 * k))
    floor.until(9.0)
    for cart in carts:
        cart.to = (99.0, 99.0)
        cart.body.follow(navigation.standing(cart.body.at, heading=1.0, start=9.0))
    return carts, [of[cart.name] for cart in carts]


def evading(floor, carts, all_of, k, to=(50.0, 50.0, 0.0)):
    """Make claimant `k` wait for the previous one, and return whether it can evade all of them."""
    floor.until(10.0)
    mine = all_of[k]
    ahead = [[carts[k].body.state.position]]
    mine.state = WaitingForMachines(ahead, [all_of[k - 1]], 9.0, Driving())
    carts[k].evasion = Evasion(aside=to)
    carts[k].to = (77.0, 7.0)
    mine.goal = carts[k].goal
    return mine.evade(all_of)


def test_a_machine_of_middle_rank_lets_only_higher_ranks_pass(floor):
    carts, of = claimants(floor, 3, priorities=(2, 1, 0))
    assert evading(floor, carts, of, 1)
    assert set(of[1].lets_pass) == {of[0]}


def test_the_machine_of_the_highest_rank_gives_up_its_right_of_way(floor):
    carts, of = claimants(floor, 3)
    first = max(of, key=lambda one: one.rank)
    assert first is of[0]
    of[1].lets_pass = {of[0]: carts[0].goal}
    assert evading(floor, carts, of, 0)
    assert set(of[0].lets_pass) == {of[1], of[2]}
    assert of[0].rank < of[1].rank and of[0].rank < of[2].rank
    assert of[1].lets_pass == {}  # no machine waits for it to pass


def test_a_machine_with_a_new_goal_lets_no_others_pass(floor):
    carts, of = claimants(floor, 2)
    assert evading(floor, carts, of, 1) and of[1].lets_pass
    floor.until(20.0)
    carts[1].drive((3.0, 0.0, math.pi / 2), (3.0, 8.0, math.pi / 2))
    assert of[1].goal == (3.0, 8.0) and of[1].lets_pass == {}


def test_a_machine_evades_once_at_a_time_and_at_rest_only(floor):
    carts, of = claimants(floor, 2)
    carts[1].evasion = None
    assert not of[1].evade(of) and not of[1].evade(of)
    assert len(carts[1].times("evade")) == 3  # one search, with three margins
    floor.until(10.0)
    assert not of[1].evade(of)
    assert len(carts[1].times("evade")) == 6
    floor.until(11.0)
    carts[1].drive_on((3.0, 0.0, 2.0))
    floor.until(11.2)
    assert not of[1].rests and not of[1].evade(of)
    assert len(carts[1].times("evade")) == 6


def test_passing_places_are_off_the_courses_of_others(floor):
    carts, of = claimants(floor, 3)
    carts[2].evasion = None
    of[2].evade(of[:2] + of[2:])
    _, _, taken, courses = carts[2].asked[-1]
    assert len(taken) == 2
    covered = shapely.union_all(courses)
    assert covered.covers(shapely.Point(carts[0].body.at))
    assert covered.covers(shapely.Point(carts[1].body.at))
    assert not covered.intersects(shapely.Point(carts[2].body.at))


def test_ranks_are_by_priority_then_by_time_under_way_then_by_order(floor):
    carts = [floor.cart(name, 5.0 * k) for k, name in enumerate("abcd")]
    carts[3].priority = 1
    of = floor.traffic(*carts)
    floor.until(1.0)
    carts[1].drive((5.0, 0.0, math.pi / 2), (5.0, 3.0, math.pi / 2))
    assert sorted(of, key=lambda name: of[name].rank) == ["b", "c", "a", "d"]
    floor.until(2.0)
    carts[0].drive((0.0, 0.0, 0.5))
    assert sorted(of, key=lambda name: of[name].rank) == ["a", "b", "c", "d"]
    carts[0].drive((0.0, 0.0, 0.7))  # the same place is no new goal
    assert of["a"].rank[1] == -2.0
    carts[2].to = (10.0, 0.0)
    carts[2].body.follow(navigation.standing((10.0, 0.0), start=2.0))
    assert sorted(of, key=lambda name: of[name].rank) == ["c", "a", "b", "d"]


def test_machines_that_are_near_are_within_six_metres(floor):
    carts = [floor.cart(name, x) for name, x in (("a", 0.0), ("b", 6.9), ("c", 7.2))]
    of = floor.traffic(*carts)
    assert of["a"].is_near([of["b"]]) and not of["a"].is_near([of["c"]])
    assert of["a"].is_near([of["c"], of["b"]])
    assert len(of["a"].taken(0.05)) == 1 and len(of["b"].taken(0.05)) == 2
    assert of["a"].taken(0.05)[0].bounds == pytest.approx((6.34, -0.36, 7.46, 0.36))


def test_a_machine_makes_way_around_claims_and_off_the_course(floor):
    cart, idle = floor.cart("cart", 0.0), floor.cart("idle", 6.0)
    floor.traffic(cart, idle)
    idle.can_make_way = True
    cart.drive((12.0, 0.0, 0.0))
    rests = cart_rests(cart, floor)
    floor.until(rests + 0.1)
    (query,) = idle.asked
    kind, t, taken, courses = query
    assert kind == "make_way" and t == pytest.approx(rests)
    assert shapely.union_all(taken).covers(cart.shape.footprint(cart.body.at, 0.0))
    assert shapely.union_all(courses).covers(shapely.LineString([cart.body.at, (12.0, 0.0)]))
    assert cart.times("detour") == [] and cart.times("evade") == []
    floor.until(rests + 6.0)
    assert len(idle.asked) == 2  # the search is repeated, because the other machine moves


def test_machines_in_a_queue_continue_one_after_the_other(floor):
    first, second, third = (floor.cart(name, x) for name, x in (("a", 0), ("b", 3), ("c", 6)))
    floor.traffic(first, second, third)
    first.drive((20.0, 0.0, 0.0))
    second.drive((22.0, 0.0, 0.0))
    floor.until(9.0)
    assert second.waits and first.waits
    third.drive((24.0, 0.0, 0.0))
    floor.until(60.0)
    ends = [one.body.at[0] for one in (first, second, third)]
    assert ends == pytest.approx([20.0, 22.0, 24.0])
    assert len(floor.recorded("MachineProceeds", machine="a")) >= 1


def test_a_machine_is_not_held_by_claims_behind_it(floor):
    cart, behind = floor.cart("cart", 0.0), floor.cart("behind", -1.2)
    of = floor.traffic(cart, behind)
    cart.drive((9.0, 0.0, 0.0))
    floor.until(1.0)
    behind.drive((6.0, 0.0, 0.0))
    floor.until(40.0)
    assert of["cart"].waiting_time == 0.0
    assert behind.body.at == pytest.approx((6.0, 0.0))


def test_a_machine_without_evasion_keeps_no_margin(floor):
    assert LIMITS.speed == 1.5
    cart = floor.cart("cart", 0.0)
    other = floor.cart("other", 5.0, 0.615)
    cart.__class__ = type("Fixed", (cart.__class__.__mro__[2],), dict(vars(type(cart))))
    of = floor.traffic(cart, other)
    cart.drive((10.0, 0.0, 0.0))
    floor.until(12.0)
    assert of["cart"].waiting is None
    assert cart.body.at == pytest.approx((10.0, 0.0))


def courteous(floor):
    """Return two carts: the first waits to cross the course of the second, stopped far away."""
    cart, other = floor.cart("cart", 10.0, -5.0, math.pi / 2), floor.cart("other", 0.0)
    of = floor.traffic(cart, other)
    other.drive((20.0, 0.0, 0.0))
    floor.until(1.0)
    other.stand_for("people", True)
    floor.until(4.0)
    cart.to = (10.0, 5.0)
    of["cart"].goal = cart.to
    of["cart"].lets_pass = {of["other"]: other.goal}
    cart.drive((10.0, 5.0, math.pi / 2))
    return cart, other, of


def test_a_machine_that_lets_another_pass_does_not_cross_its_course(floor):
    cart, other, of = courteous(floor)
    floor.until(20.0)
    assert cart.waits and cart.body.at[1] < -0.8
    assert of["cart"].waiting.blockers == [of["other"]]
    other.stand_for("people", False)
    floor.until(60.0)
    assert other.body.at == pytest.approx((20.0, 0.0))
    assert cart.body.at == pytest.approx((10.0, 5.0))


def test_a_machine_with_a_new_goal_is_no_longer_let_pass(floor):
    cart, other, _ = courteous(floor)
    x = other.body.at[0]
    other.left = ()
    other.stand_for("people", False)
    other.drive((x + 30.0, 0.0, 0.0))
    floor.until(4.2)
    other.stand_for("people", True)
    floor.until(30.0)
    assert cart.body.at == pytest.approx((10.0, 5.0)) and not cart.waits


def test_on_the_way_to_a_passing_place_no_machine_is_let_pass(floor):
    cart, _, of = courteous(floor)
    of["cart"].state = GivingWay((10.0, 5.0, math.pi / 2))
    floor.until(30.0)
    assert cart.body.at == pytest.approx((10.0, 5.0))
    assert of["cart"].state == Driving()


def test_a_machine_searches_at_once_when_a_blocker_leaves(floor):
    cart, near, beside = (
        floor.cart(name, *at)
        for name, at in (("cart", (0.0, 0.0)), ("near", (6.0, 0.5)), ("beside", (6.0, -0.5)))
    )
    of = floor.traffic(cart, near, beside)
    cart.drive((12.0, 0.0, 0.0))
    rests = cart_rests(cart, floor)
    floor.until(rests + 7.0)
    looks = [*dict.fromkeys(cart.times("detour"))]
    assert looks == pytest.approx([rests, rests + 5.0])
    assert {one.name for one in of["cart"].waiting.blockers} == {"near", "beside"}
    near.drive((6.0, 0.5, math.pi / 2), (6.0, 9.0, math.pi / 2))
    floor.until(rests + 16.0)
    looks = [*dict.fromkeys(cart.times("detour"))][2:]
    assert looks and rests + 7.0 < looks[0] < rests + 12.0
    floor.until(looks[-1] + 5.1)
    again = [*dict.fromkeys(cart.times("detour"))]
    assert again[-1] == pytest.approx(looks[-1] + 5.0)
    assert [one.name for one in of["cart"].waiting.blockers] == ["beside"]


def test_attempts_of_the_controller_do_not_restart_a_wait(floor):
    cart, other = floor.cart("cart", 0.0), floor.cart("other", 6.0)
    of = floor.traffic(cart, other)
    cart.drive((12.0, 0.0, 0.0))
    rests = cart_rests(cart, floor)
    ((since, _),) = floor.recorded("MachineWaiting")
    for k in range(1, 4):
        floor.until(rests + k)
        cart.stand_for(TRAFFIC, False)  # a command to continue on the same line
        floor.until(rests + k + 0.5)
        assert cart.waits and of["cart"].waiting.since == since
    assert len(floor.recorded("MachineWaiting")) == 1
    other.drive((6.0, 0.0, math.pi / 2), (6.0, 9.0, math.pi / 2))
    floor.until(rests + 30.0)
    ((until, proceeds),) = floor.recorded("MachineProceeds")
    assert proceeds.waited == pytest.approx(until - since)


def test_a_vehicle_that_keeps_making_way_is_asked_every_five_seconds(floor):
    cart, idle = floor.cart("cart", 0.0), floor.cart("idle", 6.0)
    floor.traffic(cart, idle)
    idle.can_make_way = True
    cart.drive((12.0, 0.0, 0.0))
    rests = cart_rests(cart, floor)
    floor.until(rests + 21.0)
    assert idle.times("make_way") == pytest.approx([rests + 5.0 * k for k in range(5)])


def test_an_evasion_without_a_passing_place_lets_no_machine_pass(floor):
    carts, of = claimants(floor, 2)
    assert evading(floor, carts, of, 1, to=None)
    assert of[1].lets_pass == {}


def test_machines_that_are_let_pass_keep_a_free_course(floor):
    carts, of = claimants(floor, 3)
    of[1].lets_pass = {of[2]: of[2].goal}
    assert evading(floor, carts, of[:2], 1)
    courses = shapely.union_all(carts[1].asked[-1][3])
    assert courses.covers(shapely.Point(carts[2].body.at))


def test_a_deadlock_counts_again_after_it_was_resolved(floor):
    left, right, _ = two_head_on(floor)
    floor.until(60.0)
    assert floor.of.deadlocks == 1
    x = left.body.at[0]
    left.stand_for(TRAFFIC, False)
    left.drive((x - 3.0, 0.0, 0.0))
    floor.until(90.0)
    left.drive((19.0, 0.0, 0.0))
    floor.until(150.0)
    assert floor.of.deadlocks == 2
    assert len(floor.recorded("TrafficDeadlock")) == 2 and right.asked
