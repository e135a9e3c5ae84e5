"""Recordings read back as the runs that were recorded, and messages about damaged ones."""

import json
import math
import re
import shutil
from dataclasses import replace

import pytest
from hypothesis import given, settings, strategies as st
from replay_sample import replay_data
from run_events import Figure, Scene, record

import bdi
import floorplan
import sim
from navigation import ApproachLaw, FixedDistance, IntegralLaw, Scaled, SeparationLaw

TRIAL = """
name: busy
floorplan: ariac2023
duration: 60.0
people:
  - {name: ada, personality: antagonistic, radius: 0.25}
  - {name: ben, personality: helpful, start: {time: 5.0}}
gantry:
  controller: oblivious
  jobs: [{move: [-4.0, 1.0, 1.0]}, {move: [-6.0, -1.0, 0.0]}]
agvs:
  agv1: [{time: 20.0, to: assembly_front}]
  agv2: [{time: 20.0, to: 2.5}]
"""


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    """A run and the folder of its recording, which must not be changed."""
    folder = tmp_path_factory.mktemp("recorded") / "run"
    return record(sim.Trial.parse(TRIAL), folder), folder


@pytest.fixture
def folder(recorded, tmp_path):
    """A copy of the recording, which may be damaged."""
    return shutil.copytree(recorded[1], tmp_path / "run")


def test_a_run_that_cannot_begin_takes_no_folder(tmp_path):
    (tmp_path / "odd.asl").write_text("!go.\n+!go <- .nosuch(1).\n")
    person = sim.PersonEntry("ada", personality=str(tmp_path / "odd.asl"))
    trial = replace(sim.Trial.parse("floorplan: ariac2023\n"), people=(person,))
    with pytest.raises(bdi.ProgramError, match=r"no internal action \.nosuch"):
        sim.Simulation(trial, sim.Recording(tmp_path / "run"))
    assert not (tmp_path / "run").exists()


def test_the_second_run_that_begins_in_one_folder_is_rejected(tmp_path):
    trial = sim.Trial.parse("floorplan: ariac2023\nduration: 1.0\n")
    first, second = (sim.Recording(tmp_path / "run") for _ in range(2))
    simulation = sim.Simulation(trial, first)
    simulation.start()
    with pytest.raises(sim.OutputError, match=r"already contains a run \(events.jsonl\)"):
        sim.Simulation(trial, second).start()
    simulation.advance(1.0)
    run = simulation.finish()
    first.finish(run)
    assert sim.load_run(tmp_path / "run").summary == run.summary


def test_a_recording_contains_the_whole_run(recorded):
    run, folder = recorded
    back = sim.load_run(folder)
    assert run.summary["penalties"] > 0
    for name in ("scene", "duration", "summary", "events", "motions", "violations", "floorplan"):
        assert getattr(back, name) == getattr(run, name), name
    assert list(back.motions) == list(run.motions)
    assert [*map(list, back.events)] == [*map(list, run.events)]
    samples = run.sample(50.0)
    for name, values in back.sample(50.0).items():
        assert (values == samples[name]).all()


def test_the_scene_names_all_bodies(recorded):
    scene = sim.load_run(recorded[1]).scene
    assert [(person.name, person.radius) for person in scene.people] == [
        ("ada", 0.25),
        ("ben", 0.3),
    ]
    assert [scene.kind(body) for body in scene.starts][:4] == ["person", "person", "gantry", "agv"]
    with pytest.raises(KeyError, match="no body is called 'eve'"):
        scene.kind("eve")


def test_a_recording_can_be_copied_without_the_files_of_its_trial(tmp_path):
    room = tmp_path / "room.yaml"
    room.write_text("{boundary: [[0, 0], [9, 0], [9, 9], [0, 9]], safe_zone: {at: [1, 1]}}")
    trial = sim.Trial.parse(
        "{floorplan: room.yaml, duration: 5, people: [{name: ada}]}", folder=tmp_path
    )
    run = record(trial, tmp_path / "run")
    room.unlink()
    assert sim.load_run(tmp_path / "run").floorplan == run.floorplan


def test_an_interrupted_run_is_loaded_as_far_as_it_was_written(recorded, folder):
    run = recorded[0]
    for name in ("summary.json", "violations.jsonl", "trajectory.csv", "replay.html"):
        (folder / name).unlink()
    back = sim.load_run(folder)
    assert back.summary == {}
    assert (back.motions, back.duration) == (run.motions, run.duration)
    for pair, intervals in run.violations.items():
        # Violations end with a teleport, so they are found to the microsecond from the motions
        # before.
        assert len(back.violations[pair]) == len(intervals)
        for interval, noted in zip(back.violations[pair], intervals, strict=True):
            assert interval == pytest.approx(noted, abs=1e-6)


