"""Times in which machines stood still, by cause, and the people who caused them."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from floorplan.files.dataclass import dataclass

from ..core.body import MachineShape
from ..core.recorder import Event
from ..machines.gantry.robot import GANTRY
from ..machines.kinds import KINDS
from ..safety.margins import moving_spans
from .outcome import Outcome
from .sampling import Span

UNRECORDED = "not recorded"
"""Cause of a standstill of a custom machine that records none."""

CAUSES_OF_STOPS = {
    "penalty": "disabled as a penalty",
    "malfunction": "disabled by a malfunction of the trial",
    "hold": "held by a command",
    "protective stop": "stopped by the rules, for a person",
    "protective field": "stopped by its protective field, for a person",
    "blackout": "stopped as its protective fields are blind",
    "no field set": "stopped at a velocity without protective field",
    "people": "waits at its own decision, to keep the distance to a person",
    "traffic": "waits for another machine",
    "blocked": "waits before what closes its lane or its route",
    "warning field": "can't drive slowly enough for a person in its warning field",
    "job wait": "waits as a job of the trial says",
    "job": "stands in a job: it handles a part, or its place is out of reach",
    "nothing to do": "has no job, or no move under way",
    UNRECORDED: "a custom machine, which records no causes",
}
"""Causes of standing still in order of priority, and their meanings."""


FASTER = 0.05
"""m/s. A machine that gains as much while it brakes has resumed."""


@dataclass(frozen=True)
class Standstill:
    """A time from `begin` to `end` (s) in which a machine stood still for one `cause`.

    `who` is the person, machine or obstacle that caused it, if any.
    """

    begin: float
    end: float
    cause: str
    who: str = ""


@dataclass(frozen=True, kw_only=True)
class MachineTimes:
    """Times of one machine, in one run or in several.

    `moving` is the time of motion (s). `stopped` has the standstill time (s) by cause. `whom` has
    the number and duration (s) of stops by cause and person (or obstacle), the longest first.
    `jobs_done` counts finished jobs. `had_jobs` is True if there was something to do.
    """

    machine: str
    moving: float
    stopped: dict[str, float]
    whom: dict[tuple[str, str], tuple[int, float]]
    jobs_done: int
    had_jobs: bool


def times_of_all(runs: Iterable[Sequence[MachineTimes]]) -> list[MachineTimes]:
    """Return the total times of each machine in several runs."""
    by_machine: dict[str, list[MachineTimes]] = {}
    for times in runs:
        for one in times:
            by_machine.setdefault(one.machine, []).append(one)
    return [
        MachineTimes(
            machine=machine,
            moving=math.fsum(one.moving for one in several),
            stopped=_seconds((cause, s) for one in several for cause, s in one.stopped.items()),
            whom=_counted((key, n, s) for one in several for key, (n, s) in one.whom.items()),
            jobs_done=sum(one.jobs_done for one in several),
            had_jobs=any(one.had_jobs for one in several),
        )
        for machine, several in by_machine.items()
    ]


def _seconds(parts: Iterable[tuple[str, float]]) -> dict[str, float]:
    totals = dict.fromkeys(CAUSES_OF_STOPS, 0.0)
    for cause, seconds in parts:
        totals[cause] += seconds
    return {cause: seconds for cause, seconds in totals.items() if seconds > 0.0}


def _counted(
    parts: Iterable[tuple[tuple[str, str], int, float]],
) -> dict[tuple[str, str], tuple[int, float]]:
    totals: dict[tuple[str, str], tuple[int, float]] = {}
    for key, n, seconds in parts:
        count, before = totals.get(key, (0, 0.0))
        totals[key] = count + n, before + seconds
    return dict(sorted(totals.items(), key=lambda one: -one[1][1]))


JobKey = tuple[object, ...]
"""Identity of a job: its kind and the fields of its events."""


_BEGINS = {
    "gantry_disabled": "penalty",
    "robot_malfunction": "malfunction",
    "protective_stop": "protective stop",
    "gantry_yielded": "people",
    "agv_yielded": "people",
    "field_slowdown": "warning field",
    "machine_waiting": "traffic",
    "machine_blocked": "blocked",
    "agv_blocked": "blocked",
}
"""Causes that begin with an event, by its kind."""

_ENDS = {
    "gantry_enabled": ("penalty", "malfunction"),
    "protective_stop_ended": ("protective stop",),
    "field_stop_ended": ("protective field", "blackout", "no field set"),
    "field_slowdown_ended": ("warning field",),
    "machine_proceeds": ("traffic",),
}
"""Causes that end with an event, by its kind."""


class _State:
    """Causes for which a machine stands still, and its jobs."""

    def __init__(self, otherwise: str) -> None:
        self.holding: dict[str, str] = {}
        """Person or machine that each cause concerns."""
        self.jobs: set[JobKey] = set()
        self._otherwise = otherwise
        self.blocked_at: float | None = None
        """Last lane position (m) before the obstacle on the lane of an AGV."""

    def cause(self) -> tuple[str, str]:
        """Return the cause of a standstill, and the person or machine it concerns."""
        holding = {**self.holding}
        if self.jobs:
            holding["job wait" if any(job[0] == "wait" for job in self.jobs) else "job"] = ""
        if self._otherwise != UNRECORDED:  # the machine can drive slowly enough
            holding.pop("warning field", None)
        first = next((cause for cause in CAUSES_OF_STOPS if cause in holding), self._otherwise)
        return first, holding.get(first, "")

    def end(self, *causes: str) -> None:
        """Remove causes."""
        for cause in causes:
            self.holding.pop(cause, None)

    def take(self, event: Event, penalised: str) -> None:
        """Apply an event of the machine. `penalised` is the person of the last penalty."""
        kind = event["kind"]
        self.end(*_ENDS.get(kind, ()))
        cause = _BEGINS.get(kind)
        if kind == "field_stop":
            cause = "protective field" if event["cause"] == "intrusion" else event["cause"]
        elif kind == "commanded":
            self.end("hold")
            cause = "hold" if "hold" in event else None
        if cause is not None:
            whom = (event.get(name) for name in ("person", "for_machine", "by"))
            concerned = penalised if cause == "penalty" else next(filter(None, whom), "")
            self.holding[cause] = concerned
        if kind == "agv_blocked":
            self.blocked_at = event["at"]
        elif kind == "agv_moved":
            self.end("people")
            # A blocked AGV drives to the last position before the obstacle.
            if event["to"] != self.blocked_at:
                self.end("blocked")
        elif kind == "job_started":
            self.jobs.add(_job(event))
        elif kind in ("job_done", "order_submitted"):
            self.jobs.discard(_job(event))


def machine_times(run: Outcome) -> list[MachineTimes]:
    """Return the times of each machine of a run, or of one after its warm-up."""
    logs: dict[str, list[tuple[Event, str]]] = {one.name: [] for one in run.scene.machines}
    robots = [one.name for one in run.scene.machines if one.category == "robot"]
    penalised: dict[str, str] = {}
    for event in run.events:
        if event["kind"] == "violation" and event["penalty"]:
            penalised[event["with"]] = event["person"]
        elif event["kind"] == "penalty":
            penalised.update((name, event["person"]) for name in robots)
        name = _machine_of(event)
        if name in logs:
            logs[name].append((event, penalised.get(name, "")))
    ordered = any(event["kind"] == "order_announced" for event in run.events)
    return [_times(run, one, logs[one.name], ordered) for one in run.scene.machines]


def _times(
    run: Outcome, machine: MachineShape, log: list[tuple[Event, str]], ordered: bool
) -> MachineTimes:
    since, end = run.presence[machine.name]
    spans = moving_spans(run.motions[machine.name], turning=machine.kind == "amr")
    log = [(e, who) for e, who in log if _leads_to_a_stop(run, machine.name, e, spans)]
    moves = [(max(a, since), min(b, end)) for a, b in spans if b > since and a < end]
    kinds = {event["kind"] for event, _ in log}
    worked = ordered or not kinds.isdisjoint(("job_started", "gantry_yielded"))
    otherwise = "nothing to do" if machine.kind in KINDS else UNRECORDED
    done = [e for e, _ in log if e["kind"] == "job_done" and e["t"] >= since]
    stops = [*_joined(_stops(_State(otherwise), log, moves, since, end))]
    return MachineTimes(
        machine=machine.name,
        moving=math.fsum(b - a for a, b in moves),
        stopped=_seconds((stop.cause, stop.end - stop.begin) for stop in stops),
        whom=_counted(
            ((stop.cause, stop.who), 1, stop.end - stop.begin) for stop in stops if stop.who
        ),
        jobs_done=len(done),
        had_jobs=machine.kind != "agv" and worked,
    )


def _leads_to_a_stop(run: Outcome, machine: str, event: Event, moves: Sequence[Span]) -> bool:
    """Return False if a gantry braked for a person but resumed before it stopped."""
    t = event["t"]
    end = next((b for a, b in moves if a < t < b), None)
    if event["kind"] != "gantry_yielded" or end is None:
        return True
    changes = [piece.end for piece in run.motions[machine].pieces if t < piece.end < end]
    speeds = np.hypot(*run.motions[machine].velocity(np.array([t, *changes, end])).T)
    return bool((np.diff(speeds) <= FASTER).all())


def _stops(
    state: _State, log: Sequence[tuple[Event, str]], moves: Sequence[Span], since: float, end: float
) -> Iterator[Standstill]:
    """Yield the stops of a machine between its moves, split where their cause may change."""
    events = iter([*log, None])
    following = next(events)
    at = since
    for begin, until in [*moves, (end, math.inf)]:
        while following is not None and following[0]["t"] < begin:
            t = max(at, following[0]["t"])
            yield Standstill(at, t, *state.cause())
            state.take(*following)
            following, at = next(events), t
        yield Standstill(at, begin, *state.cause())
        # A moving machine no longer waits, and only slows down for people.
        while following is not None and following[0]["t"] == begin < end:
            state.take(*following)
            following = next(events)
        state.end("people")
        if state.blocked_at is None:
            state.end("blocked")
        at = until


def _joined(stops: Iterable[Standstill]) -> Iterator[Standstill]:
    """Yield stops with a duration, joining adjacent ones with the same cause."""
    last: Standstill | None = None
    for stop in stops:
        if stop.end <= stop.begin:
            continue
        after = (stop.begin, stop.cause, stop.who)
        if last is not None and (last.end, last.cause, last.who) == after:
            last = replace(last, end=stop.end)
            continue
        if last is not None:
            yield last
        last = stop
    if last is not None:
        yield last


def _job(event: Event) -> JobKey:
    """Return the identity of the job of an event."""
    if event["kind"] == "order_submitted":
        return ("submit", event["order"])
    job = event["job"]
    if job == "submit":
        return (job, event.get("order"))
    return (job, *(event.get(name) for name in ("part", "tray", "from", "to", "quadrant", "order")))


def _machine_of(event: Event) -> str:
    """Return the machine that an event concerns, or the gantry if it names no machine."""
    if event["kind"] == "commanded":
        return str(event.get("hold") or event.get("release") or "")
    return str(event.get("machine") or event.get("agv") or GANTRY)
