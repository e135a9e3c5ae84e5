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

    Parameters
    ----------
    sender : str
        Name of the sender.
    force : str
        Illocutionary force: tell, untell, achieve, unachieve, askOne, askAll, tellHow, untellHow,
        askHow, signal, or a custom one that plans of the receiver handle.
    content : Term
        Literal, formula or answer.
    question : int, optional
        Number of the question, or 0.
    reply_to : int, optional
        Number of the question that this message answers, or 0.
    is_awaited : bool, optional
        Whether the sender waits for the answer.
    """

    sender: str
    force: str
    content: Term
    question: int = 0
    reply_to: int = 0
    is_awaited: bool = False


class Member(Protocol):
    """Interface of the members of a society, such as `Agent`."""

    name: str

    @property
    def now(self) -> float:
        """Time in seconds to which the member has advanced."""

    @property
    def next_wakeup(self) -> float | None:
        """Time in seconds of the next activity, or None."""

    def advance(self, time: float) -> None:
        """Run until there is nothing left to do at `time` (s)."""

    def receive(self, message: Message) -> None:
        """Add a message that a later cycle reads."""


class Directory:
    """Services that agents of a society offer, with their subscribers."""

    def __init__(self) -> None:
        self._offers: dict[tuple[str, str], list[str]] = {}
        self._wanted: dict[tuple[str, str], list[str]] = {}

    def register(self, agent: str, service: str, kind: str) -> list[str]:
        """Register a service of an agent and return its subscribers."""
        offers = self._offers.setdefault((service, kind), [])
        if agent in offers:
            return []
        offers.append(agent)
        return list(self._wanted.get((service, kind), ()))

    def deregister(self, agent: str, service: str, kind: str) -> None:
        """Remove a service of an agent."""
        offers = self._offers.get((service, kind), [])
        if agent in offers:
            offers.remove(agent)

    def search(self, service: str, kind: str) -> list[str]:
        """Return the agents that offer a service, in the order of registration."""
        return list(self._offers.get((service, kind), ()))

    def subscribe(self, agent: str, service: str, kind: str) -> list[str]:
        """Subscribe an agent to a service and return the agents that offer it already."""
        wanted = self._wanted.setdefault((service, kind), [])
        if agent not in wanted:
            wanted.append(agent)
        return self.search(service, kind)

    def leave(self, agent: str) -> None:
        """Remove an agent with its services and subscriptions."""
        for entries in (*self._offers.values(), *self._wanted.values()):
            if agent in entries:
                entries.remove(agent)


class Society:
    """Agents that exchange messages, by name.

    A message is read in the receiver's next cycle. Advance all agents together with `advance`, or
    each on its own. The `next_wakeup` of an agent with unread messages is its current time.

    Attributes
    ----------
    now : float
        Time in seconds to which the agents were advanced.
    awaited : set of int
        Numbers of the questions whose answers are awaited.
    directory : Directory
        Services that the agents offer.

    Examples
    --------
    >>> society = bdi.Society()
    >>> lines = []
    >>> program = bdi.parse("+ready[source(A)] <- .print(A).")
    >>> receiver = bdi.Agent(program, name="receiver", society=society, print=lines.append)
    >>> sender = bdi.Agent(
    ...     bdi.parse("!go. +!go <- .send(receiver, tell, ready)."), name="sender", society=society
    ... )
    >>> society.advance(1.0)
    >>> lines
    ['sender']
    """

    def __init__(self) -> None:
        self._members: dict[str, Member] = {}
        self._numbers = count(1)
        self._seeds: dict[int, str] = {}
        self.now = 0.0
        self.awaited: set[int] = set()
        self.directory = Directory()

    def __iter__(self) -> Iterator[Member]:
        return iter(self._members.values())

    def __repr__(self) -> str:
        return f"<Society of {', '.join(self._members) or 'nobody'}>"

    def join(self, agent: Member) -> None:
        """Add an agent. `Agent` calls this itself.

        Parameters
        ----------
        agent : Agent
            Agent to add.

        Raises
        ------
        ValueError
            If another agent has the same name.
        """
        if agent.name in self._members:
            raise ValueError(f"two agents have the name '{agent.name}'")
        self._members[agent.name] = agent

    def leave(self, name: str) -> None:
        """Remove an agent, so that another one may take its name.

        Parameters
        ----------
        name : str
            Name of the agent. Unknown names are ignored.
        """
        self._members.pop(name, None)
        self.directory.leave(name)

    def own_seed(self, name: str, seed: int) -> int | str:
        """Return the seed with which an agent initializes its random numbers.

        Parameters
        ----------
        name : str
            Name of the agent.
        seed : int
            Seed given to the agent.

        Returns
        -------
        int or str
            `seed` for the first agent that has it, otherwise a text that includes the name.
        """
        first = self._seeds.setdefault(seed, name)
        return seed if first == name else f"{seed} {name}"

    def names(self) -> list[str]:
        """Return the names of all agents, in the order in which they joined."""
        return list(self._members)

    def next_question(self) -> int:
        """Return an unused number for a question."""
        return next(self._numbers)

    def advance(self, time: float) -> None:
        """Advance all agents to `time`, with wake-ups and messages in order of time.

        An agent that has advanced further is left where it is.

        Parameters
        ----------
        time : float
            Time in seconds.

        Raises
        ------
        ValueError
            If the time is not finite.
        EndlessProgramError
            If an agent exceeds its maximum number of cycles, goals, plans or intentions.
        """
        if not math.isfinite(time):
            raise ValueError(f"expected a time in seconds, found {time}")
        while True:
            # All agents advance to each wake-up, so that no agent is ahead of a message to it.
            due = [a.next_wakeup for a in self._members.values() if a.next_wakeup is not None]
            soonest = min((at for at in due if at < time), default=time)
            self.now = max(self.now, soonest)
            # A copy, because actions may add and remove agents.
            for agent in [*self._members.values()]:
                if agent.now <= soonest and self._members.get(agent.name) is agent:
                    agent.advance(soonest)
            # The agents that advanced first may have received messages from the others, and new
            # agents may have joined.
            if soonest >= time and not any(self._is_due(a, time) for a in self._members.values()):
                return

    @staticmethod
    def _is_due(agent: Member, time: float) -> bool:
        wakeup = agent.next_wakeup
        return agent.now <= time and wakeup is not None and wakeup <= time

    def deliver(self, name: str, message: Message) -> None:
        """Deliver a message to the agent called `name`.

        Parameters
        ----------
        name : str
            Name of the receiver.
        message : Message
            Message.

        Raises
        ------
        ActionError
            If there is no such agent.
        """
        if name not in self._members:
            missing = Literal("agent_not_found", (Literal(name),))
            raise ActionError(f"there is no agent '{name}'", "receiver_not_found", (missing,))
        self._members[name].receive(message)