def test_recorded_pieces_of_zero_duration_change_nothing(folder):
    (folder / "summary.json").unlink()
    plain = sim.load_run(folder)
    motions = folder / "motions.jsonl"
    lines = [json.loads(line) for line in motions.read_text().splitlines()]
    for line in lines:
        # Add a fast piece of zero duration before each of the others.
        flashes = [
            [begin, begin, *([axis[0], 50.0, 0.0, 0.0] for axis in axes)]
            for begin, _, *axes in line["pieces"]
        ]
        line["pieces"] = [
            piece for both in zip(flashes, line["pieces"], strict=True) for piece in both
        ]
    motions.write_text("".join(f"{json.dumps(line)}\n" for line in lines))
    padded = sim.load_run(folder)
    assert padded.violations == plain.violations
    assert any(plain.violations.values())


@settings(max_examples=30)
@given(st.floats(0.0, 1.0), st.floats(0.0, 1.0))
def test_files_cut_anywhere_are_read_as_interrupted_runs(recorded, events, motions):
    run, whole = recorded
    with pytest.MonkeyPatch.context() as patch:
        folder = whole.with_name("broken")
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir()
        patch.chdir(folder)
        shutil.copy(whole / "scene.json", folder)
        for name, share in (("events.jsonl", events), ("motions.jsonl", motions)):
            text = (whole / name).read_bytes()
            (folder / name).write_bytes(text[: int(share * len(text))])
        back = sim.load_run(folder)
    assert back.events == run.events[: len(back.events)]
    for name, motion in back.motions.items():
        pieces = run.motions[name].pieces
        assert motion.pieces == pieces[: len(motion.pieces)] or motion.end == motion.start
        assert motion.start == 0.0


def test_a_run_without_people_is_loaded(tmp_path):
    trial = sim.Trial(floorplan.load("warehouse"), duration=3.0)
    run = record(trial, tmp_path / "run")
    back = sim.load_run(tmp_path / "run")
    assert (back.motions, back.violations, back.duration) == (run.motions, {}, 3.0)


