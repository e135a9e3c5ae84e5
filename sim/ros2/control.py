"""Services of simulation_interfaces that control time: state, steps and reset."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

from rclpy.action import CancelResponse

from ..cell import Pace
from .node import CellNode

FEATURES = (
    *("NAMED_POSES", "ENTITY_TAGS", "ENTITY_BOUNDS", "ENTITY_BOUNDS_BOX", "ENTITY_BOUNDS_CONVEX"),
    *("ENTITY_CATEGORIES", "ENTITY_STATE_GETTING", "ENTITY_INFO_GETTING", "WORLD_INFO_GETTING"),
    *("SIMULATION_STATE_GETTING", "SIMULATION_STATE_SETTING", "SIMULATION_STATE_PAUSE"),
    *("STEP_SIMULATION_SINGLE", "STEP_SIMULATION_MULTIPLE", "STEP_SIMULATION_ACTION"),
)
"""Features of each trial, as SimulatorFeatures names them."""


class Control:
    """Provider of the services that control time.

    `step()` advances by one step. It returns False if time is not stepped, or the run is over.
    `reset()` begins the run again. It is None if that is not possible.
    """

    def __init__(
        self, ros: CellNode, pace: Pace, step: Callable[[], bool], reset: Callable[[], None] | None
    ) -> None:
        self._ros = ros
        self._pace = pace
        self._step = step
        self._reset = reset
        self._is_stopped = False
        self._state = ros.find("simulation_interfaces/msg/SimulationState", "simulation_state")
        if self._state is None:
            return
        provide_all(
            ros,
            GetSimulatorFeatures=self._get_features,
            GetSimulationState=self._get_state,
            SetSimulationState=self._set_state,
            StepSimulation=self._step_simulation,
            ResetSimulation=self._reset_simulation,
        )
        self._steps = ros.provide_action(
            "simulate_steps",
            "simulation_interfaces/action/SimulateSteps",
            execute_callback=self._simulate_steps,
            cancel_callback=lambda _: CancelResponse.ACCEPT,
        )

    def _get_features(self, _: Any, response: Any) -> Any:
        names = [*FEATURES, "SIMULATION_RESET"] if self._reset else FEATURES
        known = response.features
        known.features = [getattr(known, name) for name in names if hasattr(known, name)]
        return response

    def _get_state(self, _: Any, response: Any) -> Any:
        response.state.state = self._present()
        return done(response)

    def _present(self) -> int:
        state, pace = self._state, self._pace
        if pace.speed and not pace.paused:
            return int(state.STATE_PLAYING)
        return int(state.STATE_STOPPED if self._is_stopped else state.STATE_PAUSED)

    def _set_state(self, request: Any, response: Any) -> Any:
        requested, state, pace = request.state.state, self._state, self._pace
        if requested == self._present():
            return failed(response, "it is in this state", "ALREADY_IN_TARGET_STATE")
        if requested == state.STATE_QUITTING:
            pace.end()
        elif requested == state.STATE_PLAYING and not pace.speed:
            return failed(response, "with --step, time does not play", "STATE_TRANSITION_ERROR")
        elif requested == state.STATE_STOPPED and self._reset is not None:
            self._reset()
        elif requested not in (state.STATE_PLAYING, state.STATE_PAUSED):
            return failed(response, "a trial has no such state", UNSUPPORTED)
        if pace.speed:
            pace.change(paused=requested != state.STATE_PLAYING)
        self._is_stopped = requested == state.STATE_STOPPED
        return done(response)

    def _step_simulation(self, request: Any, response: Any) -> Any:
        steps = range(request.steps)
        return done(response) if all(self._one_step() for _ in steps) else failed(response, NO_STEP)

    def _one_step(self) -> bool:
        self._is_stopped = False
        return self._step()

    async def _simulate_steps(self, handle: Any) -> Any:
        result, feedback = self._steps.Result(), self._steps.Feedback()
        for left in reversed(range(handle.request.steps)):
            await self._ros.next_turn()  # in which the action may be cancelled
            if handle.is_cancel_requested:
                handle.canceled()
                return done(result)
            if not self._one_step():
                handle.abort()
                return failed(result, NO_STEP)
            feedback.completed_steps += 1
            feedback.remaining_steps = left
            handle.publish_feedback(feedback)
        handle.succeed()
        return done(result)

    def _reset_simulation(self, request: Any, response: Any) -> Any:
        if self._reset is None:
            return failed(response, "sim.ros2.serve has no `restart`", UNSUPPORTED)
        everything = request.SCOPE_TIME | request.SCOPE_STATE
        if request.scope and request.scope & everything != everything:
            return failed(response, "time and state are reset together", UNSUPPORTED)
        self._reset()
        return done(response)


NO_STEP = "the simulation is not paused, or is over"

UNSUPPORTED = "RESULT_FEATURE_UNSUPPORTED"


def provide_all(ros: CellNode, **services: Callable[[Any, Any], Any]) -> None:
    """Provide services by the names of their types: SetSimulationState is set_simulation_state."""
    for name, answer in services.items():
        service = re.sub("(?<=[a-z])(?=[A-Z])", "_", name).lower()
        ros.provide(service, f"simulation_interfaces/srv/{name}", answer)


def done(response: Any) -> Any:
    """Return a response with success."""
    response.result.result = response.result.RESULT_OK
    return response


def failed(response: Any, why: str, code: str = "RESULT_OPERATION_FAILED") -> Any:
    """Return a response with the name of a code, of its own or of all results, and a reason."""
    owner = response if hasattr(response, code) else response.result
    response.result.result = getattr(owner, code)
    response.result.error_message = why
    return response
