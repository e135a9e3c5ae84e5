"""Messages of an agent: what it does with those it reads, and questions that await an answer."""

from __future__ import annotations

from ..language.order import sorted_annots
from ..language.substitution import rename, substitute
from ..language.terms import FALSE, Literal, Term, make_list
from ..language.unification import unify
from .actions import error_annots
from .beliefs import with_source
from .deliberation import move_on
from .failure import fail
from .intentions import Event, Intention
from .society import Message
from .state import AgentState


def read(agent: AgentState, message: Message) -> None:
    """Do what a message asks for."""
    if message.force == "answer":
        _take_answer(agent, message)
    elif message.force in ("askOne", "askAll"):
        _answer(agent, message)
    elif isinstance(message.content, Literal):
        _obey(agent, message, message.content)


def _obey(agent: AgentState, message: Message, content: Literal) -> None:
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


def _answer(agent: AgentState, message: Message) -> None:
    society = agent.society
    if society is None or message.sender not in society.names():
        return
    formula = rename(message.content, agent.names, {})
    source = Literal("source", (Literal(agent.name),))
    answers = [_from(substitute(formula, u), source) for u in agent.logic.solutions(formula, {})]
    content: Term = make_list(answers)
    if message.force == "askOne":
        content = answers[0] if answers else FALSE
    society.deliver(message.sender, Message(agent.name, "answer", content, message.question))


def _from(term: Term, source: Literal) -> Term:
    if isinstance(term, Literal):
        return term.with_annots(sorted_annots((*term.annots, source)))
    return term


def await_answer(
    agent: AgentState, intention: Intention, question: int, answer: Term, timeout: int | None
) -> None:
    """Suspend an intention until a question is answered, for at most `timeout` (ms)."""

    def take(message: Message) -> None:
        if not agent.circumstance.take_pending(intention, "ask"):
            return
        means = intention.top
        if unify(answer, message.content, means.u):
            move_on(agent, intention, means)
        else:
            reason = f"the answer {message.content} is not what was expected"
            fail(agent, intention, error_annots("ask_failed", reason))

    agent.questions[question] = take
    agent.circumstance.suspend("ask", intention, Literal("ask", (float(question),)))
    if timeout is not None:
        late = Message("", "answer", Literal("timeout"), question)
        agent.after(timeout, lambda: _take_answer(agent, late))


def _take_answer(agent: AgentState, message: Message) -> None:
    take = agent.questions.pop(message.question, None)
    if take is not None:
        take(message)
