"""Measured crowds: all people in a file, each on the floor only while tracked."""

import h5py
import numpy as np
import pytest

import sim

HALL = """\
floorplan: {boundary: [[0, 0], [20, 0], [20, 10], [0, 10]]}
duration: 30
rules: observe
"""


def run_of(folder, people, floor=HALL):
    return sim.run(sim.Trial.parse(f"{floor}people: {people}\n", folder=folder))


def written(folder, name, rows, header=""):
    (folder / name).write_text(header + "".join(f"{row}\n" for row in rows))


def walk(body, begin, end, at, speed=1.0, step=0.5):
    """Return rows t, body, x, y of a walk along x."""
    times = np.arange(begin, end + 1e-9, step)
    return [f"{t:g},{body},{at[0] + speed * (t - begin):g},{at[1]:g}" for t in times]


def test_a_person_stands_still_before_the_begin_of_their_track(tmp_path):
    written(tmp_path, "late.csv", walk("eve", 10.0, 15.0, (2.0, 3.0)), "t,name,x,y\n")
    run = run_of(tmp_path, "[{name: eve, recorded: late.csv}]")
    places = run.motions["eve"].position(np.array([0.0, 9.9, 10.0, 15.0, 30.0]))
    assert np.allclose(places, [[2, 3], [2, 3], [2, 3], [7, 3], [7, 3]])
    assert run.presence["eve"] == (0.0, 30.0)


def test_a_motion_is_stationary_before_its_begin():
    from navigation import Motion

    walk = Motion.from_samples([8.0, 9.0, 10.0], [[2, 3], [3, 3], [4, 3]])
    trial = sim.Trial.parse(HALL)
    people = (sim.PersonEntry("eve", recorded=walk),)
    run = sim.run(sim.Trial(trial.floorplan, rules=trial.rules, people=people, duration=20.0))
    assert np.allclose(run.motions["eve"].position(np.array([0.0, 9.0])), [[2, 3], [3, 3]])


def test_a_person_who_jumps_onto_the_floor_is_absent_before(tmp_path):
    rows = ["0,eve,-9,-9", "8,eve,-9,-9", *walk("eve", 8.0, 12.0, (2.0, 3.0))]
    written(tmp_path, "jump.csv", rows, "t,name,x,y\n")
    run = run_of(tmp_path, "[{name: eve, recorded: {file: jump.csv, longest_gap: 9}}]")
    assert run.presence["eve"] == (8.0, 30.0)
    assert [e["kind"] for e in run.events if e.get("person") == "eve"] == [
        "awaited",
        "human_started",
        "entered",
    ]


@pytest.fixture
def crowd(tmp_path):
    """Three bodies: one with a gap, two at the same place one after another."""
    rows = [
        *walk("7", 2.0, 5.0, (1.0, 2.0)),
        *walk("7", 9.0, 12.0, (8.0, 2.0)),
        *walk("8", 0.0, 6.0, (1.0, 5.0)),
        *walk("9", 7.0, 10.0, (7.0, 5.0)),
    ]
    written(tmp_path, "crowd.csv", rows, "t,id,x,y\n")
    return tmp_path


EVERYBODY = "[{name: p, recorded: {file: crowd.csv, everybody: true}}]"


def test_recorded_people_are_present_only_while_tracked(crowd):
    run = run_of(crowd, EVERYBODY)
    assert run.stays == {"p7": ((2.0, 5.0), (9.0, 12.0)), "p8": ((0.0, 6.0),), "p9": ((7.0, 10.0),)}
    assert (run.summary["entered"], run.summary["left"], run.summary["overlaps"]) == (3, 4, 0)
    people = run.summary["people"]
    assert people["p7"]["distance_walked"] == pytest.approx(6.0)
    assert people["p7"]["time_standing"] == 0.0 and people["p8"]["left"] == 6.0
    assert run.is_present("p7", np.array([1.9, 2.0, 7.0, 9.0, 12.1])).tolist() == [
        False,
        True,
        False,
        True,
        False,
    ]


def test_people_who_are_never_there_together_have_no_distance(crowd):
    written(crowd, "crowd.csv", [*walk("1", 0, 3, (1, 5)), *walk("2", 4, 7, (4, 5))], "t,id,x,y\n")
    assert run_of(crowd, EVERYBODY).summary["nearest_people"] is None


def test_a_crowd_is_recorded_and_exported_only_while_tracked(crowd, tmp_path):
    trial = sim.Trial.parse(f"{HALL}people: {EVERYBODY}\n", folder=crowd)
    recording = sim.Recording(tmp_path / "out")
    run = sim.run(trial, recording)
    recording.finish(run)
    assert sim.load_run(tmp_path / "out").stays == run.stays
    sim.export(run, tmp_path / "again.csv", rate=10.0)
    sim.export(run, tmp_path / "again.sqlite", rate=10.0)
    for file in ("again.csv", "again.sqlite"):
        name = "p7" if file == "again.csv" else "p1"
        entry = f"[{{name: p, recorded: {{file: {file}, everybody: true}}}}]"
        again = run_of(tmp_path, entry)
        ends = [t for span in run.stays["p7"] for t in span]
        stays = again.stays.get("p_p7") or again.stays[name]
        assert [t for span in stays for t in span] == pytest.approx(ends, abs=0.11)


