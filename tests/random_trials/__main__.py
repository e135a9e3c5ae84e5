"""Run random trials and print those with faults: `python -m tests.random_trials`."""

import argparse
import sys
from concurrent.futures import ProcessPoolExecutor
from functools import partial

import sim

from . import (
    faults,
    random_trial,
    random_trial_of_vehicles,
    random_trial_with_doors,
    random_trial_with_fields,
    tracked_trial,
    vehicle_faults,
)

FAMILIES = {
    "plain": random_trial,
    "doors": random_trial_with_doors,
    "tracks": tracked_trial,
    "fields": random_trial_with_fields,
    "vehicles": random_trial_of_vehicles,
}


def main():
    """Run the requested trials. Exit with 1 if one has a fault."""
    parser = argparse.ArgumentParser(prog="python -m tests.random_trials", description=__doc__)
    parser.add_argument("--trials", type=int, default=1000, help="how many")
    parser.add_argument("--first", type=int, default=0, help="number of the first")
    parser.add_argument("--jobs", type=int, default=1, help="how many at once")
    parser.add_argument("--family", choices=FAMILIES, default="plain", help="which trials")
    options = parser.parse_args()
    make = FAMILIES[options.family]
    numbers = range(options.first, options.first + options.trials)
    broken = 0
    with ProcessPoolExecutor(options.jobs) as pool:
        for number, wrong in zip(
            numbers, pool.map(partial(tried, make), numbers, chunksize=4), strict=True
        ):
            broken += bool(wrong)
            for fault in wrong:
                print(f"{number}: {fault}", flush=True)
    print(f"{options.trials} trials, {broken} broken")
    sys.exit(1 if broken else 0)


def tried(make, number):
    """Return the faults of the trial with this number, in words. An error is a fault."""
    try:
        judge = vehicle_faults if make is random_trial_of_vehicles else faults
        return [*judge(sim.run(make(number)))]
    except Exception as why:
        return [f"{type(why).__name__}: {why}"]


if __name__ == "__main__":
    main()
