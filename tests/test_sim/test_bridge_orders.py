"""Orders of the ARIAC competition over the bridge."""

import pytest
from bridge_parts import Client, served

import sim
from sim.bridge.messages import conform, message_type, order_message
from sim.orders import AssemblyTask, CombinedTask, KittingTask, Order, PartType

PUMP, BATTERY = PartType("purple", "pump"), PartType("red", "battery")


@pytest.mark.parametrize(
    ("order", "expected"),
    [
        (
            Order(
                "K1",
                KittingTask(agv="agv4", tray=3, destination="warehouse", products={3: PUMP}),
                priority=True,
            ),
            {
                "type": 0,
                "priority": True,
                "kitting_task": {
                    "agv_number": 4,
                    "tray_id": 3,
                    "destination": 3,
                    "parts": [{"part": {"color": 4, "type": 11}, "quadrant": 3}],
                },
            },
        ),
        (
            Order("A1", AssemblyTask("as2", ("agv1", "agv2"), (BATTERY,))),
            {"type": 1, "assembly_task": {"agv_numbers": [1, 2], "station": 2}},
        ),
        (Order("C1", CombinedTask("as4", (PUMP,))), {"type": 2, "combined_task": {"station": 4}}),
    ],
)
def test_an_order_is_a_message_of_the_competition(order, expected):
    message = order_message(order)
    assert conform(message_type("ariac_msgs/Order"), message) == message
    assert message["id"] == order.id
    for field, value in expected.items():
        if isinstance(value, dict):
            assert value.items() <= message[field].items()
        else:
            assert message[field] == value
    for task in ("assembly_task", "combined_task"):
        for part in message[task]["parts"]:
            assert part["part"] in ({"color": 4, "type": 11}, {"color": 0, "type": 10})


def test_orders_are_published_as_they_are_announced(shared_data):
    trial = sim.Trial.load(shared_data / "ariac2023" / "trials" / "kitting.yaml")
    with served(trial, speed=0.0, hold=True) as session, Client(session.url) as client:
        client.subscribe("/ariac/orders", "/ariac/competition_state")
        assert client.message("/ariac/competition_state") == {"competition_state": 1}
        client.call("/ariac/start_competition")
        heard = []
        while not heard or heard[-1] != 4:
            said = client.hear_until(lambda said: said["op"] == "publish")
            heard.append(said["msg"].get("competition_state") or said["msg"]["id"])
        run = session.join()
    announced = [event["order"] for event in run.events if event["kind"] == "order_announced"]
    assert announced
    assert heard == [2, *announced, 3, 4]
