"""Minds: agents and external programs that decide for people, and the inspector of agents.

The inspector shows the same as the mind inspector of Jason. It records only the changes made by
each thought, so that the state at every time of a run can be restored.
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
"""Maximum number of reasoning cycles of a person at one time. A few are usual."""

KEPT = ("bound_for", "reversed")
"""Beliefs kept after a change of personality: the state of the patrol in `patrol.asl`."""


class Mind(Protocol):
    """Interface of a mind to its person, implemented by `bdi.Agent`."""

    @property
    def next_wakeup(self) -> float | None:
        """Time of the next activity without a new percept (s), or None."""
        ...

    def add_percept(self, percept: bdi.Literal) -> None:
        """Add a percept at the next `advance`."""
        ...

    def remove_percept(self, percept: bdi.Literal) -> None:
        """Remove a percept at the next `advance`."""
        ...

    def advance(self, time: float) -> None:
        """Think until there is nothing left to do at `time` (s)."""
        ...


class Outside:
    """Mind outside the simulation, which decides by calls of `Person.act`.

    Percepts are queued until the client takes them. The functions `on_decision` are called when
    there are percepts, and at the time `wake_at` (s).
    """

    def __init__(self, called: Callable[[], None] = lambda: None) -> None:
        self.on_decision = [called]
        self.wake_at: float | None = None
        self._perceived: list[bdi.Literal] = []

    @property
    def next_wakeup(self) -> float | None:
        """Time of the next call without a percept (s), or None."""
        return self.wake_at

    def add_percept(self, percept: bdi.Literal) -> None:
        """Queue a percept until the client takes it."""
        self._perceived.append(percept)

    def remove_percept(self, percept: bdi.Literal) -> None:
        """Do nothing, because clients do not receive the end of percepts."""

    def advance(self, time: float) -> None:
        """Call `on_decision` if there is something to decide at `time` (seconds)."""
        is_awake = self.wake_at is not None and self.wake_at <= time
        if is_awake:
            self.wake_at = None
        if is_awake or self._perceived:
            for decides in self.on_decision:
                decides()

    def take(self) -> list[bdi.Literal]:
        """Return the percepts since the last call, in order."""
        perceived, self._perceived = self._perceived, []
        return perceived


class Mindless:
    """Mind of a recorded person, who ignores all percepts."""

    next_wakeup: float | None = None

    def add_percept(self, percept: bdi.Literal) -> None:
        """Ignore a percept."""

    def remove_percept(self, percept: bdi.Literal) -> None:
        """Ignore the end of a percept."""

    def advance(self, time: float) -> None:
        """Do nothing until `time` (s)."""


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
    """Return live beliefs about the current positions (m) and speeds (m/s) of all bodies.

    They are `me(X, Y, V)`, `person(Name, X, Y, V)` for each other person, `gantry(X, Y, V)` for
    each robot, `agv(Name, X, Y, V)` for each vehicle, and `machine(Name, Kind, X, Y, V)` for each
    machine.
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
    """Return the beliefs kept after a change of personality."""
    if not isinstance(mind, bdi.Agent):
        return []
    return [belief for belief in mind.beliefs if belief.functor in KEPT]


def first_beliefs(
    entry: PersonEntry, plan: Floorplan, rules: RuleSet, leader: PersonEntry | None = None
) -> list[bdi.Literal | str]:
    """Return the initial beliefs of a person.

    They are about stations, home, exit, leader of the group, pauses and reactions.
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
"""Kinds of recorded entries."""


class MindInspector:
    """Inspector of one agent, which calls `notify` with each `Thought` that changes something."""

    def __init__(self, person: str, notify: Callable[[Thought], None]) -> None:
        self._person = person
        self._notify = notify
        self._steps: list[list[str]] = []
        self._believed: dict[bdi.Literal, None] = {}
        self._intended: list[dict[str, Any]] = []

    def note(self, entry: bdi.Entry) -> None:
        """Record a reasoning step reported by `on_event` of the agent."""
        if entry.kind in STEPS:
            place = [f"{_base(entry.file)}:{entry.line}"] if entry.kind == "plan" else []
            self._steps.append([entry.kind, _plain(entry.text), *place])

    def look(self, t: float, agent: bdi.Agent) -> None:
        """Report the changes made by the thought at `t` (s)."""
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
    """Return the text without the annotations `source(self)` and `source(percept)`."""
    return _SOURCE.sub("", text)


def _base(file: str) -> str:
    return re.split(r"[/\\]", file)[-1]
