"""Trials that `check` accepts begin to run: none is rejected at the start."""

import yaml
from hypothesis import HealthCheck, assume, given, settings, strategies as st

import floorplan
import sim

SIZES = st.sampled_from((1e-300, 1e-9, 1e-6, 1e-3, 0.2, 0.3, 1.0, 2.5, 40.0, 1e3, 1e6, 1e9))
ORDINARY = st.floats(0.1, 3.0)
PLACES = st.floats(-3.0, 13.0) | st.sampled_from((-1e9, -1e7, 0.0, 1e7, 1e9, 5e-324))
TIMES = st.sampled_from((0.0, 1e-300, 1e-9, 0.1, 0.5, 5.0, 1e9))
NAMES = st.sampled_from(("ada", "Ben-2", "a\0", "x" * 300, "\u00e9", "gantry", ""))


def mostly(usual, odd):
    """Draw from `usual`, and sometimes from `odd`."""
    return st.integers(0, 29).flatmap(lambda k: odd if k == 0 else usual)


def size(usual):
    return mostly(st.just(usual) | ORDINARY, SIZES)


def keys(**strategies):
    return st.fixed_dictionaries({}, optional=strategies)


AXIS = st.fixed_dictionaries(
    {
        "range": mostly(st.just([1.0, 9.0]), st.lists(PLACES, min_size=2, max_size=2)),
        "max_speed": size(1.0),
        "max_acceleration": size(0.5),
        "max_jerk": size(2.0),
    }
)
FLOORS = st.fixed_dictionaries(
    {
        "boundary": mostly(
            st.just([[0, 0], [10, 0], [10, 10], [0, 10]]),
            st.lists(st.tuples(PLACES, PLACES).map(list), min_size=3, max_size=5),
        ),
        "human": keys(
            radius=size(0.3),
            height=size(1.75),
            max_speed=size(1.0),
            max_acceleration=size(2.5),
            goal_tolerance=size(0.25),
        ),
        "obstacles": st.fixed_dictionaries(
            {
                "table": st.fixed_dictionaries(
                    {"x": st.just([3, 4]), "y": st.just([6, 7]), "z": st.just([0, 1])}
                ),
                "far": st.fixed_dictionaries(
                    {
                        "center": mostly(st.just([5, 5]), st.tuples(PLACES, PLACES).map(list)),
                        "radius": size(0.2),
                        "z": st.just([0, 1]),
                    }
                ),
            }
        ),
        "stations": st.just({"a": [1.5, 1.5], "b": [8.0, 8.5]}),
        "safe_zone": st.just({"at": [1.0, 8.5]}),
        "agvs": st.fixed_dictionaries(
            {
                "size": st.tuples(size(1.0), size(0.6)).map(list),
                "height": size(1.2),
                "max_speed": size(2.0),
                "max_acceleration": size(2.0),
                "limits": mostly(st.just([0.0, 4.0]), st.just([-1e9, 1e9])),
                "locations": st.just({"home": 0.0, "away": 4.0}),
                "start": st.just("home"),
                "lanes": st.fixed_dictionaries(
                    {
                        "agv1": st.fixed_dictionaries(
                            {
                                "origin": mostly(
                                    st.just([4.0, 3.0]), st.tuples(PLACES, PLACES).map(list)
                                ),
                                "heading": mostly(st.just(0.0), PLACES),
                            }
                        )
                    }
                ),
            }
        ),
        "gantry": st.fixed_dictionaries(
            {
                "x": AXIS,
                "y": AXIS,
                "start": mostly(st.just([4, 4, 0]), st.lists(PLACES, min_size=3, max_size=3)),
                "torso": st.just({"size": [1.05, 0.95], "z": [1.24, 2.71]}),
                "arm": st.fixed_dictionaries(
                    {"mount": st.just([0.5, 0.0]), "reach": size(0.9), "bottom": size(1.1)}
                ),
                "rail_height": size(2.9),
                "tray_height": size(0.8),
            }
        ),
    }
)
PLACE_NAMES = st.sampled_from(("table", "far", "a", "b", "agv1"))
JOBS = st.one_of(
    st.fixed_dictionaries({"move": st.tuples(PLACES, PLACES, ORDINARY).map(list)}),
    st.fixed_dictionaries({"wait": mostly(ORDINARY, SIZES)}),
    st.fixed_dictionaries({"pick": PLACE_NAMES, "place": PLACE_NAMES}),
    st.fixed_dictionaries({"submit": NAMES}),
)
PEOPLE = st.fixed_dictionaries(
    {
        "name": mostly(st.sampled_from(("ada", "Ben-2", "eve")), NAMES),
        "personality": st.sampled_from(("indifferent", "helpful", "antagonistic")),
    },
    optional={
        "start": st.fixed_dictionaries({"time": TIMES}),
        "at": mostly(st.just([6.0, 6.5]), st.tuples(PLACES, PLACES).map(list)),
        "radius": size(0.3),
        "max_speed": size(1.0),
        "max_acceleration": size(2.5),
    },
)
TRIALS = st.fixed_dictionaries(
    {
        "duration": mostly(st.just(20.0), TIMES),
        "people": st.lists(PEOPLE, min_size=1, max_size=2),
    },
    optional={
        "name": mostly(st.just("t"), NAMES),
        "seed": mostly(st.just(7), st.sampled_from((2**63 - 1, 2**63, 10**400))),
        "gantry": st.fixed_dictionaries(
            {
                "controller": st.sampled_from(("oblivious", "pausing", "avoiding")),
                "jobs": st.lists(JOBS, max_size=3),
            },
            optional={"at": mostly(st.just([5, 5, 0]), st.lists(PLACES, min_size=3, max_size=3))},
        ),
        "agvs": st.fixed_dictionaries(
            {
                "agv1": st.lists(
                    st.fixed_dictionaries(
                        {"time": TIMES, "to": st.sampled_from(("home", "away", 2, 3.9, 1e9))}
                    ),
                    max_size=2,
                )
            }
        ),
    },
)


@settings(
    max_examples=settings.default.max_examples // 3,
    suppress_health_check=[HealthCheck.filter_too_much, HealthCheck.too_slow],
)
@given(FLOORS, TRIALS)
def test_a_checked_trial_starts(tmp_path_factory, floor, trial):
    folder = tmp_path_factory.mktemp("t")
    (folder / "floor.yaml").write_text(yaml.safe_dump(floor), encoding="utf-8")
    try:
        checked = sim.Trial.parse(
            yaml.safe_dump({"floorplan": "floor.yaml", **trial}), folder=folder
        )
    except (sim.TrialError, floorplan.FloorplanError):
        assume(False)
    recording = sim.Recording(folder / "run")
    simulation = sim.Simulation(checked, recording)
    simulation.advance(1.0)
    run = simulation.finish()
    recording.finish(run)
    assert run.duration == min(1.0, checked.duration)
    assert sim.load_run(folder / "run").motions == run.motions
