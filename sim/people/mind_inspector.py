"""What goes on in a person's mind, as changes from thought to thought.

What Jason's mind inspector shows of an agent at an instant, kept small enough for every instant
of a run: only what a thought has changed is written down.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

import bdi

from ..core.recorder import Thought

_SOURCE = re.compile(r"\[source\((?:self|percept)\)\]")
_STEPS = ("percept", "plan", "action", "warning")


class MindInspector:
    """Looks into one agent; `tell` takes a `Thought` whenever something has changed."""

    def __init__(self, person: str, tell: Callable[[Thought], None]) -> None:
        self._person = person
        self._tell = tell
        self._steps: list[list[str]] = []
        self._believed: dict[bdi.Literal, None] = {}
        self._intended: list[dict[str, Any]] = []

    def heed(self, entry: bdi.Entry) -> None:
        """Something has happened inside: to be given to the agent as `on_event`, or by it."""
        if entry.kind in _STEPS:
            place = [f"{_base(entry.file)}:{entry.line}"] if entry.kind == "plan" else []
            self._steps.append([entry.kind, _plain(entry.text), *place])

    def look(self, t: float, agent: bdi.Agent) -> None:
        """The agent has thought at `t` (seconds): tell what that has changed."""
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
            self._tell(thought)


def _intention(intention: bdi.Intention) -> dict[str, Any]:
    stack = [_plain(str(means.trigger)) for means in intention.stack]
    return {"stack": stack, "at": _plain(intention.top.doing)}


def _plain(text: str) -> str:
    """Without the sources that every belief has."""
    return _SOURCE.sub("", text)


def _base(file: str) -> str:
    return re.split(r"[/\\]", file)[-1]
