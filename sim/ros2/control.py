"""Services of simulation_interfaces that control time: state, steps and reset."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

from rclpy.action import CancelResponse

from ..cell import Pace
from ..competition import Values
from ..competition.transport import Answer
from .messages import filled
from .node import CellNode

FEATURES = [2, 4, 5, 6, 7, 8, 10, 12, 20, 24, 25, 26, 31, 32, 33, 43]
"""Numbers in SimulatorFeatures of what each trial supports.

Named poses; tags, bounds of three types, categories, states and information of entities;
reset; reading, setting and pausing the state; one step, several and their action; the world.
"""

STOPPED, PLAYING, PAUSED, QUITTING = range(4)
"""States of SimulationState."""

UNSUPPORTED, OK, NOT_FOUND, _, FAILED = range(5)
"""Results of all services."""

ALREADY = 101
"""Result of SetSimulationState if there is nothing to change."""

TIME_AND_STATE = 3
"""Scope of a reset."""

NO_STEP = "the simulation is not paused, or is over"


class Control:
    """Provider of the services that control time.

    `step()` advances by one step. It returns False if time is not stepped, or the run is over.
    `reset()` begins the run again.
    """

    def __init__(
        self, ros: CellNode, pace: Pace, step: Callable[[], bool], reset: Callable[[], None]
    ) -> None:
        self._ros = ros
        self._pace = pace
        self._step = step
        self._reset = reset
        self._is_stopped = False
        provide_all(
            ros,
            GetSimulatorFeatures=lambda _, __: {"features": {"features": FEATURES}},
            GetSimulationState=lambda _, __: done(state={"state": self._state}),
            SetSimulationState=self._set_state,
            StepSimulation=self._step_simulation,
            ResetSimulation=self._reset_simulation,
        )
        self._steps = ros.provide_action(
            "simulate_steps",
            "simulation_interfaces/SimulateSteps",
            execute_callback=self._simulate_steps,
            cancel_callback=lambda _: CancelResponse.ACCEPT,
        )

    @property
    def _state(self) -> int:
        if self._pace.speed and not self._pace.paused:
            return PLAYING
        return STOPPED if self._is_stopped else PAUSED

    def _set_state(self, _: Any, request: Values) -> Values:
        state, pace = request["state"]["state"], self._pace
        if state == self._state:
            return failed("it is in this state", ALREADY)
        if state == QUITTING:
            pace.end()
        elif state == STOPPED:
            self._reset()
        elif state != PAUSED and not (state == PLAYING and pace.speed):
            return failed("this simulation has no such state", UNSUPPORTED)
        if pace.speed:
            pace.change(paused=state != PLAYING)
        self._is_stopped = state == STOPPED
        return done()

    def _step_simulation(self, _: Any, request: Values) -> Values:
        made = all(self._one_step() for _ in range(request["steps"]))
        return done() if made else failed(NO_STEP)

    def _one_step(self) -> bool:
        self._is_stopped = False
        return self._step()

    async def _simulate_steps(self, handle: Any) -> Any:
        feedback, steps, end = self._steps.Feedback(), handle.request.steps, handle.succeed
        result = done()
        while feedback.completed_steps < steps:
            await self._ros.next_turn()  # in which the action may be cancelled
            if handle.is_cancel_requested:
                end = handle.canceled
                break
            if not self._one_step():
                result, end = failed(NO_STEP), handle.abort
                break
            feedback.completed_steps += 1
            feedback.remaining_steps = steps - feedback.completed_steps
            handle.publish_feedback(feedback)
        end()
        return filled(self._steps.Result(), result)

    def _reset_simulation(self, _: Any, request: Values) -> Values:
        if request["scope"] and request["scope"] & TIME_AND_STATE != TIME_AND_STATE:
            return failed("time and state are reset together", UNSUPPORTED)
        self._reset()
        return done()


def provide_all(ros: CellNode, **services: Answer) -> None:
    """Provide services by the names of their types: SetSimulationState is set_simulation_state."""
    for name, answer in services.items():
        service = re.sub("(?<=[a-z])(?=[A-Z])", "_", name).lower()
        ros.provide(service, f"simulation_interfaces/{name}", answer)


def done(**values: Any) -> Values:
    """Return a response with success."""
    return {"result": {"result": OK}, **values}


def failed(why: str, result: int = FAILED) -> Values:
    """Return a response with a failure and its reason."""
    return {"result": {"result": result, "error_message": why}}
