"""Contents of a person's mind, as changes from thought to thought.

They are those of Jason's mind inspector, which shows an agent at an instant; to keep them for every
instant of a run, only the changes that a thought has made are recorded.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

import bdi

from ..core.recorder import Thought

_SOURCE = re.compile(r"\[source\((?:self|percept)\)\]")
STEPS = ("percept", "plan", "action", "warning")
"""Kinds of entries that are noted."""


class MindInspector:
    """Looks into one agent; `notify` takes a `Thought` whenever something has changed."""

    def __init__(self, person: str, notify: Callable[[Thought], None]) -> None:
        self._person = person
        self._notify = notify
        self._steps: list[list[str]] = []
        self._believed: dict[bdi.Literal, None] = {}
        self._intended: list[dict[str, Any]] = []

    def note(self, entry: bdi.Entry) -> None:
        """Take note of a step of the agent's reasoning, as its `on_event` reports it."""
        if entry.kind in STEPS:
            place = [f"{_base(entry.file)}:{entry.line}"] if entry.kind == "plan" else []
            self._steps.append([entry.kind, _plain(entry.text), *place])

    def look(self, t: float, agent: bdi.Agent) -> None:
        """Notify of the changes that the agent's thought at `t` (seconds) has made."""
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


def _intention(intention: bdi.Intention) -> dict[str, Any]:
    stack = [_plain(str(means.trigger)) for means in intention.stack]
    return {"stack": stack, "at": _plain(intention.top.doing)}


def _plain(text: str) -> str:
    """Return the text without the sources that every belief has."""
    return _SOURCE.sub("", text)


def _base(file: str) -> str:
    return re.split(r"[/\\]", file)[-1]
