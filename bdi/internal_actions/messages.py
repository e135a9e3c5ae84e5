"""Messages between the agents of one run."""

from __future__ import annotations

from collections.abc import Mapping

from ..language.terms import Cons, Literal, Nil, Term, plain_text
from ..reasoning.actions import ActionError, InternalAction
from ..reasoning.calls import WAITING, Call
from ..reasoning.mail import await_answer
from ..reasoning.society import Message
from .arguments import a_number, wrong

_FORCES = ("tell", "untell", "achieve", "unachieve", "askOne", "askAll")


def send(call: Call, receiver: Term, force: Term, content: Term, *more: Term) -> object:
    """`.send(Receiver, tell, Content)`; an ask with a fourth argument waits for the answer."""
    agent = call.agent
    how = plain_text(force)
    if how not in _FORCES:
        raise wrong("send", f"second argument must be one of {', '.join(_FORCES)}, not '{how}'")
    if agent.society is None:
        raise ActionError(f"{agent.name} is alone: there is nobody to send to")
    names = receiver if isinstance(receiver, Nil | Cons) else [receiver]
    asks = how in ("askOne", "askAll")
    waits = asks and bool(more)
    if waits and (isinstance(receiver, Nil | Cons) or call.intention is None):
        raise wrong("send", "one question goes to one agent, from a plan's body")
    message = Message(agent.name, how, content, agent.society.next_question() if asks else 0)
    for name in names:
        agent.society.deliver(plain_text(name), message)
    if not waits or call.intention is None:
        return True
    timeout = int(a_number("send", more[1], "fifth")) if len(more) > 1 else None
    await_answer(agent, call.intention, message.question, more[0], timeout)
    return WAITING


def broadcast(call: Call, force: Term, content: Term) -> bool:
    agent = call.agent
    how = plain_text(force)
    if how not in _FORCES:
        raise wrong("broadcast", f"first argument must be one of {', '.join(_FORCES)}")
    if agent.society is not None:
        for name in agent.society.names():
            if name != agent.name:
                agent.society.deliver(name, Message(agent.name, how, content))
    return True


def all_names(call: Call, names: Term) -> object:
    agent = call.agent
    known = [agent.name] if agent.society is None else agent.society.names()
    return call.unify(names, [Literal(name) for name in known])


ACTIONS: Mapping[str, InternalAction] = {
    ".send": InternalAction(send, 3, 5),
    ".broadcast": InternalAction(broadcast, 2, 2),
    ".all_names": InternalAction(all_names, 1, 1),
}
