"""Messages: mailbox, sending, questions and the directory of services.

A told belief is believed, and a goal to achieve is adopted. All other messages become a goal,
`+!kqml_received(Sender, Force, Content, Message)`, for the plans of the program and then those of
`messages.asl`.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import overload

from ..actions import ActionError, error_annots
from ..language.loading import parse
from ..language.program import Program
from ..language.quoted import PlanTerm
from ..language.substitution import Unifier, rename, sorted_annots, substitute
from ..language.terms import (
    FALSE,
    FROM_SELF,
    Cons,
    Literal,
    Nil,
    RestVar,
    Term,
    Var,
    make_list,
    plain_text,
    text,
)
from ..language.unification import unify
from ..reasoning.beliefs import with_source
from ..reasoning.execution import WAITING, Call
from ..reasoning.failure import fail
from ..reasoning.intentions import Event, Intention
from ..reasoning.plans import PROTOCOL
from ..reasoning.state import AgentState, learn
from ..society import Message, Society
from .registry import STANDARD, a_number, wrong


@cache
def protocol() -> Program:
    """Return the plans for messages."""
    source = Path(__file__).with_name("messages.asl").read_text(encoding="utf-8")
    return parse(source, PROTOCOL)


def read(agent: AgentState, message: Message) -> None:
    """Handle a message."""
    if message.reply_to:
        question = agent.questions.get(message.reply_to)
        if question is not None:
            question.answer(message)
            return
        if message.is_awaited:
            # The answer arrives after its timeout.
            return
    content = rename(message.content, agent.names, {})
    sender = "self" if message.sender == agent.name else message.sender
    if isinstance(content, Literal) and not agent.plans.has_protocol:
        said = nested_source(content, Literal(sender))
        if message.force == "tell" and content.ground:
            agent.believe(said)
            return
        if message.force == "achieve":
            agent.circumstance.post(Event("+!", with_source(said)))
            return
    # On first use, because most agents never need these plans.
    learn(agent, protocol())
    number = Literal(f"mid{message.question}")
    args = (Literal(sender), Literal(message.force), content, number)
    agent.circumstance.post(Event("+!", Literal("kqml_received", args)))


@overload
def nested_source(term: Literal, sender: Term) -> Literal: ...
@overload
def nested_source(term: Term, sender: Term) -> Term: ...
def nested_source(term: Term, sender: Term) -> Term:
    """Return a literal with a sender as its source, which contains the previous sources.

    In a list, this applies to each element.
    """
    if isinstance(term, Nil | Cons):
        return make_list([nested_source(element, sender) for element in term])
    if not isinstance(term, Literal):
        return term
    rest = [annot for annot in term.annots if isinstance(annot, RestVar)]
    sources = tuple(annot for annot in term.annots if _is_source(annot))
    others = tuple(a for a in term.annots if not _is_source(a) and not isinstance(a, RestVar))
    source = Literal("source", (sender,), sources)
    annots = (*sorted_annots((*others, source)), *rest)
    return term.with_annots(annots)


def without_source(term: Term, source: Term | None = None) -> Term:
    """Return a literal, a plan or a list of them without sources, or without one source."""
    if isinstance(term, Nil | Cons):
        return make_list([without_source(element, source) for element in term])
    if isinstance(term, PlanTerm):
        return term
    if not isinstance(term, Literal):
        return term
    wanted = None if source is None else Literal("source", (source,))
    annots = tuple(
        annot
        for annot in term.annots
        if not (_is_source(annot) and (wanted is None or annot == wanted))
    )
    return term.with_annots(annots)


def _is_source(annot: Term) -> bool:
    return isinstance(annot, Literal) and annot.functor == "source" and len(annot.args) == 1


def answers(agent: AgentState, asked: Term, u: Unifier) -> Iterator[Term]:
    """Yield the answers of an agent to a question, without the source `self`."""
    if not isinstance(asked, Literal) or asked.is_internal_action:
        for solution in agent.logic.solutions(asked, u):
            yield substitute(asked, solution)
        return
    rest = agent.names.fresh("Annots")
    open_ended = not any(isinstance(annot, RestVar) for annot in asked.annots)
    annots = (*asked.annots, RestVar(rest.name, fresh=True)) if open_ended else asked.annots
    query = asked.with_annots(annots)
    for solution in agent.logic.solutions(query, u):
        answer = substitute(query, solution)
        if isinstance(answer, Literal):
            annots = tuple(annot for annot in answer.annots if annot != FROM_SELF)
            yield answer.with_annots(annots)


class AwaitedAnswer:
    """Question of an intention that waits for the answers.

    `number` is that of the question. The answer must unify with `pattern`, as must the list of
    answers if several agents are asked. `receivers` is their number, or None for a single agent.
    `timeout` is the maximum waiting time (ms), if any.
    """

    def __init__(
        self,
        agent: AgentState,
        intention: Intention,
        number: int,
        pattern: Term,
        receivers: int | None,
        timeout: int | None,
    ) -> None:
        self._agent = agent
        self._intention = intention
        self._number = number
        self._pattern = pattern
        self._receivers = receivers
        self._answers: list[Term] = []
        agent.questions[number] = self
        agent.circumstance.suspend("ask", intention, Literal("waiting_ask"))
        if timeout is not None:
            agent.after(timeout, self._time_out)

    def answer(self, message: Message) -> None:
        """Handle an answer. The intention continues after the last one."""
        content = rename(message.content, self._agent.names, {})
        sender = Literal(message.sender)
        if message.force == "untell":
            content = FALSE
        elif message.force == "tellHow" or isinstance(content, Literal | Nil | Cons):
            content = nested_source(content, sender)
        self._answers.append(content)
        answered = Literal("ask_answer", (f"mid{self._number}",))
        if self._receivers is None:
            self._end(content, answered)
        elif len(self._answers) == self._receivers:
            self._end(make_list(self._answers), answered)

    def _time_out(self) -> None:
        if self._number in self._agent.questions:
            none = self._receivers is None
            answer = Literal("timeout") if none else make_list(self._answers)
            self._end(answer, Literal("send_ask_msg_timeout"))

    def _end(self, answer: Term, reason: Literal) -> None:
        agent, intention = self._agent, self._intention
        del agent.questions[self._number]
        if not agent.circumstance.take_pending(intention, "ask"):
            return
        means = intention.top
        if unify(self._pattern, answer, means.u):
            if means.step is not None:
                means.step = means.step.next
            agent.circumstance.resume(intention, reason)
        else:
            pattern = substitute(self._pattern, means.u)
            shown = pattern if isinstance(pattern, Var) else self._pattern
            message = (
                f"reply of an ask message ('{answer}') does not unify with fourth argument of"
                f" .send ('{shown}')"
            )
            fail(agent, intention, error_annots("ask_failed", message))


_ASKS = ("askOne", "askAll", "askHow")
_NUMBER = re.compile(r"mid(\d+)")


@STANDARD.add(".send", least=3, most=5)
def send(call: Call, receiver: Term, force: Term, content: Term, *more: Term) -> object:
    """`.send(Receiver, tell, Content)`. A question with a fourth argument waits for the answer.

    For other messages, a fourth argument is the number of the question that the message answers.
    """
    agent, society = call.agent, call.agent.society
    how = plain_text(force)
    is_list = isinstance(receiver, Nil | Cons)
    names = [
        _name(call, one) for one in (receiver if isinstance(receiver, Nil | Cons) else [receiver])
    ]
    waits = how in _ASKS and bool(more)
    if waits and call.intention is None:
        raise wrong("send", "only the body of a plan can ask a question")
    reply_to = 0
    if more and not waits:
        reply_to = _number(more[0])
    number = society.next_question()
    if waits:
        society.awaited.add(number)
    message = Message(
        sender=agent.name,
        force=how,
        content=content,
        question=number,
        reply_to=reply_to,
        is_awaited=reply_to in society.awaited,
    )
    for name in names:
        society.deliver(name, message)
    if not waits or call.intention is None:
        return True
    timeout = int(a_number("send", more[1], "fifth")) if len(more) > 1 else None
    receivers = len(names) if is_list else None
    AwaitedAnswer(agent, call.intention, number, more[0], receivers, timeout)
    return WAITING


def _name(call: Call, receiver: Term) -> str:
    if isinstance(receiver, str) or (isinstance(receiver, Literal) and receiver.is_atom):
        name = plain_text(receiver)
        return call.agent.name if name == "self" else name
    raise ActionError(
        f"The TO parameter ('{text(receiver)}') of the internal action 'send' is not an atom!"
    )


def _number(term: Term) -> int:
    match = _NUMBER.fullmatch(text(term))
    if match is None:
        raise ActionError(
            f"The Message ID ('{text(term)}') parameter of the internal action 'send' is no"
            " number of a message!"
        )
    return int(match[1])


@STANDARD.add(".broadcast", least=2, most=2)
def broadcast(call: Call, force: Term, content: Term) -> bool:
    """`.broadcast(Force, Content)`: send a message to all others."""
    agent, society = call.agent, call.agent.society
    for name in society.names():
        if name != agent.name:
            number = society.next_question()
            message = Message(
                sender=agent.name, force=plain_text(force), content=content, question=number
            )
            society.deliver(name, message)
    return True


@STANDARD.add(".all_names", least=1, most=1)
def all_names(call: Call, names: Term) -> object:
    """`.all_names(Ns)`: the names of all agents, in the order in which they joined."""
    return call.unify(names, [Literal(name) for name in call.agent.society.names()])


@STANDARD.add("kqml.answer", least=2, most=2)
def answer(call: Call, asked: Term, result: Term) -> Iterator[Unifier]:
    """Yield the answers of the agent to a question, for the plans of `messages.asl`."""
    return call.each(result, answers(call.agent, asked, call.unifier))


# ---- the directory


def _service(service: Term, kind: tuple[Term, ...]) -> tuple[str, str]:
    return plain_text(service), plain_text(kind[0]) if kind else ""


@STANDARD.add(".df_register", least=1, most=2)
def register(call: Call, service: Term, *kind: Term) -> bool:
    """Offer a service, and notify its subscribers."""
    society, name = call.agent.society, call.agent.name
    for subscriber in society.directory.register(name, *_service(service, kind)):
        _tell_provider(society, subscriber, name, service)
    return True


def _tell_provider(society: Society, subscriber: str, provider: str, service: Term) -> None:
    content = Literal("provider", (Literal(provider), service))
    message = Message(sender="df", force="tell", content=content, question=society.next_question())
    society.deliver(subscriber, message)


@STANDARD.add(".df_deregister", least=1, most=2)
def deregister(call: Call, service: Term, *kind: Term) -> bool:
    """`.df_deregister(S, Type?)`: end the offer of a service."""
    call.agent.society.directory.deregister(call.agent.name, *_service(service, kind))
    return True


@STANDARD.add(".df_search", least=2, most=3)
def search(call: Call, service: Term, *more: Term) -> object:
    """`.df_search(Service, Agents)` or `.df_search(Service, Type, Agents)`."""
    *kind, result = more
    agents = call.agent.society.directory.search(*_service(service, tuple(kind)))
    return call.unify(result, make_list([Literal(name) for name in agents]))


@STANDARD.add(".df_subscribe", least=1, most=2)
def subscribe(call: Call, service: Term, *kind: Term) -> bool:
    """`.df_subscribe(S, Type?)`: be notified of present and future providers of a service."""
    society, name = call.agent.society, call.agent.name
    for provider in society.directory.subscribe(name, *_service(service, kind)):
        _tell_provider(society, name, provider, service)
    return True
