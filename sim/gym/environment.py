"""Gymnasium environments: one machine of a trial, driven by a policy."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from floorplan import InputError, UserError
from floorplan.files.dataclass import dataclass

from ..core.entries import Pose
from ..core.recorder import Event, Listener
from ..machines.policy import (
    ActionBounds,
    Array,
    Interface,
    Observation,
    flat,
)
from ..machines.policy_driven import PolicyDriven
from ..runs.run import Run
from ..studies.design import Study
from ..trials.trial import Trial
from .drawing import Picture
from .ticks import Ticks, names_of

FOLDER = Path(__file__).parent.parent / "data" / "gym"
"""Folder of the built-in studies."""

MOST_DRAWS = 100
"""Number of draws after which a reset gives up."""


@dataclass(frozen=True)
class Transition:
    """Changes of a machine between two ticks, for a reward.

    Attributes
    ----------
    machine : PolicyDriven
        The machine.
    events : tuple of dict
        Events of the run.
    progress : float
        Distance in metres by which the goal has come nearer.
    goals : int
        Number of goals reached.
    contacts : int
        Number of contacts with people, the floor or machines.
    penalties : int
        Number of penalties.
    goal : (float, float, float) or None
        Goal now: x, y in metres and rotation in radians, or None if all are reached.
    observation : dict
        The observation, as arrays.
    """

    machine: PolicyDriven
    events: tuple[Event, ...]
    progress: float
    goals: int
    contacts: int
    penalties: int
    goal: Pose | None
    observation: Observation

    @property
    def margin(self) -> float:
        """Least distance minus required distance to a person now, in metres."""
        return float(self.observation["margin"][0])

    @property
    def done(self) -> bool:
        """Whether all goals are reached, or the machine has touched something."""
        return self.contacts > 0 or self.goal is None


def usual_reward(step: Transition) -> float:
    """Return the progress in metres, 10 for a goal, -10 for a contact and -1 for a penalty."""
    return step.progress + 10.0 * step.goals - 10.0 * step.contacts - 1.0 * step.penalties


class Episodes:
    """Trials drawn from a study, and the machines in them that policies drive."""

    def __init__(
        self, source: str | Path | Trial | Study, names: Sequence[str], interface: Interface
    ) -> None:
        self.study = study_of(source)
        known = names_of(self.study.trials[0])
        if not known:
            raise UserError(f"trial: {self.study.trials[0].name} has no vehicle and no gantry")
        self.names = [*names] or known
        self.interface = interface
        self.ticks = Ticks(self.study.trials[0], self.names, interface)
        self._goals: dict[str, tuple[float, float] | None] = {}
        self._distances: dict[str, float] = {}

    def reset(self, seed: int, *listeners: Listener) -> None:
        """Begin a trial that is drawn with a seed. `ValueError` if no draw gives a valid one."""
        fault: Exception | None = None
        for k in range(MOST_DRAWS):
            try:
                trial = replace(self.study, seed=seed + k).row(0).trial
                self.ticks = Ticks(trial, self.names, self.interface, *listeners)
            except (InputError, UserError) as why:
                fault = why
                continue
            self.ticks.advance({})
            for name in self.names:
                self._note(name, self.ticks.machines[name].goal_pose)
            return
        raise UserError(f"none of {MOST_DRAWS} draws of {self.study.name} can be run: {fault}")

    def observe(self, name: str) -> Observation:
        """Return what a machine observes now."""
        return self.interface.observe(self.ticks.machines[name])

    def step(self, name: str) -> Transition:
        """Return what has happened to a machine since the last tick."""
        machine, events = self.ticks.machines[name], self.ticks.events
        before, distance = self._goals[name], self._distances[name]
        goal = machine.goal_pose
        self._note(name, goal)
        goals = sum(
            one["kind"] == "job_done" and one.get("machine", name) == name for one in events
        )
        if before is not None and before != self._goals[name]:
            distance -= self.interface.goal_radius if goals else distance
        else:
            distance -= self._distances[name]
        kinds = [one["kind"] for one in events if name in (one.get("machine"), one.get("with"))]
        return Transition(
            machine,
            events,
            progress=distance if before is not None else 0.0,
            goals=goals,
            contacts=kinds.count("contact") + kinds.count("collision"),
            penalties=sum(one["kind"] == "penalty" for one in events),
            goal=goal,
            observation=self.observe(name),
        )

    def info(self, step: Transition) -> dict[str, Any]:
        """Return time, events, and the cost: how far the margin is below 0, in metres."""
        now = self.ticks.simulation.clock.now
        return {"time": now, "events": step.events, "cost": max(0.0, -step.margin)}

    def _note(self, name: str, goal: Pose | None) -> None:
        """Remember a goal without its rotation, and its distance now."""
        place = self.ticks.machines[name].position[:2]
        self._goals[name] = None if goal is None else goal[:2]
        self._distances[name] = 0.0 if goal is None else math.dist(goal[:2], place)


def study_of(source: str | Path | Trial | Study) -> Study:
    """Return a study, or the study of one trial. Raises `InputError` for a file with errors."""
    if isinstance(source, Study):
        return source
    if isinstance(source, Trial):
        return Study(source.name, (source,))
    if str(source).endswith(".study.yaml"):
        return Study.load(source)
    trial = Trial.load(str(source))
    return Study(trial.name, (trial,))


class Spaces:
    """Spaces of the observations and actions of one machine, and their checks."""

    def __init__(self, episodes: Episodes, name: str, *, observation: str, actions: str) -> None:
        for key, value, known in (
            ("observation", observation, ("dict", "flat")),
            ("actions", actions, ("continuous", "discrete")),
        ):
            if value not in known:
                raise UserError(f"{key} must be {known[0]!r} or {known[1]!r}, not {value!r}")
        machine = episodes.ticks.machines[name]
        self._flat = observation == "flat"
        bounds = episodes.interface.bounds(machine)
        self.observation: spaces.Space[Any] = spaces.Dict(
            {key: spaces.Box(low, high, dtype=np.float32) for key, (low, high) in bounds.items()}
        )
        if self._flat:
            low, high = (
                np.concatenate([pair[k].ravel() for pair in bounds.values()]) for k in (0, 1)
            )
            self.observation = spaces.Box(low, high, dtype=np.float32)
        self._actions = ActionBounds(machine)
        self.action: spaces.Space[Any] = spaces.Box(-1.0, 1.0, (self._actions.count,), np.float32)
        if actions == "discrete":
            self.action = spaces.Discrete(len(self._actions.choices))

    def observed(self, observation: Observation) -> Observation | Array:
        """Return an observation as the space has it."""
        return flat(observation) if self._flat else observation

    def chosen(self, action: Any) -> list[float]:
        """Return an action as numbers. `ValueError` says what is wrong with it."""
        if isinstance(self.action, spaces.Discrete):
            return self._actions.choice(action)
        return self._actions.command(action)


class FloorEnv(gymnasium.Env[Any, Any]):
    """Environment in which a policy drives one machine among people.

    An episode ends when all goals are reached or the machine touches something, and is truncated at
    the end of the trial.

    Parameters
    ----------
    trial : str, Path, Trial or Study
        Built-in trial, or a trial or study file. The `random` variables of a study are drawn at
        each reset.
    machine : str, optional
        Name of the machine. Defaults to the first vehicle or gantry.
    observation : {"dict", "flat"}, optional
        Form of the observations.
    actions : {"continuous", "discrete"}, optional
        Form of the actions, which are numbers from -1 to 1 (see `ActionBounds`). Discrete ones
        combine -1, 0 and 1.
    reward : callable, optional
        Function of a `Transition` that returns the reward. Defaults to `usual_reward`.
    render_mode : {"rgb_array"}, optional
        Mode of `render`.
    **keys
        Fields of `Interface`, such as `rate` (Hz), `people` and `rays`.

    Raises
    ------
    InputError
        If the trial or study has errors.
    ValueError
        If an argument is invalid.
    """

    metadata = {"render_modes": ["rgb_array"], "render_fps": 5}

    def __init__(
        self,
        trial: str | Path | Trial | Study = FOLDER / "amr.study.yaml",
        *,
        machine: str = "",
        observation: str = "dict",
        actions: str = "continuous",
        reward: Callable[[Transition], float] = usual_reward,
        render_mode: str | None = None,
        **keys: Any,
    ) -> None:
        check_render_mode(render_mode)
        self.interface = interface_of(keys)
        study = study_of(trial)
        names = [machine] if machine else names_of(study.trials[0])[:1]
        self.episodes = Episodes(study, names, self.interface)
        self.name = self.episodes.names[0]
        self.render_mode = render_mode
        self._reward = reward
        self._spaces = Spaces(self.episodes, self.name, observation=observation, actions=actions)
        self.observation_space = self._spaces.observation
        self.action_space = self._spaces.action
        self._picture: Picture | None = None

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Begin a trial that is drawn with a seed.

        Parameters
        ----------
        seed : int, optional
            Seed of this episode and those after it.
        options : dict, optional
            None are known.
        """
        super().reset(seed=seed)
        self.episodes.reset(int(self.np_random.integers(2**31)))
        self._picture = None
        return self._spaces.observed(self.episodes.observe(self.name)), {"time": 0.0, "cost": 0.0}

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Carry out an action until the next tick.

        Returns
        -------
        tuple
            Observation, reward, whether all goals are reached or something was touched, whether the
            trial has ended, and `time` (s), `events` and `cost` (m below the required distance).

        Raises
        ------
        ValueError
            If the action is not within the bounds.
        """
        self.episodes.ticks.advance({self.name: self._spaces.chosen(action)})
        step = self.episodes.step(self.name)
        return (
            self._spaces.observed(step.observation),
            float(self._reward(step)),
            step.done,
            self.episodes.ticks.over,
            self.episodes.info(step),
        )

    def render(self) -> NDArray[np.uint8] | None:
        """Return a picture of the floor, as (height, width, 3), with `render_mode="rgb_array"`."""
        if self.render_mode is None:
            return None
        if self._picture is None:
            self._picture = Picture(self.episodes.ticks.simulation)
        return self._picture.frame(self.episodes.ticks.machines[self.name].goal_pose)

    def run(self) -> Run:
        """Return the run of this episode up to now, for a recording or a replay page."""
        return self.episodes.ticks.finish()


def check_render_mode(mode: str | None) -> None:
    """Raise `ValueError` for a mode of `render` that does not exist."""
    if mode not in (None, "rgb_array"):
        raise UserError(f"render_mode must be 'rgb_array', not {mode!r}")


def interface_of(keys: dict[str, Any]) -> Interface:
    """Return the interface with these fields. `ValueError` names an unknown one."""
    try:
        return Interface(**keys)
    except TypeError:
        known = ", ".join(Interface.__dataclass_fields__)
        raise UserError(f"unknown argument among {', '.join(keys)}; known are {known}") from None
