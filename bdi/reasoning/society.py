"""Agents that can send messages to each other."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import count
from typing import Protocol

from ..language.terms import Term
from .actions import ActionError


@dataclass(frozen=True)
class Message:
    """Message from one agent to another.

    Attributes:
        sender: name of the agent that sends it.
        force: its illocutionary force: tell, untell, achieve, unachieve, askOne, askAll, or answer.
        content: literal, formula or answer.
        question: number that an ask and its answer share, else 0.
    """

    sender: str
    force: str
    content: Term
    question: int = 0


class Member(Protocol):
    """Member of a society; `Agent` is one."""

    name: str

    @property
    def now(self) -> float:
        """Time up to which it has advanced (s)."""

    @property
    def next_wakeup(self) -> float | None:
        """Time at which it has something to do (s), or None."""

    @property
    def has_mail(self) -> bool:
        """True if it has messages to read."""

    def advance(self, time: float) -> None:
        """Run until nothing is left to do at `time` (s)."""

    def receive(self, message: Message) -> None:
        """Take a message, to be read in a later cycle."""


class Society:
    """The agents of a run by name, between which messages are carried.

    A message is read by its receiver in the next cycle it runs. Advance all agents together with
    `advance`, or each on its own: the `next_wakeup` of one that has mail is now.
    """

    def __init__(self) -> None:
        self._members: dict[str, Member] = {}
        self._numbers = count(1)

    def __iter__(self) -> Iterator[Member]:
        return iter(self._members.values())

    def __repr__(self) -> str:
        return f"<Society of {', '.join(self._members) or 'nobody'}>"

    def join(self, agent: Member) -> None:
        """Add an agent.

        Raises:
            ValueError: the name is taken.
        """
        if agent.name in self._members:
            raise ValueError(f"two agents have the name '{agent.name}'")
        self._members[agent.name] = agent

    def leave(self, name: str) -> None:
        """Remove the agent of that name, if there is one: another may take the name."""
        self._members.pop(name, None)

    def names(self) -> list[str]:
        """Return the names of all agents, in the order in which they joined."""
        return list(self._members)

    def next_question(self) -> int:
        """Return a number that no question has had yet."""
        return next(self._numbers)

    def advance(self, time: float) -> None:
        """Advance all agents to `time` (s), each wake-up and message in its order."""
        while True:
            due = [a.next_wakeup for a in self._members.values() if a.next_wakeup is not None]
            soonest = min((at for at in due if at < time), default=time)
            for agent in self._members.values():
                if agent.now <= soonest:
                    agent.advance(soonest)
            if soonest >= time and not any(a.has_mail for a in self._members.values()):
                return

    def deliver(self, name: str, message: Message) -> None:
        """Give `message` to the agent called `name`.

        Raises:
            ActionError: there is no such agent.
        """
        if name not in self._members:
            raise ActionError(f"there is no agent '{name}'", "unknown_receiver")
        self._members[name].receive(message)
