"""Orders in a run: announced, processed and submitted, with and without people in the way."""

import json
from dataclasses import replace
from pathlib import Path

import pytest
import yaml
from bridge_parts import Client, Exchange, Workcell, served
from hypothesis import given, strategies as st
from run_events import events, figures_in_words
from sample_files import files

import sim

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
COLORS = ("blue", "green", "orange")
TYPES = ("battery", "pump", "regulator", "sensor")
SERVED = {1: ("as1", "as2"), 2: ("as1", "as2"), 3: ("as3", "as4"), 4: ("as3", "as4")}


def alone(trial, controller="oblivious"):
    return replace(trial, people=(), gantry=sim.GantryEntry(controller))


def kitting(order="A", agv=1, tray=3, to="warehouse", at=0, priority=False, **products):
    return {
        "id": order,
        "type": "kitting",
        "announcement": at if isinstance(at, dict) else {"time_condition": at},
        "priority": priority,
        "kitting_task": {
            "agv_number": agv,
            "tray_id": tray,
            "destination": to,
            "products": [
                {"type": text.split()[1], "color": text.split()[0], "quadrant": int(name[1])}
                for name, text in products.items()
            ],
        },
    }


def trial_of(*orders, bins=None, agvs=None, trays=((1, 3), (4, 8)), **more):
    data = {
        "time_limit": -1,
        "kitting_trays": {"slots": [s for s, _ in trays], "tray_ids": [t for _, t in trays]},
        "parts": {"bins": bins or {}, "agvs": agvs or {}},
        "orders": list(orders),
        **more,
    }
    return sim.Trial.parse(yaml.safe_dump(data), file="made.yaml")


def lot(text, *slots, **more):
    return {"color": text.split()[0], "type": text.split()[1], "slots": list(slots), **more}


BINS = {"bin2": [lot("red pump", 1, 2, 3)], "bin6": [lot("blue battery", 1, 2)]}


def test_the_example_from_beginning_to_end():
    run = sim.run(sim.Trial.load(EXAMPLES / "kitting.ariac.yaml"))
    assert run.summary["score"] == run.summary["best_score"] == 11 + 11 + 14
    orders = run.summary["orders"]
    assert [orders[name]["type"] for name in orders] == ["kitting", "kitting", "assembly"]
    assert orders["ASSEMBLY"]["announced"] == orders["KIT-B"]["submitted"]
    (broken,) = events(run, "robot_malfunction")
    assert broken["t"] == pytest.approx(orders["KIT-A"]["submitted"])
    assert run.duration == pytest.approx(orders["ASSEMBLY"]["submitted"])
    assert run.summary["interrupted"] is False
    placed = next(e for e in events(run, "job_done") if e["job"] == "pick_place")
    assert (placed["part"], placed["to"]) == ("red battery", "agv4")
    assert events(run, "human_started")[0]["t"] == placed["t"]


@pytest.mark.parametrize(
    "path", files("shift.ariac.yaml", real="ariac2023/trials/*.yaml"), ids=lambda path: path.stem
)
def test_files_of_the_competition_submit_all_orders(path):
    trial = sim.Trial.load(path)
    run = sim.run(alone(trial))
    orders = run.summary["orders"]
    assert all(order["submitted"] is not None for order in orders.values())
    if path.name == "sample.yaml":
        # In the kits, the only green pump is faulty. The tray counts 3 points, and the parts that
        # do not come from the conveyor 2 × 3.
        assert [order["score"] for order in orders.values()] == [6, 9, 3, 0]
    elif path.name == "shift.ariac.yaml":
        # The last order needs a part from the conveyor.
        assert [order["score"] for order in orders.values()] == [11, 11, 14, 5]
    else:
        assert run.summary["score"] == run.summary["best_score"]
    assert any(notice.line for notice in trial.notices) == (
        path.stem in ("assembly", "human_assembly", "sample", "shift.ariac")
    )


