"""Trials written as files and read again are the same trials."""

import shutil
from dataclasses import replace
from pathlib import Path
from typing import Annotated, get_args, get_origin

import numpy as np
import pytest
import yaml
from hypothesis import given, strategies as st

import bdi
import floorplan
import sim
from floorplan.files.footprints import FootprintKeys
from floorplan.files.forms import form_keys, forms
from sim.core.entries import RecordedTrack
from sim.core.fields import Muting
from sim.core.schedule import DoorTimes
from sim.machines.gantry.controllers import CONTROLLERS
from sim.trials.keys import PersonKeys, TrialKeys
from sim.trials.rules_file import RuleForm
from sim.trials.writing import own_names

ROOT = Path(__file__).resolve().parents[2]
FLOOR = floorplan.load("ariac2023")
BINS = [o.name for o in FLOOR.obstacles if o.name.startswith("bin")]
PLACES = [*BINS, "station1", "agv1", "agv4"]

texts = st.text(st.characters(codec="utf-8", exclude_categories=["Cc", "Cs"]), max_size=12)
words = texts.map(str.strip).filter(bool)
sizes = st.floats(1e-3, 1e3)
poses = st.tuples(st.floats(-14.4, 0.4), st.floats(-7, 7), st.floats(-6, 6))
jobs = st.one_of(
    st.builds(lambda target: sim.Job("move", target=target), poses),
    st.builds(lambda seconds: sim.Job("wait", seconds=seconds), sizes),
    st.builds(lambda order: sim.Job("submit", order=order), words),
    st.builds(
        lambda pick, place, part: sim.Job("pick_place", pick=pick, place=place, part=part),
        st.sampled_from(PLACES),
        st.sampled_from(PLACES),
        words,
    ),
)
NAMED = (
    sim.Job("pick_place", pick="bin1", place="agv4", part="red: pump"),
    sim.Job("submit", order="no. 7"),
)
"""Jobs that people may wait for."""

starts = st.one_of(
    st.builds(sim.Start, time=st.floats(0, 1e6)),
    st.builds(
        lambda fields: sim.Start(None, part_placed=fields),
        st.sampled_from([{"part": "red: pump"}, {"agv": "agv4", "part": "red: pump"}]),
    ),
    st.just(sim.Start(None, order_submitted="no. 7")),
)


def apart(people):
    """Return False if one person starts on another."""
    places = [person.at for person in people if person.at]
    return len({*places}) == len(places)


people = (
    st.lists(
        st.builds(
            sim.PersonEntry,
            name=st.from_regex(r"[A-Z][A-Za-z0-9_-]{0,5}", fullmatch=True),
            personality=st.sampled_from(["helpful", "curious", "indifferent"]),
            start=starts,
            at=st.sampled_from([None, (-15.0, -10.0), (-14.0, -9.75), (-13.0, -9.75)]),
            beliefs=st.lists(st.sampled_from(["tired(3)", 'says("no: [yes]")']), max_size=2).map(
                tuple
            ),
            radius=st.none() | st.floats(0.1, 0.3),
            max_speed=st.none() | sizes,
            max_acceleration=st.none() | sizes,
        ),
        max_size=3,
        unique_by=lambda person: person.name,
    )
    .filter(apart)
    .map(tuple)
)
moves = st.lists(
    st.builds(sim.AgvMove, st.floats(0, 1e4), st.sampled_from(["kitting", "as1", 2.5])), max_size=3
).map(lambda moves: tuple(sorted(moves, key=lambda move: move.time)))
expectations = st.dictionaries(
    st.sampled_from(["penalties", "jobs_done"]), st.integers(0, 9) | st.just(">= 1.5")
)
trials = st.builds(
    sim.Trial,
    floorplan=st.just(FLOOR),
    name=words,
    duration=sizes,
    seed=st.integers(0, 2**63 - 1),
    rules=st.sampled_from([sim.PAPER, sim.RULE_SETS["ariac2023"]]),
    people=people,
    gantry=st.builds(
        sim.GantryEntry,
        controller=st.sampled_from(["parked", "oblivious"]),
        at=st.none() | poses,
        jobs=st.lists(jobs, max_size=4).map(lambda some: (*some, *NAMED)),
        repeat=st.booleans(),
    ),
    agvs=st.dictionaries(st.sampled_from(["agv1", "agv2"]), moves),
    expect=expectations,
)


@given(trials)
def test_written_trials_are_read_as_the_same_trials(trial):
    assert sim.Trial.parse(trial.to_yaml()) == trial


