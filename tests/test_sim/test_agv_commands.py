"""AGVs take the commands of other machines, on their lanes."""

import math

import pytest
from run_events import events
from small_floors import on_floor

import navigation
import sim

FLOOR = """\
boundary: [[0, 0], [30, 0], [30, 12], [0, 12]]
stations: {east: [27, 3]}
"""


@pytest.fixture
def simulation():
    """A cart on a lane of 20 m to the east, 2 m from its begin."""
    text = """
duration: 60
rules: observe
machines:
  cart: {kind: agv, origin: [2, 6], limits: [0, 20], locations: {far: 18}, start: 2.0}
"""
    started = sim.Simulation(sim.Trial.parse(on_floor(FLOOR, text)))
    started.start()
    return started


def cart_of(simulation, until=0.0):
    simulation.advance(until)
    return simulation.machines["cart"]


def test_an_agv_moves_to_a_position_on_its_lane(simulation):
    cart = cart_of(simulation)
    preview = cart.preview(12.0, 6.0)
    cart.move_to(12.0, 6.0)
    assert cart.body.motion.pieces == preview.pieces
    run = simulation.finish()
    (moved,) = events(run, "agv_moved")
    assert moved["to"] == pytest.approx(10.0) and moved["arrives"] == pytest.approx(preview.end)
    assert run.motions["cart"].position(60.0) == pytest.approx((12.0, 6.0))


@pytest.mark.parametrize("command", [("drive", "far"), ("move_to", 20.0, 6.0)])
def test_a_yielding_agv_waits_for_a_person_on_its_lane_whatever_the_command(command):
    text = """
duration: 60
rules: observe
people: [{name: ann, at: [6.5, 6], personality: external}]
machines:
  cart:
    {kind: agv, origin: [2, 6], limits: [0, 20], locations: {far: 18}, start: 2.0, yield: true}
"""
    started = sim.Simulation(sim.Trial.parse(on_floor(FLOOR, text)))
    started.start()
    name, *arguments = command
    getattr(cart_of(started, 1.0), name)(*arguments)
    (yielded,) = [event for event in started.events if event["kind"] == "agv_yielded"]
    assert (yielded["t"], yielded["person"]) == (1.0, "ann")


def test_a_share_of_the_speed_is_not_exceeded(simulation):
    cart = cart_of(simulation)
    cart.move_to(12.0, 6.0, speed_share=0.4)
    assert max(cart.body.motion.state(t).speed for t in (5.0, 10.0, 15.0)) == pytest.approx(0.4)


@pytest.mark.parametrize(
    ("target", "word"),
    [((12.0, 6.5), "lane"), ((12.0, 6.0, 1.0), "lane"), ((25.0, 6.0), "cart")],
)
def test_an_agv_cannot_leave_its_lane(simulation, target, word):
    cart = cart_of(simulation)
    with pytest.raises(ValueError, match=word):
        cart.move_to(*target)
    assert cart.stands and simulation.trial.commands == ()


def test_a_whole_turn_is_the_heading_of_the_lane(simulation):
    cart = cart_of(simulation)
    cart.move_to(12.0, 6.0, math.tau)
    assert cart.goal == pytest.approx((12.0, 6.0))


def test_an_agv_follows_no_other_motion(simulation):
    cart = cart_of(simulation)
    with pytest.raises(ValueError, match="lane"):
        cart.follow(navigation.standing((4.0, 6.0)))


def test_a_stopped_agv_can_resume_its_move(simulation):
    cart = cart_of(simulation)
    cart.drive("far")
    cart = cart_of(simulation, 5.0)
    cart.stop()
    stop = cart.body.motion.end
    assert cart.body.motion.state(stop).speed == 0.0 and cart.goal is None
    cart = cart_of(simulation, 20.0)
    assert cart.stands and cart.lane_position < 10.0
    cart.resume()
    cart_of(simulation, 50.0)
    assert cart.stands and cart.lane_position == pytest.approx(18.0)
    calls = [command.call for command in simulation.finish().trial.commands]
    assert calls == ["drive", "stop", "resume"]


def test_an_agv_commanded_during_a_protective_stop_drives_afterwards(simulation):
    cart = cart_of(simulation)
    cart.stand_for("test", True)
    cart.drive("far")
    cart_of(simulation, 5.0)
    assert cart.lane_position == 2.0 and cart.may_leave and not cart.stands
    cart.stand_for("test", False)
    assert cart.body.motion.end > 5.0
    cart_of(simulation, 40.0)
    assert cart.lane_position == pytest.approx(18.0)


def test_a_stop_does_not_count_as_waiting_time(simulation):
    cart = cart_of(simulation)
    waited = cart.wait(5.0)
    cart_of(simulation, 2.0)
    cart.stand_for("test", True)
    cart_of(simulation, 10.0)
    assert not waited.processed
    cart.stand_for("test", False)
    cart_of(simulation, 12.9)
    assert not waited.processed
    cart_of(simulation, 13.1)
    assert waited.processed


def test_a_new_target_replaces_the_current_run(simulation):
    cart = cart_of(simulation)
    cart.drive("far")
    cart_of(simulation, 6.0)
    cart.drive(3.0)
    assert cart.goal == pytest.approx((5.0, 6.0))
    cart_of(simulation, 40.0)
    assert cart.stands and cart.lane_position == pytest.approx(3.0)


def test_a_speed_limit_applies_to_the_current_run(simulation):
    cart = cart_of(simulation)
    cart.drive("far")
    cart_of(simulation, 5.0)
    assert cart.limit_speed(0.2)
    cart_of(simulation, 9.0)
    assert cart.body.state.speed == pytest.approx(0.2)
    cart.limit_speed(None)
    cart_of(simulation, 14.0)
    assert cart.body.state.speed == pytest.approx(1.0)