def test_people_created_in_python_may_be_a_whole_crowd(crowd):
    read = sim.Trial.parse(HALL, folder=crowd)
    track = sim.RecordedTrack("crowd.csv", everybody=True)
    trial = sim.Trial(
        read.floorplan,
        rules=read.rules,
        duration=30.0,
        folder=crowd,
        people=(sim.PersonEntry("p", recorded=track),),
    )
    assert [*sim.run(trial).summary["people"]] == ["p7", "p8", "p9"]


def test_the_name_of_a_crowd_may_be_omitted(crowd):
    entry = EVERYBODY.replace("name: p, ", "")
    assert [*run_of(crowd, entry).summary["people"]] == ["person7", "person8", "person9"]


def test_a_written_trial_has_the_same_crowd(crowd):
    trial = sim.Trial.parse(f"{HALL}people: {EVERYBODY}\n", folder=crowd)
    trial.save(crowd / "again.trial.yaml")
    assert sim.Trial.load(crowd / "again.trial.yaml").people == trial.people


def test_a_bad_body_of_a_crowd_is_named_with_its_line(crowd):
    rows = [*walk("1", 0, 3, (1, 5)), "3.1,1,9,5"]
    written(crowd, "crowd.csv", rows, "t,id,x,y\n")
    with pytest.raises(sim.TrialError, match=r"line 9: a jump of 5 m"):
        run_of(crowd, EVERYBODY)


def people_walking():
    """Return frames, bodies and places of five people walking close together, at 2.5 Hz."""
    rng = np.random.default_rng(4)
    for k in range(5):
        for n in range(20):
            x, y = 1.0 + 0.5 * n + rng.normal(0, 0.02), 3.0 + 0.6 * k + rng.normal(0, 0.02)
            yield 10 * (n + 3 * k), k + 1, x, y


@pytest.mark.parametrize("first", ["frame", "body"])
@pytest.mark.parametrize("form", ["{:d}", "{:.1f}"])
def test_frames_may_precede_or_follow_the_body(tmp_path, first, form):
    rows = sorted(people_walking(), key=lambda row: row[:2] if first == "frame" else row[1::-1])
    lines = []
    for frame, body, x, y in rows:
        pair = (frame, body) if first == "frame" else (body, frame)
        a, b = (form.format(value if form == "{:d}" else float(value)) for value in pair)
        lines.append(f"{a}\t{b}\t{x:.4f}\t{y:.4f}")
    written(tmp_path, "tracks.txt", lines)
    run = run_of(tmp_path, "[{recorded: {file: tracks.txt, everybody: true, frame_rate: 25}}]")
    assert sorted(run.stays) == [f"person{k}" for k in range(1, 6)]
    assert run.stays["person3"] == (pytest.approx((2.4, 10.0)),)


def test_eight_columns_are_read_as_obsmat(tmp_path):
    rows = [f"{f:e} {b:e} {x:e} 0 {y:e} 0 0 0" for f, b, x, y in people_walking()]
    written(tmp_path, "obsmat.txt", rows)
    run = run_of(tmp_path, "[{recorded: {file: obsmat.txt, everybody: true, frame_rate: 25}}]")
    assert run.motions["person5"].position(4.8) == pytest.approx((1.0, 5.4), abs=0.1)


def test_a_unit_and_a_frame_rate_may_be_stated(tmp_path):
    lines = [f"{k} {n} {100 + 10 * n} {200 + 100 * k}" for k in (1, 2) for n in range(20)]
    written(tmp_path, "tracks.txt", lines)
    run = run_of(
        tmp_path, "[{recorded: {file: tracks.txt, everybody: true, unit: cm, frame_rate: 10}}]"
    )
    assert run.motions["person2"].position(1.0) == pytest.approx((2.0, 4.0))


def test_a_second_header_line_may_state_units(tmp_path):
    written(
        tmp_path, "t.csv", ['"t","id","x","y"', '"s","","cm","cm"', "0,1,100,200", "1,1,150,200"]
    )
    run = run_of(tmp_path, "[{name: eve, recorded: t.csv}]")
    assert run.motions["eve"].position(1.0) == pytest.approx((1.5, 2.0))


def hdf5(path, names=("id", "frame", "x", "y"), fps=25.0, dataset="trajectory"):
    kinds = [(name, "f8" if name in "xyz" else "i8") for name in names]
    rows = np.array([(k, n, 1 + 0.04 * n, 2 + k) for k in (1, 2) for n in range(50)], dtype=kinds)
    with h5py.File(path, "w") as file:
        data = file.create_dataset(dataset, data=rows)
        if fps:
            data.attrs["fps"] = fps


def test_tracks_in_hdf5_are_read(tmp_path):
    hdf5(tmp_path / "run.h5")
    run = run_of(tmp_path, "[{recorded: {file: run.h5, everybody: true}}]")
    assert run.motions["person2"].position(1.0) == pytest.approx((2.0, 4.0))


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"fps": None}, "frame_rate"),
        ({"fps": -1.0}, "frame rate"),
        ({"dataset": "other"}, "trajectory"),
        ({"names": ("id", "frame", "u", "y")}, "no column x"),
    ],
)
def test_invalid_hdf5_is_rejected(tmp_path, wrong, words):
    hdf5(tmp_path / "run.h5", **wrong)
    with pytest.raises(sim.TrialError, match=words):
        run_of(tmp_path, "[{recorded: {file: run.h5, everybody: true}}]")
