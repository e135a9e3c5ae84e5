"""PettingZoo environment: several machines of a trial, each driven by a policy."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray
from pettingzoo import ParallelEnv

from floorplan import UserError

from ..studies.design import Study
from ..trials.trial import Trial
from .drawing import Picture
from .environment import (
    FOLDER,
    Episodes,
    Spaces,
    Transition,
    check_render_mode,
    interface_of,
    usual_reward,
)


class ParallelFloorEnv(ParallelEnv):  # type: ignore[misc]  # the package has no types
    """Environment in which policies drive several machines of a trial.

    A machine leaves the episode when its goals are reached or it touches something. Then it stops.

    Parameters
    ----------
    trial, observation, actions, reward, render_mode, **keys
        See `FloorEnv`.
    machines : sequence of str, optional
        Names of the machines. Defaults to all vehicles and gantries.
    """

    metadata = {"name": "floorwalker_v0", "render_modes": ["rgb_array"]}

    def __init__(
        self,
        trial: str | Path | Trial | Study = FOLDER / "two_amrs.study.yaml",
        *,
        machines: Sequence[str] = (),
        observation: str = "dict",
        actions: str = "continuous",
        reward: Callable[[Transition], float] = usual_reward,
        render_mode: str | None = None,
        **keys: Any,
    ) -> None:
        check_render_mode(render_mode)
        self.episodes = Episodes(trial, machines, interface_of(keys))
        self.possible_agents = [*self.episodes.names]
        self.agents = [*self.possible_agents]
        self.render_mode = render_mode
        self._reward = reward
        self._spaces = {
            name: Spaces(self.episodes, name, observation=observation, actions=actions)
            for name in self.possible_agents
        }
        self._random = np.random.default_rng()
        self._stands: dict[str, list[float]] = {}
        self._picture: Picture | None = None

    def observation_space(self, agent: str) -> spaces.Space[Any]:
        """Return the space of the observations of a machine."""
        return self._spaces[agent].observation

    def action_space(self, agent: str) -> spaces.Space[Any]:
        """Return the space of the actions of a machine."""
        return self._spaces[agent].action

    def reset(
        self, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, Any], dict[str, dict[str, Any]]]:
        """Begin a trial that is drawn with a seed, as `FloorEnv.reset` does."""
        if seed is not None:
            self._random = np.random.default_rng(seed)
        self.episodes.reset(int(self._random.integers(2**31)))
        self.agents, self._picture, self._stands = [*self.possible_agents], None, {}
        observed = {
            name: self._spaces[name].observed(self.episodes.observe(name)) for name in self.agents
        }
        return observed, {name: {"time": 0.0, "cost": 0.0} for name in self.agents}

    def step(self, actions: dict[str, Any]) -> tuple[dict[str, Any], ...]:
        """Carry out the actions of all machines until the next tick, as `FloorEnv.step` does."""
        chosen = dict(self._stands)
        for name in self.agents:
            if name not in actions:
                raise UserError(f"actions has none for {name}")
            chosen[name] = self._spaces[name].chosen(actions[name])
        ticks = self.episodes.ticks
        ticks.advance(chosen)
        agents, over = self.agents, ticks.over
        steps = {name: self.episodes.step(name) for name in agents}
        done = {name: one.done for name, one in steps.items()}
        for name in agents:
            if done[name]:
                self._stands[name] = ticks.machines[name].stop_action
        self.agents = [name for name in agents if not (done[name] or over)]
        return (
            {name: self._spaces[name].observed(one.observation) for name, one in steps.items()},
            {name: float(self._reward(one)) for name, one in steps.items()},
            done,
            dict.fromkeys(agents, over),
            {name: self.episodes.info(one) for name, one in steps.items()},
        )

    def render(self) -> NDArray[np.uint8] | None:
        """Return a picture of the floor, as `FloorEnv.render` does."""
        if self.render_mode is None:
            return None
        if self._picture is None:
            self._picture = Picture(self.episodes.ticks.simulation)
        return self._picture.frame(None)
