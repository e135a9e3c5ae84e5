"""Live beliefs: queries use the current values and raise no events."""

import pytest

import bdi


class World:
    """A position that changes, and the number of queries about it."""

    def __init__(self):
        self.x = 0
        self.looks = 0

    def here(self):
        self.looks += 1
        return [(self.x, bdi.Literal("b"))]


def make(source, world, **options):
    lines = []
    agent = bdi.Agent(
        bdi.parse(source),
        print=lines.append,
        settings=bdi.AgentSettings(live={("here", 2): world.here}),
        **options,
    )
    return agent, lines


ASKING = {
    "a test goal": "?here(X, _); .print(X)",
    "a rule": "?there(X); .print(X)",
    "a context": "!context",
    "an annotation": "?here(X, _)[source(percept)]; .print(X)",
    "findall": ".findall(A, here(A, _), [X]); .print(X)",
    "count": "?here(X, _); .count(here(X, _), 1); .print(X)",
    "belief": ".belief(here(X, _)); .print(X)",
    "a condition": "if (here(A, b) & A > 0) { .print(A) } else { .print(0) }",
    "a loop": "for (here(A, _)) { .print(A) }",
    "anything": "Q = here(X, b); ?Q; .print(X)",
    "any belief": ".findall(A, (B & B =.. [here, [A, _], _]), [X]); .print(X)",
}


@pytest.mark.parametrize("body", ASKING.values(), ids=ASKING)
def test_each_query_uses_the_current_live_beliefs(body):
    world = World()
    source = (
        f"there(X) :- here(X, _). !go. +!go <- {body}; .wait(1000); !go."
        " +!context : here(X, b) <- .print(X). +here(_, _) <- .print(event)."
    )
    agent, lines = make(source, world)
    for t in range(4):
        world.x = t * t
        agent.advance(float(t))
    assert lines == ["0", "1", "4", "9"]


def test_other_queries_do_not_call_the_source():
    world = World()
    agent, lines = make(
        "other(1). here(1). !go. +!go : other(X) & not here(X, 1, 2) & not ~here(X, 1)"
        " <- +more(X); -+other(X + 1); .findall(Y, more(Y), L); .print(L); .wait(10); !go."
        " +other(_) <- .print(changed). +!look <- ?here(X, _).",
        world,
    )
    agent.advance(1.0)
    assert len(lines) > 100
    list(agent.beliefs)
    assert world.looks == 0


def test_stored_beliefs_of_the_same_key_can_be_changed():
    world = World()
    agent, lines = make(
        "here(7, own). here(X, far) :- X = 9. !go."
        "+!go <- .findall(X, here(X, _), L); .print(L); -here(_, _); -here(_, _);"
        " .abolish(here(_, _)); -+here(8, own); .findall(Y, here(Y, _), M); .print(M)."
        "-!go <- .print(failed).",
        world,
    )
    agent.advance(0.0)
    assert lines == ["[0,7,9]", "[0,8,9]"]
    assert [str(belief) for belief in agent.beliefs] == ["here(8,own)[source(self)]"]


def test_stored_beliefs_of_the_same_key_are_indexed():
    world = World()
    many = " ".join(f"here({n}, n)." for n in range(1, 100))
    agent, lines = make(
        f"{many} !go. +!go <- ?here(50, W); .print(W); ?here(0, V); .print(V).", world
    )
    agent.advance(0.0)
    assert lines == ["n", "b"]


def test_a_source_with_a_wrong_number_of_arguments_is_rejected():
    agent = bdi.Agent(
        bdi.parse("!go. +!go <- ?here(X, Y)."),
        settings=bdi.AgentSettings(live={("here", 2): lambda: [(1.0, 2.0, 3.0)]}),
    )
    with pytest.raises(ValueError, match="here takes 2 arguments"):
        agent.advance(0.0)
