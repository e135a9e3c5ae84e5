"""Many trials run at once: their runs are returned in order, with any number of jobs."""

import itertools
from dataclasses import replace

import pytest

import sim

TRIAL = sim.Trial.parse("floorplan: ariac2023\nduration: 20\npeople: [{name: ada}]\n")
FAULTY = replace(TRIAL, duration=-1.0)


def outcome(run):
    """Return all results of a run except its computing time."""
    timing = ("cpu_seconds", "realtime_factor")
    summary = {key: value for key, value in run.summary.items() if key not in timing}
    pieces = {name: motion.pieces for name, motion in run.motions.items()}
    return run.trial, summary, run.events, pieces, run.violations


def test_runs_and_errors_are_returned_in_order():
    seeds = [replace(TRIAL, duration=5.0, seed=seed) for seed in range(3)]
    ahead = itertools.chain(seeds, [FAULTY], itertools.repeat(TRIAL))
    runs = sim.run_many(ahead, jobs=1)
    for trial in seeds:
        assert outcome(next(runs)) == outcome(sim.run(trial))
    with pytest.raises(sim.TrialError, match="duration"):
        next(runs)
    results = sim.run_many(
        [FAULTY, seeds[0]],
        keep=lambda run: run.summary["duration"],
        failed=lambda why: type(why).__name__,
        jobs=1,
    )
    assert list(results) == ["TrialError", 5.0]
    with pytest.raises(ValueError, match="Invalid backend: lucky"):
        next(sim.run_many([TRIAL], backend="lucky"))


@pytest.mark.slow
def test_runs_of_other_processes_are_the_same():
    import joblib

    trials = [replace(TRIAL, seed=seed) for seed in range(6)]
    trials += [trial.with_personality("antagonistic") for trial in trials]
    alone = [outcome(sim.run(trial)) for trial in trials]
    runs = sim.run_many(trials, jobs=2)
    first = [outcome(next(runs))]
    # Other users of joblib have their own settings while runs are pending.
    assert joblib.Parallel().n_jobs == 1
    assert [*first, *map(outcome, runs)] == alone
