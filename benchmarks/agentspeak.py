"""How fast the AgentSpeak interpreter is, beside python-agentspeak where that is installed.

    python benchmarks/agentspeak.py [--goals N] [--repeat N]

python-agentspeak (distribution `agentspeak`, 0.2.2) is no dependency of the
project: install it for the comparison into the environment this runs in. Figures are medians of CPU
seconds. The two take turns, so that a busy machine slows both.
"""

from __future__ import annotations

import argparse
import gc
import io
import statistics
import sys
import time
from collections.abc import Callable, Iterator
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
    +work_completed(_) : bound_for(S) & next(S, T) <- !walk_to(T).
    +!walk_to(S) : at(S, X, Y) <- -+bound_for(S); move(X, Y, 0).
"""
RING = """
    next(a, b). next(b, c). next(c, d). next(d, a).
    at(a, 1, 2). at(b, 3, 4). at(c, 5, 6). at(d, 7, 8).
    ahead(S, T) :- next(S, T) & not reversed.
    ahead(S, T) :- next(T, S) & reversed.
    behind(S, T) :- next(T, S) & not reversed.
    behind(S, T) :- next(S, T) & reversed.
    bound_for(a).
    +work_completed(_) : bound_for(S) & ahead(S, T) <- !walk_to(T).
    +!walk_to(S) : at(S, X, Y) <- -bound_for(_); +bound_for(S); move(X, Y, 0).
"""
PATROLS = {
    "a leg of a patrol": PATROL,
    "… indifferent": RING + "+gantry_detected(_).",
    "… antagonistic": RING + "+gantry_detected(_) : bound_for(_) <- move_to_gantry.",
    "… helpful": RING
    + """
    +gantry_detected(_) : bound_for(S) & behind(S, T) <- !turn_round; !!walk_to(T).
    +!turn_round : reversed <- -reversed.
    +!turn_round <- +reversed.
""",
}
"""Patrols by facts alone, and by rules with what three kinds of people do about a gantry."""

DETECTED_EACH = 5
"""Number of legs to a percept of the gantry."""


def percepts(legs: int) -> Iterator[tuple[str, float, float]]:
    """Yield the percepts of a patrol: a name, the number of the one that goes, and its own."""
    for leg in range(legs):
        yield "work_completed", leg - 1.0, float(leg)
        if leg % DETECTED_EACH == DETECTED_EACH - 1:
            yield "gantry_detected", float(leg - DETECTED_EACH), float(leg)


def programs(goals: int) -> dict[str, str]:
    return {
        "recursive goals": f"!count({goals}). {COUNT.format('!')}",
        "goals of a new focus": f"!count({goals}). {COUNT.format('!!')}",
        "a while loop": WHILE.format(goals),
    }


def ours(source: str) -> Callable[[], None]:
    agent = bdi.Agent(bdi.parse(source))
    return lambda: agent.advance(0.0)


def our_patrol(source: str, legs: int) -> Callable[[], None]:
    agent = bdi.Agent(bdi.parse(source), act=lambda action: True)
    agent.advance(0.0)

    def walk() -> None:
        for name, before, now in percepts(legs):
            agent.remove_percept(bdi.Literal(name, (before,)))
            agent.add_percept(bdi.Literal(name, (now,)))
            agent.advance(now)

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


def their_patrol(source: str, legs: int) -> Callable[[], None] | None:
    try:
        import agentspeak.runtime
        import agentspeak.stdlib
    except ImportError:
        return None
    actions = agentspeak.Actions(agentspeak.stdlib.actions)

    @actions.add("move", 3)
    def move(agent: object, term: object, intention: object) -> object:
        yield

    @actions.add("move_to_gantry", 0)
    def move_to_gantry(agent: object, term: object, intention: object) -> object:
        yield

    text = io.StringIO(source)
    text.name = "benchmark.asl"
    environment = agentspeak.runtime.Environment()
    agent = environment.build_agent(text, actions)
    addition, removal = agentspeak.Trigger.addition, agentspeak.Trigger.removal
    percept = frozenset({agentspeak.Literal("source", (agentspeak.Literal("percept"),))})

    def walk() -> None:
        for name, before, now in percepts(legs):
            for when, trigger in ((before, removal), (now, addition)):
                belief = agentspeak.Literal(name, (when,), percept)
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
    for name, source in PATROLS.items():
        compare(
            name,
            legs,
            repeat,
            lambda source=source: our_patrol(source, legs),  # type: ignore[misc]
            lambda source=source: their_patrol(source, legs),  # type: ignore[misc]
        )
    show_small_things(repeat)


if __name__ == "__main__":
    main()
