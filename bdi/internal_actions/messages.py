"""Messages between the agents of one run, and the directory of what they offer."""

from __future__ import annotations

import re
from collections.abc import Iterator

from ..language.substitution import Unifier
from ..language.terms import Cons, Literal, Nil, Term, make_list, plain_text, text
from ..reasoning.actions import ActionError
from ..reasoning.calls import WAITING, Call
from ..reasoning.mail import Question, answers
from ..reasoning.society import Message, Society
from .arguments import a_number, wrong
from .registry import STANDARD

_ASKS = ("askOne", "askAll", "askHow")
_NUMBER = re.compile(r"mid(\d+)")


def _society(call: Call) -> Society:
    society = call.agent.society
    assert society is not None  # every agent is at least in a society of its own
    return society


@STANDARD.add(".send", least=3, most=5)
def send(call: Call, receiver: Term, force: Term, content: Term, *more: Term) -> object:
    """`.send(Receiver, tell, Content)`; an ask with a fourth argument waits for the answer.

    A fourth argument of any other message is the number of the message that it answers.
    """
    agent, society = call.agent, _society(call)
    how = plain_text(force)
    is_list = isinstance(receiver, Nil | Cons)
    names = [
        _name(call, one) for one in (receiver if isinstance(receiver, Nil | Cons) else [receiver])
    ]
    waits = how in _ASKS and bool(more)
    if waits and call.intention is None:
        raise wrong("send", "a question is asked from a plan's body")
    reply_to = 0
    if more and not waits:
        reply_to = _number(more[0])
    number = society.next_question()
    if waits:
        society.awaited.add(number)
    message = Message(agent.name, how, content, number, reply_to, reply_to in society.awaited)
    for name in names:
        society.deliver(name, message)
    if not waits or call.intention is None:
        return True
    timeout = int(a_number("send", more[1], "fifth")) if len(more) > 1 else None
    receivers = len(names) if is_list else None
    Question(agent, call.intention, number, more[0], receivers, timeout)
    return WAITING


def _name(call: Call, receiver: Term) -> str:
    if isinstance(receiver, str) or (isinstance(receiver, Literal) and receiver.is_atom):
        name = plain_text(receiver)
        return call.agent.name if name == "self" else name
    raise ActionError(
        f"The TO parameter ('{text(receiver)}') of the internal action 'send' is not an atom!"
    )


def _number(term: Term) -> int:
    found = _NUMBER.fullmatch(text(term))
    if found is None:
        raise ActionError(
            f"The Message ID ('{text(term)}') parameter of the internal action 'send' is no"
            " number of a message!"
        )
    return int(found[1])


@STANDARD.add(".broadcast", least=2, most=2)
def broadcast(call: Call, force: Term, content: Term) -> bool:
    """`.broadcast(Force, Content)`: send a message to all others."""
    agent, society = call.agent, _society(call)
    for name in society.names():
        if name != agent.name:
            number = society.next_question()
            society.deliver(name, Message(agent.name, plain_text(force), content, number))
    return True


@STANDARD.add(".all_names", least=1, most=1)
def all_names(call: Call, names: Term) -> object:
    """`.all_names(Ns)`: the names of all agents, in the order in which they joined."""
    return call.unify(names, [Literal(name) for name in _society(call).names()])


@STANDARD.add("kqml.answer", least=2, most=2)
def answer(call: Call, asked: Term, result: Term) -> Iterator[Unifier]:
    """Yield the answers of the agent to a question, for the plans of `messages.asl`."""
    return call.each(result, answers(call.agent, asked, call.unifier))


# ---- the directory


def _service(service: Term, kind: tuple[Term, ...]) -> tuple[str, str]:
    return plain_text(service), plain_text(kind[0]) if kind else ""


@STANDARD.add(".df_register", least=1, most=2)
def register(call: Call, service: Term, *kind: Term) -> bool:
    """Offer a service, and tell those who have subscribed to it."""
    society, name = _society(call), call.agent.name
    for subscriber in society.directory.register(name, *_service(service, kind)):
        _tell_provider(society, subscriber, name, service)
    return True


def _tell_provider(society: Society, subscriber: str, provider: str, service: Term) -> None:
    content = Literal("provider", (Literal(provider), service))
    society.deliver(subscriber, Message("df", "tell", content, society.next_question()))


@STANDARD.add(".df_deregister", least=1, most=2)
def deregister(call: Call, service: Term, *kind: Term) -> bool:
    """`.df_deregister(S, Type?)`: offer a service no longer."""
    _society(call).directory.deregister(call.agent.name, *_service(service, kind))
    return True


@STANDARD.add(".df_search", least=2, most=3)
def search(call: Call, service: Term, *more: Term) -> object:
    """`.df_search(Service, Agents)` or `.df_search(Service, Type, Agents)`."""
    *kind, result = more
    found = _society(call).directory.search(*_service(service, tuple(kind)))
    return call.unify(result, make_list([Literal(name) for name in found]))


@STANDARD.add(".df_subscribe", least=1, most=2)
def subscribe(call: Call, service: Term, *kind: Term) -> bool:
    """`.df_subscribe(S, Type?)`: be told of those who offer a service, now and later."""
    society, name = _society(call), call.agent.name
    for provider in society.directory.subscribe(name, *_service(service, kind)):
        _tell_provider(society, name, provider, service)
    return True
