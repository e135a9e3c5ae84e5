"""The same questions to every planner."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from floorplan import Floorplan, UserError

from ..choice import PlannerChoice
from ..world import CollisionWorld
from .attempts import Asked, Attempt, Judge, Spent
from .contenders import Budget, Contender, Ours
from .memory import PeakMemory
from .peers import peer_named
from .questions import Scene, scenes, scenes_of

SEEDED = 50
"""Number of seeded questions where none is given."""


def benchmark(
    plans: Sequence[Floorplan],
    planners: Sequence[str | PlannerChoice],
    *,
    queries: int | None = None,
    runs: int = 1,
    seed: int = 0,
    radius: float | None = None,
    questions: Path | None = None,
    iterations: int | None = None,
    seconds: float | None = None,
    longest: float | None = None,
    progress: Callable[[str, str], None] | None = None,
) -> list[Attempt]:
    """Ask each of `planners` the same `queries` on each of `plans`, for a disc of `radius` metres.

    A planner is a choice of one of Floorwalker's (`"BITstar: {samples_per_batch: 50}"`) or the
    name of a peer. The floor's own people give the radius where none is given. There are 50
    seeded questions, or all of those in the file `questions`, unless `queries` says otherwise;
    each is asked `runs` times, with seeds of their own. `iterations` are the budget of OMPL's
    planners in place of their usual ones; `seconds` of CPU time for each of their answers end
    them too, or alone, and all then depends on the machine. A path of more than `longest` times
    the shortest is a wrong answer. `progress` is called after each answer, with the names of the
    floor and the planner. All but times and memory is the same again for the same seed, unless
    `seconds` are given.
    """
    for name, count in (("queries", queries), ("runs", runs), ("iterations", iterations)):
        if count is not None and count < 1:
            raise UserError(f"{name} must be 1 or more, found {count}")
    for name, figure in (("radius", radius), ("seconds", seconds), ("longest", longest)):
        least = 1 if name == "longest" else 0
        if figure is not None and not least < figure < math.inf:
            raise UserError(f"{name} must be above {least} and finite, found {figure:g}")
    names = [plan.name for plan in plans]
    if twice := [name for name in names if names.count(name) > 1]:
        raise UserError(f"two floors are called {twice[0]!r}: their answers would be mixed up")
    entries = {known(planner): planner for planner in planners}
    budget = Budget(iterations, seconds)
    attempts = []
    for plan in plans:
        keep = plan.human.radius if radius is None else radius
        if questions is None:
            asked = list(scenes(plan, queries=queries or SEEDED, seed=seed, radius=keep))
        else:
            asked = scenes_of(questions, plan, radius=keep, queries=queries, seed=seed)
        terms = _Terms(plan, asked, keep, runs, seed, budget, longest or math.inf)
        for name, planner in entries.items():
            for attempt in terms.attempts(name, planner):
                attempts.append(attempt)
                if progress is not None:
                    progress(plan.name, name)
    return attempts


def known(planner: str | PlannerChoice) -> str:
    """Return `planner` as tables name it; `ValueError` if there is no such planner or peer."""
    if isinstance(planner, str) and peer_named(planner) is not None:
        return planner
    choice = PlannerChoice.of(planner)
    choice.check()
    return str(choice)


@dataclass(frozen=True)
class _Terms:
    """What is the same for all planners on one floor."""

    plan: Floorplan
    scenes: Sequence[Scene]
    radius: float
    runs: int
    seed: int
    budget: Budget
    longest: float

    def attempts(self, name: str, planner: str | PlannerChoice) -> Iterator[Attempt]:
        """Yield the answers of `planner`, which tables call `name`, to all questions."""
        world = CollisionWorld(self.plan)
        contender = self._contender(planner, world)
        judge = Judge(world, self.radius)
        number = 0
        for scene in self.scenes:
            for agv, at in scene.agvs:
                world.move_agv(agv, at)
            begin = time.process_time()
            contender.look()
            looked = time.process_time() - begin
            for k in range(len(scene.questions)):
                for run in range(self.runs):
                    asked = self._asked(scene, k, name, number, run)
                    yield _attempt(judge, contender, asked, looked)
                number += 1

    def _contender(self, planner: str | PlannerChoice, world: CollisionWorld) -> Contender:
        peer = peer_named(planner) if isinstance(planner, str) else None
        if peer is not None:
            return peer.kind(world, self.radius)
        return Ours(world, self.radius, PlannerChoice.of(planner), self.budget)

    def _asked(self, scene: Scene, k: int, name: str, number: int, run: int) -> Asked:
        count = sum(len(scene.questions) for scene in self.scenes)
        start, goal = scene.questions[k]
        return Asked(
            floorplan=self.plan.name,
            planner=name,
            query=number,
            run=run,
            seed=self.seed + number + run * count,
            start=start,
            goal=goal,
            agvs=scene.agvs,
            shortest=scene.shortest[k],
            listed=scene.listed[k] if scene.listed else math.nan,
            longest=self.longest,
        )


def _attempt(judge: Judge, contender: Contender, asked: Asked, looked: float) -> Attempt:
    checks = judge.world.checks
    memory = PeakMemory()
    answer = contender.answer(asked.start, asked.goal, asked.seed)
    spent = Spent(looked, memory.grown(), judge.world.checks - checks)
    return judge.attempt(asked, answer, spent)