@pytest.mark.parametrize(
    "path",
    files("shift.ariac.yaml", real="ariac2023/trials/human_kitting.yaml"),
    ids=lambda path: path.stem,
)
def test_a_competition_file_has_a_person(path):
    trial = sim.Trial.load(path)
    (person,) = trial.people
    part, agv = ("blue sensor", "agv2") if path.stem == "shift.ariac" else ("blue battery", "agv4")
    assert (person.personality, person.start.part_placed) == (
        "antagonistic",
        {"part": part, "agv": agv},
    )
    assert (trial.rules, trial.gantry.controller) == (sim.RULE_SETS["ariac2023"], "pausing")
    run = sim.run(trial)
    placed = next(e for e in events(run, "job_done") if e.get("part") == part)
    assert run.summary["people"]["operator"]["started"] == placed["t"]
    assert run.summary["penalties"] > 0


def test_priority_goes_first():
    orders = (
        kitting("A", agv=1, q1="red pump"),
        kitting("B", agv=2, tray=8, q1="red pump"),
        kitting("C", agv=3, tray=1, at=5, priority=True, q1="blue battery"),
    )
    run = sim.run(alone(trial_of(*orders, bins=BINS, trays=((1, 3), (4, 8), (2, 1)))))
    submitted = [event["order"] for event in events(run, "order_submitted")]
    assert submitted.index("C") < submitted.index("B")
    assert [event["priority"] for event in events(run, "order_announced")] == [False, False, True]


def test_orders_for_one_agv_come_one_after_the_other():
    orders = (kitting("A", q1="red pump"), kitting("B", tray=8, at=1, q2="blue battery"))
    run = sim.run(alone(trial_of(*orders, bins=BINS)))
    assert run.summary["score"] == run.summary["best_score"] == 14
    assert [e["to"] for e in events(run, "agv_moved")] == ["warehouse", "kitting", "warehouse"]


def test_misplaced_parts_are_moved():
    """On the right tray lie a flipped part, a misplaced part and an unneeded part."""
    lying = [
        {"type": "pump", "color": "red", "quadrant": 1, "flipped": True},
        {"type": "pump", "color": "green", "quadrant": 2},
        {"type": "sensor", "color": "green", "quadrant": 4},
    ]
    agvs = {"agv1": {"tray_id": 7, "parts": lying}}
    order = kitting("A", tray=7, q1="red pump", q2="blue battery")
    run = sim.run(alone(trial_of(order, bins=BINS, agvs=agvs)))
    assert run.summary["score"] == run.summary["best_score"] == 11
    done = [event["job"] for event in events(run, "job_done")]
    assert done == ["dispose", "dispose", "pick_place", "pick_place"]


def test_without_tray_and_parts_the_rest_is_submitted():
    trial = trial_of(kitting("A", tray=5, q1="red pump", q2="red sensor"), bins=BINS)
    assert [notice.message for notice in trial.notices] == [
        "no red sensor is left for it: the order will be submitted without",
        "tray 5 does not exist; the kit will be made without it",
    ]
    run = sim.run(alone(trial))
    order = run.summary["orders"]["A"]
    assert (order["score"], order["missing"]) == (3, ["red sensor"])
    assert [event["text"] for event in events(run, "notice")] == [n.message for n in trial.notices]


def test_a_malfunction_is_no_penalty():
    malfunction = {
        "duration": 25.0,
        "robots_to_disable": ["ceiling_robot", "floor_robot"],
        "time_condition": 10.0,
    }
    order = kitting("A", q1="red pump")
    whole = sim.run(alone(trial_of(order, bins=BINS)))
    trial = trial_of(order, bins=BINS, challenges=[{"robot_malfunction": malfunction}])
    run = sim.run(alone(trial))
    assert run.summary["penalties"] == 0
    assert run.summary["gantry_disabled_time"] == pytest.approx(25.0)
    assert run.duration > whole.duration + 24.0
    assert "floor robot" in trial.notices[0].message


