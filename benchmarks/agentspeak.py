"""How fast the AgentSpeak interpreter is, beside python-agentspeak where that is installed.

    python benchmarks/agentspeak.py [--goals N] [--repeat N]

python-agentspeak (distribution `agentspeak`, 0.2.2) is no dependency of the
project: install it for the comparison into the environment this runs in. CPU
seconds, medians; the two take turns, so that a busy machine slows both.
"""

from __future__ import annotations

import argparse
import gc
import io
import statistics
import sys
import time
from collections.abc import Callable
from pathlib import Path

# This file has the other's name: what it imports is to be the other.
sys.path[:] = [
    folder
    for folder in sys.path
    if Path(folder or ".").resolve() != Path(__file__).resolve().parent
]
sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import bdi  # noqa: E402

COUNT = "+!count(0). +!count(N) : N > 0 <- {}count(N-1)."
WHILE = "c(0). !go. +!go <- while (c(N) & N < {}) {{ -+c(N+1) }}."
PATROL = """
    next(a, b). next(b, c). next(c, a).
    at(a, 1, 2). at(b, 3, 4). at(c, 5, 6).
    bound_for(a).
    +arrived(_) : bound_for(S) & next(S, T) <- !walk_to(T).
    +!walk_to(S) : at(S, X, Y) <- -+bound_for(S); move(X, Y, 0).
"""


def programs(goals: int) -> dict[str, str]:
    return {
        "recursive goals": f"!count({goals}). {COUNT.format('!')}",
        "goals of a new focus": f"!count({goals}). {COUNT.format('!!')}",
        "a while loop": WHILE.format(goals),
    }


def ours(source: str) -> Callable[[], None]:
    agent = bdi.Agent(bdi.parse(source))
    return lambda: agent.advance(0.0)


def our_patrol(legs: int) -> Callable[[], None]:
    agent = bdi.Agent(bdi.parse(PATROL), act=lambda action: True)
    agent.advance(0.0)

    def walk() -> None:
        for leg in range(legs):
            agent.remove_percept(bdi.Literal("arrived", (float(leg - 1),)))
            agent.add_percept(bdi.Literal("arrived", (float(leg),)))
            agent.advance(float(leg))

    return walk


def theirs(source: str) -> Callable[[], None] | None:
    try:
        import agentspeak.runtime
        import agentspeak.stdlib
    except ImportError:
        return None
    text = io.StringIO(source)
    text.name = "benchmark.asl"
    environment = agentspeak.runtime.Environment()
    environment.build_agent(text, agentspeak.stdlib.actions)
    return lambda: environment.run()


def their_patrol(legs: int) -> Callable[[], None] | None:
    try:
        import agentspeak.runtime
        import agentspeak.stdlib
    except ImportError:
        return None
    actions = agentspeak.Actions(agentspeak.stdlib.actions)

    @actions.add("move", 3)
    def move(agent: object, term: object, intention: object) -> object:
        yield

    text = io.StringIO(PATROL)
    text.name = "benchmark.asl"
    environment = agentspeak.runtime.Environment()
    agent = environment.build_agent(text, actions)
    addition, removal = agentspeak.Trigger.addition, agentspeak.Trigger.removal
    percept = frozenset({agentspeak.Literal("source", (agentspeak.Literal("percept"),))})

    def walk() -> None:
        for leg in range(legs):
            for when, trigger in ((leg - 1, removal), (leg, addition)):
                belief = agentspeak.Literal("arrived", (when,), percept)
                agent.call(
                    trigger,
                    agentspeak.GoalType.belief,
                    belief,
                    agentspeak.runtime.Intention(),
                )
            environment.run()

    return walk


def measure(
    make: Callable[[], Callable[[], None] | None], seconds: list[float]
) -> list[float] | None:
    run = make()
    if run is None:
        return None
    gc.collect()
    begun = time.process_time()
    run()
    seconds.append(time.process_time() - begun)
    return seconds


def compare(
    name: str,
    steps: int,
    repeat: int,
    make_ours: Callable[[], Callable[[], None] | None],
    make_theirs: Callable[[], Callable[[], None] | None],
) -> None:
    mine: list[float] = []
    others: list[float] = []
    for _ in range(repeat):
        measure(make_ours, mine)
        measure(make_theirs, others)
    line = f"{name:<22} {statistics.median(mine) / steps * 1e6:8.2f} µs each"
    if others:
        ratio = statistics.median(others) / statistics.median(mine)
        line += f"   python-agentspeak {statistics.median(others) / steps * 1e6:8.2f} µs"
        line += f"   {ratio:5.1f} times as fast"
    print(line)


def show_small_things(repeat: int) -> None:
    """Loading, idling, and a trial's worth of percepts."""
    loading = []
    for name in list(bdi.programs()) * repeat:
        begun = time.process_time()
        bdi.load(name)
        loading.append(time.process_time() - begun)
    print(f"loading a personality  {statistics.median(loading) * 1e3:8.2f} ms")
    agent = bdi.Agent(bdi.parse("a."))
    agent.advance(0.0)
    begun = time.process_time()
    for i in range(100_000):
        agent.advance(float(i))
    print(f"advancing an idle one  {(time.process_time() - begun) * 10:8.2f} µs")
    trial = []
    stations = [f"station(s{i},{i},{i})" for i in range(4)]
    for _ in range(repeat):
        person = bdi.Agent(bdi.load("helpful"), beliefs=stations)
        begun = time.process_time()
        person.add_percept("human_start")
        for i in range(28):
            person.advance(i * 10.0)
            what = "gantry_detected" if i % 5 == 4 else "work_completed"
            person.add_percept(f"{what}({i})")
        person.advance(275.0)
        trial.append(time.process_time() - begun)
    print(f"a trial of 275 s       {statistics.median(trial) * 1e3:8.2f} ms")


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    options.add_argument("--goals", type=int, default=100_000)
    options.add_argument("--repeat", type=int, default=3)
    chosen = options.parse_args()
    goals, repeat = chosen.goals, chosen.repeat
    for name, source in programs(goals).items():
        compare(
            name,
            goals,
            repeat,
            lambda source=source: ours(source),  # type: ignore[misc]
            lambda source=source: theirs(source),  # type: ignore[misc]
        )
    legs = goals // 5
    compare("a leg of a patrol", legs, repeat, lambda: our_patrol(legs), lambda: their_patrol(legs))
    show_small_things(repeat)


if __name__ == "__main__":
    main()
