"""Services of simulation_interfaces: state, steps and entities of the simulation."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

from rclpy.action import CancelResponse

from ..cell import Cell, Pace
from .messages import set_header, set_pose
from .node import CellNode


class Control:
    """Provider of the services of simulation_interfaces that apply to a trial.

    `step()` advances by one step. It returns False if time is not stepped, or the run is over.
    """

    def __init__(self, ros: CellNode, cell: Cell, pace: Pace, step: Callable[[], bool]) -> None:
        self._cell = cell
        self._pace = pace
        self._step = step
        self._result = ros.find("simulation_interfaces/msg/Result", "simulation_interfaces")
        if self._result is None:
            return
        self._state = ros.find("simulation_interfaces/msg/SimulationState", "simulation_state")
        for name, answer in (
            ("GetSimulatorFeatures", self._get_features),
            ("GetSimulationState", self._get_simulation_state),
            ("SetSimulationState", self._set_simulation_state),
            ("StepSimulation", self._step_simulation),
            ("GetEntities", self._get_entities),
            ("GetEntityState", self._get_entity_state),
        ):
            service = re.sub("(?<=[a-z])(?=[A-Z])", "_", name).lower()
            ros.provide(service, f"simulation_interfaces/srv/{name}", answer)
        self._steps = ros.provide_action(
            "simulate_steps",
            "simulation_interfaces/action/SimulateSteps",
            execute_callback=self._simulate_steps,
            cancel_callback=lambda _: CancelResponse.ACCEPT,
        )

    def _get_features(self, _: Any, response: Any) -> Any:
        have = response.features
        have.features = [
            *(have.ENTITY_STATE_GETTING, have.SIMULATION_STATE_GETTING),
            have.SIMULATION_STATE_SETTING,
            *(have.SIMULATION_STATE_PAUSE, have.STEP_SIMULATION_SINGLE),
            *(have.STEP_SIMULATION_MULTIPLE, have.STEP_SIMULATION_ACTION),
        ]
        return response

    def _get_simulation_state(self, _: Any, response: Any) -> Any:
        paused, playing = self._state.STATE_PAUSED, self._state.STATE_PLAYING
        response.state.state = playing if self._pace.speed and not self._pace.paused else paused
        return self._done(response)

    def _set_simulation_state(self, request: Any, response: Any) -> Any:
        requested, state = request.state.state, self._state
        if requested not in (state.STATE_PLAYING, state.STATE_PAUSED) or not self._pace.speed:
            return self._failed(response, "a trial plays or pauses, and with --step it is paused")
        self._pace.change(paused=requested == state.STATE_PAUSED)
        return self._done(response)

    def _step_simulation(self, request: Any, response: Any) -> Any:
        made = all(self._step() for _ in range(request.steps))
        return self._done(response) if made else self._failed(response, NO_STEP)

    async def _simulate_steps(self, handle: Any) -> Any:
        result, feedback = self._steps.Result(), self._steps.Feedback()
        for left in reversed(range(handle.request.steps)):
            if handle.is_cancel_requested:
                handle.canceled()
                return self._done(result)
            if not self._step():
                handle.abort()
                return self._failed(result, NO_STEP)
            feedback.completed_steps += 1
            feedback.remaining_steps = left
            handle.publish_feedback(feedback)
        handle.succeed()
        return self._done(result)

    def _get_entities(self, request: Any, response: Any) -> Any:
        names = self._cell.simulation.scene.starts
        response.entities = [name for name in names if re.search(request.filters.filter, name)]
        return self._done(response)

    def _get_entity_state(self, request: Any, response: Any) -> Any:
        signals, name = self._cell.signals, request.entity
        signal = signals.get(f"people/{name}/pose") or signals.get(f"machines/{name}/pose")
        pose = signal.read() if signal is not None else None
        if pose is None:
            return self._failed(response, f"there is no entity {name!r} now")
        set_header(response.state.header, self._cell.now)
        set_pose(response.state.pose, pose)
        return self._done(response)

    def _done(self, response: Any) -> Any:
        response.result.result = self._result.RESULT_OK
        return response

    def _failed(self, response: Any, why: str) -> Any:
        response.result.result = self._result.RESULT_OPERATION_FAILED
        response.result.error_message = why
        return response


NO_STEP = "the simulation is not paused, or is over"
