"""Minds: a BDI agent or an external program that decides for a person, and its inspector.

They are those of Jason's mind inspector, which shows an agent at an instant; to keep them for every
instant of a run, only the changes that a thought has made are recorded.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Any, Protocol

import bdi
from bdi.reasoning.beliefs import LiveBeliefs
from bdi.reasoning.intentions import Intention
from floorplan import Floorplan

from ..core.body import Body
from ..core.entries import seed_of
from ..core.recorder import Thought
from ..core.rules import RuleSet
from ..core.scenario import PersonEntry, Scenario
from ..core.stage import Stage
from .programs import Programs

MOST_CYCLES = 200_000
"""Number of reasoning cycles that a person may take at one instant; a handful is usual."""

KEPT = ("bound_for", "reversed")
"""Beliefs that outlast a change of personality: the round they are on, as `patrol.asl` has it."""


class Mind(Protocol):
    """Interface of a mind to its person; `bdi.Agent` is one."""

    @property
    def next_wakeup(self) -> float | None:
        """Instant at which it goes on without a new percept (seconds); None for never."""
        ...

    def add_percept(self, percept: bdi.Literal) -> None:
        """Perceive `percept` from the next `advance` on."""
        ...

    def remove_percept(self, percept: bdi.Literal) -> None:
        """Perceive `percept` no longer from the next `advance` on."""
        ...

    def advance(self, time: float) -> None:
        """Think until there is nothing left to think about at `time` (seconds)."""
        ...


class Outside:
    """Mind outside the simulation.

    The person's percepts wait here until a program takes them. The functions `on_decision` are
    called when there are any, or at the time `wake_at`. The program calls the person's `act`.
    """

    def __init__(self, called: Callable[[], None] = lambda: None) -> None:
        self.on_decision = [called]
        self.wake_at: float | None = None
        self._perceived: list[bdi.Literal] = []

    @property
    def next_wakeup(self) -> float | None:
        """Instant at which it wants to be called without a percept (seconds); None for never."""
        return self.wake_at

    def add_percept(self, percept: bdi.Literal) -> None:
        """Keep `percept` until it is taken."""
        self._perceived.append(percept)

    def remove_percept(self, percept: bdi.Literal) -> None:
        """Do nothing, because external programs receive only the begin of percepts."""

    def advance(self, time: float) -> None:
        """Call `on_decision` if there is something to decide at `time` (seconds)."""
        is_awake = self.wake_at is not None and self.wake_at <= time
        if is_awake:
            self.wake_at = None
        if is_awake or self._perceived:
            for decides in self.on_decision:
                decides()

    def take(self) -> list[bdi.Literal]:
        """Return the percepts since the last time, in their order."""
        perceived, self._perceived = self._perceived, []
        return perceived


class Mindless:
    """Mind of a recorded person, without any decisions."""

    next_wakeup: float | None = None

    def add_percept(self, percept: bdi.Literal) -> None:
        """Take no note of `percept`."""

    def remove_percept(self, percept: bdi.Literal) -> None:
        """Take no note of the end of `percept`."""

    def advance(self, time: float) -> None:
        """Think nothing until `time` (seconds)."""


def make_agent(
    entry: PersonEntry,
    trial: Scenario,
    programs: Programs | None = None,
    *,
    act: Callable[[bdi.Literal], bool | bdi.Refused],
    print: Callable[[str], None],
    settings: bdi.AgentSettings,
    society: bdi.Society | None = None,
    kept: Sequence[bdi.Literal] = (),
) -> bdi.Agent:
    """Return the agent of a person, with the beliefs of the trial and those `kept` before.

    `programs` are those of all people of the trial. Seed, strictness and the maximum number of
    cycles replace those of `settings`.
    """
    start = settings.start
    program, actions = (programs or Programs(trial)).of(entry)
    leader = trial.leader(entry)
    return bdi.Agent(
        program,
        actions=actions,
        beliefs=[*first_beliefs(entry, trial.floorplan, trial.rules, leader), *kept],
        act=act,
        name=entry.name,
        print=print,
        society=society,
        settings=replace(
            settings,
            seed=seed_of(trial.seed, f"{entry.name} {start}" if start else entry.name),
            strict=True,
            max_cycles=MOST_CYCLES,
        ),
    )


def live_beliefs(person: Body, stage: Stage) -> LiveBeliefs:
    """Return live beliefs: where all are and how fast they move, whenever a program asks.

    `me(X, Y, V)`, `person(Name, X, Y, V)` of the others, `gantry(X, Y, V)` where there is one,
    `agv(Name, X, Y, V)` of vehicles, `machine(Name, Kind, X, Y, V)` of all machines: m and m/s.
    """

    def of(body: Body) -> tuple[bdi.Term, ...]:
        state = body.state
        return (*state.at, state.speed)

    live: dict[tuple[str, int], Callable[[], list[tuple[bdi.Term, ...]]]] = {
        ("me", 3): lambda: [of(person)],
        ("person", 4): lambda: [
            (as_term(one.name), *of(one.body))
            for one in stage.people
            if one.body is not person and not one.away
        ],
        ("agv", 4): lambda: [(as_term(agv.name), *of(agv.body)) for agv in stage.vehicles],
        ("machine", 5): lambda: [
            (as_term(one.name), as_term(one.shape.kind), *of(one.body))
            for one in stage.machines.values()
        ],
    }
    if stage.robots:
        live["gantry", 3] = lambda: [of(robot.body) for robot in stage.robots]
    return live


def kept_beliefs(mind: Mind | None) -> list[bdi.Literal]:
    """Return the beliefs that a change of personality leaves: where the person is going."""
    if not isinstance(mind, bdi.Agent):
        return []
    return [belief for belief in mind.beliefs if belief.functor in KEPT]


def first_beliefs(
    entry: PersonEntry, plan: Floorplan, rules: RuleSet, leader: PersonEntry | None = None
) -> list[bdi.Literal | str]:
    """Return what a person believes before the trial starts: the stations, home, pauses, reactions.

    Also where they leave the floor, and whom they walk with.
    """
    beliefs: list[bdi.Literal | str] = [
        bdi.Literal("station", (as_term(station.name), *station.position))
        for station in plan.patrolled
    ]
    home = entry.home_on(plan)
    if home is not None:
        beliefs.append(bdi.Literal("safe_zone", home.position))
    sink = entry.sink_on(plan)
    if sink is not None:
        beliefs.append(bdi.Literal("exit", sink))
    if leader is not None:
        beliefs.append(bdi.Literal("leader", (as_term(leader.name),)))
    for pause, seconds in (
        ("pause_after_violation", rules.pause_after_violation),
        ("pause_after_agv", rules.pause_after_agv),
    ):
        beliefs.append(bdi.Literal(pause, (seconds * 1000,)))
    for personality, seconds in rules.reactions.items():
        beliefs.append(bdi.Literal("reaction", (as_term(personality), seconds * 1000)))
    return [*beliefs, *entry.beliefs]


@lru_cache(maxsize=4096)
def as_term(name: str) -> bdi.Term:
    """Return a name as an AgentSpeak term: an atom if possible, otherwise a string."""
    return bdi.Literal(name) if re.fullmatch(r"[a-z][A-Za-z0-9_]*", name) else name


_SOURCE = re.compile(r"\[source\((?:self|percept)\)\]")
STEPS = ("percept", "plan", "action", "warning")
"""Kinds of entries that are noted."""


class MindInspector:
    """Looks into one agent; `notify` takes a `Thought` whenever something has changed."""

    def __init__(self, person: str, notify: Callable[[Thought], None]) -> None:
        self._person = person
        self._notify = notify
        self._steps: list[list[str]] = []
        self._believed: dict[bdi.Literal, None] = {}
        self._intended: list[dict[str, Any]] = []

    def note(self, entry: bdi.Entry) -> None:
        """Take note of a step of the agent's reasoning, as its `on_event` reports it."""
        if entry.kind in STEPS:
            place = [f"{_base(entry.file)}:{entry.line}"] if entry.kind == "plan" else []
            self._steps.append([entry.kind, _plain(entry.text), *place])

    def look(self, t: float, agent: bdi.Agent) -> None:
        """Notify of the changes that the agent's thought at `t` (seconds) has made."""
        thought: Thought = {"t": t, "person": self._person}
        if self._steps:
            thought["steps"], self._steps = self._steps, []
        believed = dict.fromkeys(agent.beliefs)
        new = [_plain(str(one)) for one in believed if one not in self._believed]
        gone = [_plain(str(one)) for one in self._believed if one not in believed]
        self._believed = believed
        if new:
            thought["believes"] = new
        if gone:
            thought["forgets"] = gone
        intended = [_intention(one) for one in agent.intentions]
        if intended != self._intended:
            thought["intends"] = self._intended = intended
        if len(thought) > 2:
            self._notify(thought)


def _intention(intention: Intention) -> dict[str, Any]:
    stack = [_plain(str(means.trigger)) for means in intention.stack]
    return {"stack": stack, "at": _plain(intention.top.doing)}


def _plain(text: str) -> str:
    """Return the text without the sources that every belief has."""
    return _SOURCE.sub("", text)


def _base(file: str) -> str:
    return re.split(r"[/\\]", file)[-1]
