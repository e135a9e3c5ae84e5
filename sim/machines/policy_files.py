"""Policies in ONNX files as controllers of machines."""

from __future__ import annotations

import json
from collections.abc import Callable
from functools import cached_property, partial
from pathlib import Path
from typing import Any

import numpy as np

from floorplan.files.dataclass import dataclass
from floorplan.files.reading import is_file

from ..core.custom_code import CodeFolder
from .commanding import Steps
from .policy import ActionBounds, Interface, driven, flat
from .policy_driven import PolicyDriven
from .supervision import ControllerError

SUFFIX = ".onnx"

METADATA = "floorwalker"
"""Key of the metadata of a file that contains the fields of its `Interface` as JSON."""


@dataclass(frozen=True)
class PolicyFile:
    """Policy in an ONNX file, which is not read before `load`."""

    file: Path
    folder: Path

    @classmethod
    def find(cls, name: str, folder: CodeFolder) -> PolicyFile:
        """Return the policy file of that name in a folder. `ControllerError` if there is none."""
        file = (folder.path / name).resolve()
        if not is_file(file):
            raise ControllerError(f"the policy {name!r} can't be found: there is no file {file}")
        return cls(file, folder.path.resolve())

    def load(self) -> Callable[[PolicyDriven], Steps]:
        """Return the controller. `ControllerError` says what is wrong with the file."""
        self._session.get_inputs()
        return self._controller

    def _controller(self, machine: PolicyDriven) -> Steps:
        actions, interface = ActionBounds(machine), self._interface
        output = self._session.get_outputs()[0]
        for node, count, what in (
            (self._session.get_inputs()[0], interface.size, "input"),
            (output, 1 if "int" in output.type else actions.count, "output"),
        ):
            size = node.shape[-1] if node.shape else None
            if isinstance(size, int) and size != count:
                raise ControllerError(
                    f"the {what} {node.name!r} of {self.file.name} has {size} numbers, not {count}:"
                    f" state the interface as metadata {METADATA!r}, or export the policy again"
                )
        return driven(partial(self._choose, actions), interface, machine)

    def _choose(self, actions: ActionBounds, machine: PolicyDriven) -> list[float]:
        observation = flat(self._interface.observe(machine))[np.newaxis]
        node = self._session.get_inputs()[0].name
        action = np.asarray(self._session.run(None, {node: observation})[0]).ravel()
        if np.issubdtype(action.dtype, np.integer):
            return actions.choice(action.item())
        return actions.command(np.clip(action, -1.0, 1.0))

    @cached_property
    def _interface(self) -> Interface:
        written = self._session.get_modelmeta().custom_metadata_map.get(METADATA, "{}")
        try:
            return Interface(**json.loads(written))
        except (TypeError, ValueError) as why:
            message = f"the metadata {METADATA!r} of {self.file.name} is no interface: {why}"
            raise ControllerError(message) from why

    @cached_property
    def _session(self) -> Any:
        try:
            import onnxruntime
        except ImportError:
            message = f"{self.file.name} needs onnxruntime: pip install 'floorwalker[onnx]'"
            raise ControllerError(message) from None
        options = onnxruntime.SessionOptions()
        # One thread adds numbers in the same order each time.
        options.intra_op_num_threads = options.inter_op_num_threads = 1
        options.log_severity_level = 4
        try:
            return onnxruntime.InferenceSession(
                str(self.file), options, providers=["CPUExecutionProvider"]
            )
        except Exception as why:  # the library's errors have no class in common
            first = str(why).splitlines()[0]
            raise ControllerError(f"{self.file.name} can't be read as ONNX: {first}") from why