def test_a_second_malfunction_does_not_shorten_the_first():
    def malfunction(at, seconds):
        figures = {"duration": seconds, "robots_to_disable": ["ceiling_robot"]}
        return {"robot_malfunction": {**figures, "time_condition": at}}

    challenges = [malfunction(10.0, 20.0), malfunction(15.0, 5.0)]
    trial = trial_of(kitting("A", q1="red pump"), bins=BINS, challenges=challenges)
    run = sim.run(alone(trial))
    assert [event["t"] for event in events(run, "gantry_enabled")] == [30.0]


def test_orders_that_are_never_announced_do_not_prolong_the_trial():
    never = {"part_place_condition": {"type": "sensor", "color": "red", "agv": 2}}
    orders = (kitting("A", q1="red pump"), kitting("B", agv=2, tray=8, at=never, q1="red pump"))
    run = sim.run(alone(trial_of(*orders, bins=BINS)))
    assert run.summary["orders"]["B"]["announced"] is None
    assert run.duration == pytest.approx(run.summary["orders"]["A"]["submitted"])


def test_the_time_limit_ends_a_trial():
    trial = trial_of(kitting("A", q1="red pump"), bins=BINS, time_limit=20)
    run = sim.run(alone(trial))
    assert run.duration == 20.0
    assert run.summary["orders"]["A"]["submitted"] is None
    assert sim.run(alone(trial_of(kitting(q1="red pump")), "parked")).duration == 1000.0


def test_an_agv_that_is_called_away_comes_back():
    trial = alone(trial_of(kitting("A", q1="red pump"), bins=BINS))
    called = {"agv1": (sim.AgvMove(5.0, "warehouse"), sim.AgvMove(40.0, 3.0))}
    run = sim.run(replace(trial, agvs=called))
    assert run.summary["score"] == run.summary["best_score"]


def test_a_custom_trial_includes_orders(tmp_path):
    trial = sim.Trial.load(EXAMPLES / "kitting.trial.yaml")
    assert [person.name for person in trial.people] == ["anna", "ben"]
    assert (trial.rules, trial.duration, trial.until_submitted) == (sim.PAPER, 400.0, True)
    for one in (trial, sim.Trial.load(EXAMPLES / "kitting.ariac.yaml")):
        one.save(tmp_path / "again.trial.yaml")
        again = sim.Trial.load(tmp_path / "again.trial.yaml")
        assert replace(again, folder=one.folder) == one


def test_consequences_come_after_their_causes_in_the_recording_too(tmp_path):
    trial = sim.Trial.load(EXAMPLES / "kitting.ariac.yaml")
    recording = sim.Recording(tmp_path / "run")
    run = sim.run(replace(trial, duration=130.0), recording)
    recording.close()
    lines = (tmp_path / "run" / "events.jsonl").read_text().splitlines()
    assert [json.loads(line) for line in lines] == list(run.events)


parts = st.builds("{} {}".format, st.sampled_from(COLORS), st.sampled_from(TYPES))
announcements = st.floats(0, 60).map(lambda t: {"time_condition": round(t, 3)})


@st.composite
def orders(draw, name):
    kind = draw(st.sampled_from(["kitting", "assembly", "combined"]))
    agv = draw(st.integers(1, 4))
    station = draw(st.sampled_from(SERVED[agv]))
    wanted = draw(st.lists(parts, min_size=1, max_size=4, unique_by=lambda text: text.split()[1]))
    products = [{"color": text.split()[0], "type": text.split()[1]} for text in wanted]
    task = {"station": station, "products": products}
    if kind == "kitting":
        quadrants = draw(st.permutations(range(1, 5)))
        task = {
            "agv_number": agv,
            "tray_id": draw(st.integers(0, 4)),
            "destination": draw(st.sampled_from(["warehouse", "kitting", *SERVED[agv]])),
            "products": [{**p, "quadrant": q} for p, q in zip(products, quadrants, strict=False)],
        }
    elif kind == "assembly":
        same_side = [number for number, served in SERVED.items() if station in served]
        task["agv_number"] = draw(st.lists(st.sampled_from(same_side), min_size=1, unique=True))
    return {
        "id": name,
        "type": kind,
        "announcement": draw(announcements),
        "priority": draw(st.booleans()),
        f"{kind}_task": task,
    }