@pytest.mark.parametrize(
    ("file", "damage", "message"),
    [
        ("events.jsonl", lambda text: text.replace('"t": ', '"t": x', 1), "line 1: .*JSON"),
        ("events.jsonl", lambda text: text[: len(text) // 2], r"line \d+: .*JSON"),
        ("events.jsonl", lambda text: "\n" + text, "line 1"),
        ("motions.jsonl", lambda text: text.replace('"body": "ada"', '"body": "eve"', 1), "eve"),
        ("motions.jsonl", lambda text: text.replace("[", "[[", 1), "line 1"),
        ("motions.jsonl", lambda text: '{"body": "ada", "pieces": []}\n', "line 1, pieces: .*1"),
        (
            "motions.jsonl",
            lambda text: json.dumps(
                {"body": "ada", "pieces": [[0, 1, *[[0] * 4] * 3], [2, 3, *[[0] * 4] * 3]]}
            ),
            "line 1: a motion has a gap",
        ),
        (
            "motions.jsonl",
            lambda text: json.dumps({"body": "ada", "pieces": [[2, 1, *[[0] * 4] * 3]]}),
            "line 1: a motion ends at t = 1.0 s, before it begins at 2.0 s",
        ),
        (
            "motions.jsonl",
            lambda text: text + text.partition("\n")[0] + "\n",
            r"line \d+: a motion from t = 0.0 s on comes after a later one",
        ),
        (
            "motions.jsonl",
            lambda text: json.dumps({"body": "ada", "pieces": [[0, 1e6, *[[0, 0, 1, 0]] * 3]]}),
            "line 1: a motion goes further than 1e.10",
        ),
        ("motions.jsonl", lambda text: '{"body": "ada", "pieces": 3', "line 1: .*JSON"),
        ("summary.json", lambda text: text[:-30], "is not JSON"),
        ("summary.json", lambda text: "[]", "is not a summary"),
        ("violations.jsonl", lambda text: text.replace("with", "wiht"), "line 1, with: .*required"),
        ("violations.jsonl", lambda text: text.replace("ada", "eve"), "person: no person .* 'eve'"),
        ("violations.jsonl", lambda text: text.replace("agv1", "agv"), "with: no machine .* 'agv'"),
        ("scene.json", lambda text: text[:999], "is not JSON: .* line 1"),
        ("scene.json", lambda text: "[]", "expected the format"),
        ("scene.json", lambda text: text.replace("scene/1", "scene/9"), "found '.*scene/9'"),
        ("scene.json", lambda text: text.replace('"seed":0', '"seed":"a"'), "seed: "),
        ("scene.json", lambda text: text.replace('"t1":1.0', '"t1":-1.0', 1), "rules: t1 must"),
        ("scene.json", lambda text: text.replace('"grace"', '"mercy"', 1), "rules: .*mercy"),
        (
            "scene.json",
            lambda text: text.replace("[[[", "[[[[", 1).replace("]]]", "]]]]", 1),
            "polygon",
        ),
        ("scene.json", lambda text: text.replace("-7.2", '"inf"', 1), "is not a simple polygon"),
        ("scene.json", lambda text: text.replace("-7.2", '"nan"', 1), "footprint: invalid polygon"),
        ("scene.json", lambda text: text.replace('"radius":0.3', '"radius":"inf"'), "valid number"),
        (
            "scene.json",
            lambda text: text.replace('"starts":{"ada"', '"starts":{"eve"'),
            "starts: no pose for 'ada'",
        ),
        ("motions.jsonl", None, "there is no such file"),
        ("scene.json", None, "there is no scene.json in it; a recording is a folder"),
    ],
)
def test_damage_is_reported_with_its_place(recorded, folder, file, damage, message):
    path = folder / file
    if damage is None:
        path.unlink()
    else:
        text = path.read_text(encoding="utf-8")
        damaged = damage(text)
        assert damaged != text
        path.write_text(damaged, encoding="utf-8")
    with pytest.raises(sim.RecordingError, match=message) as error:
        sim.load_run(folder)
    assert str(folder) in str(error.value)
    reported = []
    if file == "scene.json" and "scene/9" not in message:
        with pytest.raises(sim.RecordingError, match=message):
            sim.load_run(folder, damage=reported.append)
        return
    left = sim.load_run(folder, damage=reported.append)
    assert re.search(
        message if file != "scene.json" else "later format .*scene/9", " ".join(reported)
    )
    run, _ = recorded
    for name, motion in left.motions.items():
        for t in (0.0, 0.5 * motion.end, motion.end):
            if len(motion.pieces) > 1:
                assert motion.position(t) == pytest.approx(run.motions[name].position(t), abs=1e-9)
    assert left.events == run.events[: len(left.events)]
    assert replay_data(left)["duration"] > 0


def test_known_parts_of_a_later_version_are_read(recorded, folder):
    path = folder / "scene.json"
    scene = json.loads(path.read_text(encoding="utf-8"))
    scene |= {"format": "floorwalker-scene/2", "weather": "rain"}
    scene["rules"]["mercy"] = 3.0
    path.write_text(json.dumps(scene), encoding="utf-8")
    reported = []
    left = sim.load_run(folder, damage=reported.append)
    assert reported == [
        "made in the later format floorwalker-scene/2; what this version knows of it is shown"
    ]
    assert left.motions == recorded[0].motions
    assert left.scene.rules == recorded[0].scene.rules


def test_a_folder_that_is_not_there_is_reported(tmp_path):
    with pytest.raises(sim.RecordingError, match="nowhere: there is no such folder"):
        sim.load_run(tmp_path / "nowhere")


terms = st.floats(0.0, 5.0)
laws = st.one_of(
    st.builds(SeparationLaw, t1=terms, t2=terms, stopping=terms, intrusion=terms),
    st.builds(IntegralLaw, t1=terms, t2=terms, stopping=st.none() | terms),
    st.builds(ApproachLaw, time=terms),
    st.builds(FixedDistance, terms),
)


scaled = st.builds(Scaled, laws, terms, st.just(math.inf) | terms)


@settings(max_examples=30)
@given(st.sampled_from(floorplan.builtin()), laws, scaled, st.just(math.inf) | terms)
def test_every_scene_is_read_back_unchanged(tmp_path_factory, floor, law, noticed, parting):
    notice = replace(sim.PAPER.notice, law=noticed, parting=parting, every=None)
    rules = replace(sim.PAPER, gantry_law=law, notice=notice)
    people = (Figure("ada", personality="inf", radius=0.3, height=1.7),)
    starts = {"ada": (0.0, 0.5, 0.0)}
    for plan in (floorplan.load(floor), replace(floorplan.load(floor), patrol=None)):
        scene = Scene(
            trial="inf", seed=3, floorplan=plan, rules=rules, people=people, starts=starts
        )
        recording = sim.Recording(tmp_path_factory.mktemp("scene") / "run")
        recording.begin(scene)
        recording.close()
        assert sim.load_run(recording.folder).scene == scene


class OwnLaw:
    """A custom law that a recording cannot contain."""

    def distance(self, human_speed, robot_speed):
        return 0.2


def test_a_custom_law_is_named_and_not_evaluated(tmp_path):
    trial = sim.Trial.parse(TRIAL)
    trial = replace(trial, rules=replace(trial.rules, agv_law=OwnLaw()))
    run = record(replace(trial, duration=30.0), tmp_path / "run")
    back = sim.load_run(tmp_path / "run")
    assert back.violations == run.violations
    with pytest.raises(ValueError, match=r"a law of its own, .*:OwnLaw, which it does not hold"):
        back.scene.rules.agv_law.distance(1.0, 1.0)


def test_a_recording_may_do_without_its_trajectory(tmp_path):
    trial = replace(sim.Trial.load("ariac2023"), duration=20.0)
    run = sim.run(trial, recording := sim.Recording(tmp_path, trajectory=False))
    recording.finish(run)
    assert not (tmp_path / "trajectory.csv").exists()
    assert sim.load_run(tmp_path).motions.keys() == run.motions.keys()