EVERY_KEY = """
name: every key
floorplan: ariac2023
duration: 31.5
seed: 7
rules: ariac2023
planner: {name: RRTConnect, range: 1.0}
people:
- name: ada
  personality: helpful
  start: {time: 2.5}
  at: [-15.0, -10.0]
  home: [-14.25, -9.75]
  beliefs: [tired(3)]
  radius: 0.25
  max_speed: 1.5
  max_acceleration: 2.0
  changes: [{when: {event: arrived, count: 2, person: ada}, personality: curious}]
  planner: BITstar
  manners:
    comfort: [0.1, 0.3]
    time_gap: 0.8
    foresight: 4.0
    reaction_time: 0.5
    patience: [4.0, 6.0]
    passing_side: left
    steps_aside: false
  agent_lag: [0.0, 1.05]
  work: [rounds, picks]
  schedule: [{at: station1, duration: 5.0, time: 2.0}]
  breaks: [{at: station2, duration: 4.0, name: break, time: 20.0}]
  shifts: [[0.0, 30.0]]
- name: bo
  max_speed: {normal: [1.34, 0.26]}
  noticing:
    field_of_view: [90.0, 180.0]
    occlusion: true
    reaction_time: {lognormal: [0.75, 0.3]}
  start: {part_placed: {part: pump, agv: agv1}}
  group: pair
- name: cy
  start: {order_submitted: first}
  group: pair
- name: dee
  source: {at: station1, rate: 0.5, start: 2.0, stream: guest, number: 2}
  sink: station2
- name: eve
  recorded:
    file: tracks.csv
    body: '7'
    since: 1.0
    longest_gap: 2.0
    top_speed: 5.0
    frame_rate: 25.0
    unit: m
    while_tracked: true
gantry:
  controller: oblivious
  at: [-5.0, 2.5, 0.0]
  jobs:
  - {move: [-5.0, 2.0, 0.0]}
  - {wait: 2.0}
  - {pick: bin2, place: agv1, part: pump}
  - {submit: first}
  repeat: true
  drops: [{part: pump, after: 1, delay: 2.5}]
  on_contact: report
agvs:
  agv1: [{time: 1.0, to: kitting}]
  agv2: {yield: true, moves: [{time: 3.0, to: 2.5}]}
machines:
  north: {kind: gantry, at: [-9.0, 1.0, 0.0], x: [-14.0, -8.0], controller: oblivious}
fields:
  north:
    sets:
    - name: slow
      linear: [0.0, 0.5]
      theta: [-1.0, 1.0]
      direction: [-3.2, 3.0]
      load: false
      protective: [[2.0, 1.0], [-2.0, 1.0], [-2.0, -1.0], [2.0, -1.0]]
      warning: [[3.0, 1.0], [-3.0, 1.0], [-3.0, -1.0], [3.0, -1.0]]
    response_time: 0.1
    restart_delay: 1.0
    warning_speed: 0.2
    muting: {times: [[1.0, 2.0], [4.0]]}
until_submitted: true
sources: {max_speed: measured here}
counterfactual: without machines
warm_up: 2.0
traffic: false
sign_off: {plant: hall 3, revision: b, author: me, date: 24 November}
blackouts:
- {machine: agv1, start: {event: arrived}, seconds: 4.0}
obstacles:
  pallet: {x: [-15.0, -14.0], y: [2.0, 3.0], z: [0.0, 1.0], there: [[5.0, 9.0], [20.0]]}
commands:
- {time: 3.0, send: ada, to: [-13.0, 1.0]}
- {time: 3.0, block: crate, x: [-14.0, -13.0], y: [4.0, 5.0], z: [0.0, 1.5]}
- {time: 4.0, hold: gantry}
- {time: 5.0, release: gantry}
- {time: 6.0, clear: crate}
- {time: 7.0, call: move_to, machine: north, arguments: {x: -9.0, y: 2.0}}
- {time: 8.0, call: act, person: ada, arguments: {action: stop_movement}, decision: 1}
work:
  rounds: {tasks: [{at: station1, duration: {uniform: [1.0, 2.0]}}], repeat: true}
  picks:
    tasks:
    - {at: station1, duration: 5.0, name: pick, time: 1.0, priority: 2, every: 9.0, count: 3}
    - {at: station2, duration: {triangular: [1.0, 2.0, 4.0]}}
    - {at: station2, duration: {normal: [4.0, 1.0]}}
    - {at: station2, duration: {lognormal: [4.0, 1.0]}}
    - {at: station2, duration: {exponential: 4.0}}
expect: {penalties: 0}
"""


