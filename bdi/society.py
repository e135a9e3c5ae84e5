"""Societies: agents that send messages to each other, and their directory of services."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import count
from typing import Protocol

from .actions import ActionError
from .language.terms import Literal, Term


@dataclass(frozen=True, kw_only=True)
class Message:
    """Message from one agent to another.

    Attributes:
        sender: name of the agent that sends it.
        force: its illocutionary force: tell, untell, achieve, unachieve, askOne, askAll, tellHow,
            untellHow, askHow, signal, or one that plans of the receiver know.
        content: literal, formula or answer.
        question: its number, 0 if it has none.
        reply_to: number of the question that it answers, else 0.
        is_awaited: True if the one who asks waits for the answer.
    """

    sender: str
    force: str
    content: Term
    question: int = 0
    reply_to: int = 0
    is_awaited: bool = False


class Member(Protocol):
    """Member of a society; `Agent` is one."""

    name: str

    @property
    def now(self) -> float:
        """Time up to which it has advanced (s)."""

    @property
    def next_wakeup(self) -> float | None:
        """Time at which it has something to do (s), or None."""

    def advance(self, time: float) -> None:
        """Run until nothing is left to do at `time` (s)."""

    def receive(self, message: Message) -> None:
        """Take a message, to be read in a later cycle."""


class Directory:
    """Services that agents of a society offer, and those who want to know of them."""

    def __init__(self) -> None:
        self._offers: dict[tuple[str, str], list[str]] = {}
        self._wanted: dict[tuple[str, str], list[str]] = {}

    def register(self, agent: str, service: str, kind: str) -> list[str]:
        """Note that an agent offers a service; return those who want to know of it."""
        offers = self._offers.setdefault((service, kind), [])
        if agent in offers:
            return []
        offers.append(agent)
        return list(self._wanted.get((service, kind), ()))

    def deregister(self, agent: str, service: str, kind: str) -> None:
        """Forget that an agent offers a service."""
        offers = self._offers.get((service, kind), [])
        if agent in offers:
            offers.remove(agent)

    def search(self, service: str, kind: str) -> list[str]:
        """Return the agents that offer a service, in the order in which they registered."""
        return list(self._offers.get((service, kind), ()))

    def subscribe(self, agent: str, service: str, kind: str) -> list[str]:
        """Note that an agent wants to know of a service; return those who offer it already."""
        wanted = self._wanted.setdefault((service, kind), [])
        if agent not in wanted:
            wanted.append(agent)
        return self.search(service, kind)

    def leave(self, agent: str) -> None:
        """Forget an agent."""
        for entries in (*self._offers.values(), *self._wanted.values()):
            if agent in entries:
                entries.remove(agent)


class Society:
    """The agents of a run by name, between which messages are carried.

    A message is read by its receiver in the next cycle it runs. Advance all agents together with
    `advance`, or each on its own: the `next_wakeup` of one that has mail is now.
    """

    def __init__(self) -> None:
        self._members: dict[str, Member] = {}
        self._numbers = count(1)
        self._seeds: dict[int, str] = {}
        #: Time up to which its agents have been advanced (s).
        self.now = 0.0
        #: Numbers of the questions whose answers are waited for.
        self.awaited: set[int] = set()
        self.directory = Directory()

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
        self.directory.leave(name)

    def own_seed(self, name: str, seed: int) -> int | str:
        """Return the seed with which the agent of a name begins, no two of them the same."""
        first = self._seeds.setdefault(seed, name)
        return seed if first == name else f"{seed} {name}"

    def names(self) -> list[str]:
        """Return the names of all agents, in the order in which they joined."""
        return list(self._members)

    def next_question(self) -> int:
        """Return a number that no question has had yet."""
        return next(self._numbers)

    def advance(self, time: float) -> None:
        """Advance all agents to `time` (s), each wake-up and message in its order.

        An agent that is further already stays where it is.

        Raises:
            ValueError: the time is not finite.
            EndlessProgramError: an agent does not end at one instant.
        """
        if not math.isfinite(time):
            raise ValueError(f"expected a time in seconds, found {time}")
        while True:
            # From wake-up to wake-up of any of them: nobody is ahead of a message that is on its
            # way to them.
            due = [a.next_wakeup for a in self._members.values() if a.next_wakeup is not None]
            soonest = min((at for at in due if at < time), default=time)
            self.now = max(self.now, soonest)
            # A copy: an action of one of them may add agents, or have some leave.
            for agent in [*self._members.values()]:
                if agent.now <= soonest and self._members.get(agent.name) is agent:
                    agent.advance(soonest)
            # Those who were advanced first may have been written to by the others since, at the
            # same time, and some may have joined.
            if soonest >= time and not any(self._is_due(a, time) for a in self._members.values()):
                return

    @staticmethod
    def _is_due(agent: Member, time: float) -> bool:
        wakeup = agent.next_wakeup
        return agent.now <= time and wakeup is not None and wakeup <= time

    def deliver(self, name: str, message: Message) -> None:
        """Give `message` to the agent called `name`.

        Raises:
            ActionError: there is no such agent.
        """
        if name not in self._members:
            missing = Literal("agent_not_found", (Literal(name),))
            raise ActionError(f"there is no agent '{name}'", "receiver_not_found", (missing,))
        self._members[name].receive(message)
