"""Agents that can send messages to each other."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import count
from typing import TYPE_CHECKING

from .failure import error_annots, fail
from .intentions import Event, Intention
from .order import sorted_annots
from .steps import with_source
from .terms import FALSE, Literal, Term, make_list
from .unify import rename, substitute, unify
from .waiting import MILLISECOND

if TYPE_CHECKING:
    from .agent import Agent


@dataclass(frozen=True)
class Message:
    """What one agent says to another; `question` numbers an ask and its answer."""

    sender: str
    force: str
    content: Term
    question: int = 0


@dataclass
class _Question:
    asker: Agent
    intention: Intention
    force: str
    answer: Term


class Society:
    """Knows the agents of a run by name and carries what they say.

    A message is read by its receiver in the next cycle it runs. Advance all
    agents together with `advance`, or each on its own: one that has mail has
    its `next_wakeup` now.
    """

    def __init__(self) -> None:
        self._agents: dict[str, Agent] = {}
        self._numbers = count(1)
        self._questions: dict[int, _Question] = {}

    def __iter__(self) -> Iterator[Agent]:
        return iter(self._agents.values())

    def join(self, agent: Agent) -> None:
        """Raises ValueError when the name is taken."""
        if agent.name in self._agents:
            raise ValueError(f"two agents have the name '{agent.name}'")
        self._agents[agent.name] = agent

    def leave(self, name: str) -> None:
        """Forgets the agent of that name, if there is one: another may take the name."""
        self._agents.pop(name, None)

    def names(self) -> list[str]:
        """The names of all agents, in the order in which they joined."""
        return list(self._agents)

    def next_question(self) -> int:
        """A number that no question has had yet."""
        return next(self._numbers)

    def advance(self, time: float) -> None:
        """Advances all agents to `time` (s), each wake-up and message in its order."""
        while True:
            due = [a.next_wakeup for a in self._agents.values() if a.next_wakeup is not None]
            soonest = min((at for at in due if at < time), default=time)
            for agent in self._agents.values():
                if agent.now <= soonest:
                    agent.advance(soonest)
            if soonest >= time and not any(a.has_mail for a in self._agents.values()):
                return

    def deliver(self, name: str, message: Message) -> None:
        """Gives `message` to the agent called `name`; raises ActionError when there is none."""
        receiver = self._agents.get(name)
        if receiver is None:
            from .failure import ActionError

            raise ActionError(f"there is no agent '{name}'", "unknown_receiver")
        receiver.receive(message)

    # ---- reading mail

    def process(self, agent: Agent, message: Message) -> None:
        """What a message does to the agent that reads it."""
        content = message.content
        if message.force == "answer":
            self._take_answer(message)
        elif message.force in ("askOne", "askAll"):
            self._answer(agent, message)
        elif isinstance(content, Literal):
            self._obey(agent, message, content)

    def _obey(self, agent: Agent, message: Message, content: Literal) -> None:
        sender = "self" if message.sender == agent.name else message.sender
        source = Literal("source", (Literal(sender),))
        literal = rename(with_source(content, source), agent.names, {})
        if not isinstance(literal, Literal):
            return
        if message.force == "tell":
            agent.believe(literal)
        elif message.force == "untell":
            agent.disbelieve(literal)
        elif message.force == "achieve":
            agent.circumstance.post(Event("+!", literal))
        elif message.force == "unachieve":
            for intention in list(agent.circumstance.intentions()):
                if intention.wants(content, {}):
                    agent.circumstance.drop(intention)
            agent.circumstance.remove_goals(content, {})

    def _answer(self, agent: Agent, message: Message) -> None:
        formula = rename(message.content, agent.names, {})
        found = [substitute(formula, u) for u in agent.logic.solutions(formula, {})]
        source = Literal("source", (Literal(agent.name),))
        answers = [self._from(term, source) for term in found]
        content: Term = make_list(answers)
        if message.force == "askOne":
            content = answers[0] if answers else FALSE
        if message.sender in self._agents:
            answer = Message(agent.name, "answer", content, message.question)
            self._agents[message.sender].receive(answer)

    def _from(self, term: Term, source: Literal) -> Term:
        if isinstance(term, Literal):
            return term.with_annots(sorted_annots((*term.annots, source)))
        return term

    # ---- questions

    def ask(
        self,
        agent: Agent,
        intention: Intention,
        message: Message,
        answer: Term,
        timeout: int | None,
    ) -> None:
        """An intention waits for the answer to a question, at most `timeout` ms."""
        self._questions[message.question] = _Question(agent, intention, message.force, answer)
        agent.circumstance.suspend("ask", intention, Literal("ask", (float(message.question),)))
        if timeout is not None:
            agent.alarms.set(
                agent.clock + timeout * MILLISECOND,
                lambda: self._take_answer(
                    Message("", "answer", Literal("timeout"), message.question)
                ),
            )

    def _take_answer(self, message: Message) -> None:
        question = self._questions.pop(message.question, None)
        if question is None:
            return
        agent, intention = question.asker, question.intention
        if not agent.circumstance.take_pending(intention, "ask"):
            return
        means = intention.top
        if unify(question.answer, message.content, means.u):
            agent.move_on(intention, means)
        else:
            reason = f"the answer {message.content} is not what was expected"
            fail(agent, intention, error_annots("ask_failed", reason))