@st.composite
def trials(draw):
    names = [f"ORDER{k}" for k in range(draw(st.integers(1, 4)))]
    made = [draw(orders(name)) for name in names]
    for k in range(1, len(made)):
        if draw(st.booleans()):
            before = draw(st.sampled_from(names[:k]))
            made[k]["announcement"] = {"submission_condition": {"order_id": before}}
    bins = {
        f"bin{number}": [
            lot(draw(parts), slot, flipped=draw(st.booleans()))
            for slot in draw(st.sets(st.integers(1, 9), max_size=4))
        ]
        for number in draw(st.sets(st.integers(1, 8), max_size=4))
    }
    agvs = {
        f"agv{number}": {
            "tray_id": draw(st.integers(0, 4)),
            "parts": [
                {"color": text.split()[0], "type": text.split()[1], "quadrant": quadrant}
                for quadrant in draw(st.sets(st.integers(1, 4)))
                for text in [draw(parts)]
            ],
        }
        for number in draw(st.sets(st.integers(1, 4), max_size=2))
    }
    slots = draw(st.lists(st.integers(1, 6), unique=True))
    trays = [(slot, draw(st.integers(0, 4))) for slot in slots]
    return trial_of(*made, bins=bins, agvs=agvs, trays=trays)


@given(trials(), st.sampled_from(["oblivious", "pausing", "avoiding"]))
def test_every_order_of_a_valid_trial_ends_submitted(trial, controller):
    run = sim.run(alone(replace(trial, duration=10_000.0), controller))
    for name, order in run.summary["orders"].items():
        assert order["submitted"] is not None
        assert order["announced"] <= order["submitted"]
        assert 0 <= order["score"] <= order["best"]
        requested = next(one for one in trial.workload.orders if one.id == name)
        complete = len(requested.task.products) - len(order["missing"])
        if requested.kind != "kitting":
            points = 5 if requested.kind == "combined" else 3
            bonus = 0 if order["missing"] else 4 * complete
            assert order["score"] == points * complete + bonus
        else:
            bonus = 0 if order["missing"] else complete
            extra = order["score"] - (3 * complete + bonus)
            assert extra >= 0
            if not order["missing"]:
                assert extra in (0, 3)
    last = max(order["submitted"] for order in run.summary["orders"].values())
    assert run.duration == pytest.approx(last)


def test_a_bridged_trial_ends_with_its_orders_too():
    cell = Workcell(alone(trial_of(kitting("A", q1="red pump"), bins=BINS)), Exchange())
    while not cell.simulation.over:
        cell.simulation.advance(cell.now + 7.0)
    assert cell.now == pytest.approx(cell.simulation.finish().summary["orders"]["A"]["submitted"])


@pytest.mark.parametrize(
    "path",
    files("shift.ariac.yaml", real="ariac2023/trials/kitting.yaml"),
    ids=lambda path: path.stem,
)
def test_orders_are_published_as_they_are_announced(path):
    trial = replace(sim.Trial.load(path), people=())
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


def test_outcomes_of_orders_are_printed():
    orders = (
        kitting("A", q1="blue battery"),
        kitting("B", agv=2, q1="green sensor"),
        kitting("C", agv=3, q1="blue battery", at=50.0),
        kitting("D", agv=4, q1="blue battery", at=1000.0),
    )
    simulation = sim.Simulation(alone(trial_of(*orders, bins=BINS)))
    simulation.advance(60.0)
    summary = simulation.finish().summary
    said = dict(figures_in_words(summary))
    took = summary["orders"]["B"]["time"]
    assert said["score"] == "0 of 28"
    assert [said[f"order {name}"] for name in "ABCD"] == [
        "kitting: not submitted",
        f"kitting: 0 of 7, after {took:.1f} s (without green sensor)",
        "kitting: not submitted",
        "kitting: not announced",
    ]