def keys_in(form, written):
    """Return the written keys of a form and of the forms within it, as (form, key)."""
    if isinstance(written, list):
        return {key for one in written for key in keys_in(form, one)}
    keys = set()
    if not isinstance(written, dict):
        return keys
    for key, annotation in form_keys(form):
        if key in written:
            keys.add((form, key))
            value = written[key]
            bare = get_args(annotation)[0] if get_origin(annotation) is Annotated else annotation
            named = get_origin(bare) is dict and isinstance(value, dict)
            for inner in forms(annotation):
                keys |= keys_in(inner, [*value.values()] if named else value)
    return keys


def forms_below(form):
    """Return the form and all forms in its keys."""
    inner = {one for _, annotation in form_keys(form) for one in forms(annotation)}
    return {form}.union(*map(forms_below, inner - {RuleForm}))  # see test_rules_file.py


def test_every_key_is_read_and_written(tmp_path):
    (tmp_path / "tracks.csv").write_text("id,frame,x,y\n7,20,-14,-8\n7,40,-14,-8\n")
    data = yaml.safe_load(EVERY_KEY)
    keys = {(form, key) for form in forms_below(TrialKeys) for key, _ in form_keys(form)}
    shape = {"z", *(key for key, _ in form_keys(FootprintKeys))}
    keys = {(form, key) for form, key in keys if key not in shape}
    elsewhere = {(TrialKeys, key) for key in ("folder", "ariac", "begins", "steering", "actions")}
    elsewhere |= {(TrialKeys, "doors"), (DoorTimes, "closed"), (DoorTimes, "open")}
    elsewhere |= {(Muting, "zones"), (sim.GantryEntry, "rate")}
    elsewhere |= {(PersonKeys, key) for key in ("count", "actions")}
    elsewhere.add((RecordedTrack, "everybody"))  # its people are written
    elsewhere |= {(form, "count") for form, key in keys if key == "stream"}
    # Repeated moves are written one by one.
    elsewhere |= {(form, "every") for form, key in keys if key == "to"} & keys
    assert keys - keys_in(TrialKeys, data) == elsewhere
    trial = sim.Trial.parse(EVERY_KEY, folder=tmp_path)
    assert yaml.safe_load(trial.to_yaml(tmp_path)) == data


@pytest.mark.parametrize("path", sorted((ROOT / "examples").glob("*.trial.yaml")), ids=str)
def test_a_trial_saved_elsewhere_finds_its_files(path, tmp_path):
    shutil.copytree(path.parent, tmp_path / "examples")
    trial = sim.Trial.load(tmp_path / "examples" / path.name)
    # A trial that names code stays with it: see test_own_code.py.
    deep = tmp_path / ("examples" if [*own_names(trial)] else "elsewhere") / "deep"
    deep.mkdir(parents=True)
    trial.save(deep / "again.yaml")
    again = sim.Trial.load(deep / "again.yaml")
    assert again.folder.resolve() == trial.folder.resolve()
    assert replace(again, folder=trial.folder) == trial
    short = [replace(one, duration=5.0, folder=one.folder) for one in (trial, again)]
    assert sim.run(short[0]).events == sim.run(short[1]).events


def test_a_floor_without_a_file_is_written_into_the_trial(tmp_path):
    floor = replace(FLOOR, name="mine")
    trial = sim.Trial(floor, people=(sim.PersonEntry("operator"),))
    trial.save(tmp_path / "trial.yaml")
    again = sim.Trial.load(tmp_path / "trial.yaml")
    assert replace(again, folder=trial.folder) == trial
    assert "floorplan: ariac2023\n" in sim.Trial(FLOOR).to_yaml()


def test_a_floor_in_a_trial_without_a_name_has_the_name_of_the_trial():
    text = "floorplan: {boundary: [[0, 0], [9, 0], [9, 9]]}\n"
    assert sim.Trial.parse(text, file="a/lunch.trial.yaml").floorplan.name == "lunch"
    assert sim.Trial.parse(f"{text}name: noon\n").floorplan.name == "noon"


def test_faults_of_a_floor_in_a_trial_have_their_lines():
    text = "floorplan:\n  boundary: [[0, 0], [9, 0], [9, 9]]\n  stations: {gate: [0, 9]}\n"
    with pytest.raises(floorplan.FloorplanError) as wrong:
        sim.Trial.parse(text)
    (problem,) = wrong.value.problems
    assert (problem.line, problem.field) == (3, "floorplan.stations.gate")
    with pytest.raises(sim.TrialError, match="line 1, floorplan: expected a name, a file or"):
        sim.Trial.parse("floorplan: 5\n")


def test_a_name_may_be_empty():
    trial = sim.Trial.parse("name: ''\nfloorplan: ariac2023\n", file="hall.yaml")
    assert trial.name == ""
    assert sim.Trial.parse(trial.to_yaml(), file="hall.yaml").name == ""
    assert sim.Trial.parse("floorplan: ariac2023\n", file="hall.yaml").name == "hall"


def test_numbers_of_numpy_are_written_as_plain_numbers():
    numbers = sim.Trial(
        FLOOR,
        duration=np.float64(20.0),
        people=(
            sim.PersonEntry(
                "ada",
                start=sim.Start(np.float64(0.5)),
                at=np.array([-15.0, -10.0]),
                max_speed=np.linspace(0.5, 1.5, 3)[1],
            ),
        ),
        gantry=sim.GantryEntry(
            at=np.array([-5.0, 2.0, 0.0]),
            jobs=(
                sim.Job("move", target=np.array([-2.5, 0.5, 0.0])),
                sim.Job("wait", seconds=np.float64(2.5)),
            ),
            repeat=np.bool_(True),
        ),
        agvs={"agv1": (sim.AgvMove(np.float64(1.0), np.float64(2.5)),)},
        rules=replace(sim.PAPER, name="ours", grace=np.float64(2.5)),
        expect={"penalties": np.float64(0)},
    )
    plain = sim.Trial(
        FLOOR,
        duration=20.0,
        people=(sim.PersonEntry("ada", start=sim.Start(0.5), at=(-15.0, -10.0), max_speed=1.0),),
        gantry=sim.GantryEntry(
            at=(-5.0, 2.0, 0.0),
            jobs=(sim.Job("move", target=(-2.5, 0.5, 0.0)), sim.Job("wait", seconds=2.5)),
            repeat=True,
        ),
        agvs={"agv1": (sim.AgvMove(1.0, 2.5),)},
        rules=replace(sim.PAPER, name="ours", grace=2.5),
        expect={"penalties": 0.0},
    )
    assert numbers.to_yaml() == plain.to_yaml()
    assert sim.Trial.parse(numbers.to_yaml()).gantry == plain.gantry
    assert sim.run(numbers).events == sim.run(plain).events


OWN = "!wait. +!wait <- .wait(1000).\n"


@pytest.mark.parametrize("of_change", [False, True])
def test_a_program_without_a_file_is_rejected(tmp_path, of_change):
    def written(program):
        if of_change:
            change = sim.PersonalityChange(sim.Start(3.0), program)
            entry = sim.PersonEntry("ada", changes=(change,))
        else:
            entry = sim.PersonEntry("ada", personality=program)
        return sim.Trial(FLOOR, people=(entry,), folder=tmp_path).to_yaml(tmp_path)

    (tmp_path / "own.asl").write_text(OWN)
    own = bdi.load(tmp_path / "own.asl")
    assert "personality: own.asl" in written(own)
    assert "personality: helpful" in written(bdi.load("helpful"))
    (tmp_path / "own.asl").write_text("!other. +!other <- true.\n")
    for program in (bdi.parse(OWN), own):
        with pytest.raises(ValueError, match="give the file as personality"):
            written(program)


def test_programs_of_the_package_can_be_written_in_any_folder(tmp_path, monkeypatch):
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
    (tmp_path / "a" / "own.asl").write_text(OWN)
    changes = "changes: [{when: {time: 3}, personality: helpful}]"
    text = f"floorplan: ariac2023\npeople: [{{name: ada, personality: own.asl, {changes}}}]\n"
    (tmp_path / "a" / "t.yaml").write_text(text)
    monkeypatch.chdir(tmp_path)
    for trial in (sim.Trial.load("a/t.yaml"), sim.Trial.load(tmp_path / "a" / "t.yaml")):
        trial.save("b/t.yaml")
        again = sim.Trial.load("b/t.yaml")
        assert again.people == trial.people
        everybody = trial.with_personality("../a/own.asl")
        everybody.save("b/t.yaml")
        assert sim.Trial.load("b/t.yaml").people == everybody.people


def test_a_built_in_controller_is_written_by_its_name():
    trial = sim.Trial(
        floorplan.load("ariac2023"), gantry=sim.GantryEntry(controller=CONTROLLERS["pausing"])
    )
    assert sim.Trial.parse(trial.to_yaml()).gantry.controller == "pausing"
