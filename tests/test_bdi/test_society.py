"""Messages between agents."""

import math

import pytest
from goals import printed

import bdi


def make(programs):
    society = bdi.Society()
    log = []
    agents = {
        name: bdi.Agent(
            bdi.parse(source),
            name=name,
            society=society,
            print=lambda line, name=name: log.append((name, line)),
        )
        for name, source in programs.items()
    }
    return society, agents, log


def test_telling_and_asking():
    society, agents, log = make(
        {
            "ann": """!go. +!go <- .send(bob,tell,sky(blue)); .wait(1);
                .send(bob,askOne,sea(_),A); .print(A); .send(bob,askAll,boat(_),B); .print(B);
                .send(bob,askOne,moon(_),C); .print(C);
                .send(bob,achieve,sing(2)); .send(bob,untell,sky(blue)); .wait(1);
                .broadcast(tell,bye).""",
            "bob": """sea(grey). boat(1). boat(2). +sky(X)[source(S)] <- .print(X," from ",S).
                -sky(X) <- .print("no ",X). +!sing(N)[source(S)] <- .print("la ",N," for ",S).
                +bye <- .print("bye").""",
            "cyd": "+bye[source(S)] <- .print(S, ' left').",
        }
    )
    society.advance(1.0)
    assert log == [
        ("bob", "blue from ann"),
        ("ann", "sea(grey)[source(bob)]"),
        ("ann", "[boat(1)[source(bob)],boat(2)[source(bob)]]"),
        ("ann", "false"),
        ("bob", "la 2 for ann"),
        ("bob", "no blue"),
        ("bob", "bye"),
        ("cyd", "ann' left'"),
    ]
    assert agents["ann"].now == 1.0


def test_messages_may_have_namespaces():
    society, _, log = make(
        {
            "ann": """!go. +!go <- .send(bob, tell, [sea::blue, sea::deep(3)]); .wait(5);
                .send(bob, achieve, [sea::swim(1)]); .send(bob, askOne, sea::boat(_), N::A);
                .print(N, " ", A); .send(bob, askAll, sea::boat(_), L); .print(L);
                .send(bob, askOne, sea::colour(_), sea::C); .print(C);
                .send(bob, untell, sea::blue); .send(bob, signal, sea::ping).""",
            "bob": """{ begin namespace(sea) } boat(1). +?colour(X) <- X = grey.
                +!swim(N) <- .print("swims ", N). +blue <- .print(blue). -blue <- .print(grey).
                +deep(X)[source(S)] <- .print(X, " from ", S). +ping <- .print(ping). { end }""",
        }
    )
    society.advance(1.0)
    assert log == [
        *(("bob", "blue"), ("bob", "3 from ann"), ("bob", "swims 1")),
        *(("ann", "sea boat(1)[source(bob)]"), ("ann", "[sea::boat(1)[source(bob)]]")),
        *(("ann", "colour(grey)[source(bob)]"), ("bob", "grey"), ("bob", "ping")),
    ]


def test_unachieve_ends_a_goal():
    society, _, log = make(
        {
            "ann": "!go. +!go <- .send(bob,achieve,w(1)); .wait(5); .send(bob,unachieve,w(_)).",
            "bob": "+!w(N) <- .print(begins); .wait(100); .print(ends).",
        }
    )
    society.advance(1.0)
    assert log == [("bob", "begins")]


def test_a_question_may_time_out():
    _, agents, log = make(
        {"ann": "!go. +!go <- .send(bob,askOne,x(_),A,50); .print(A).", "bob": "a."}
    )
    agents["ann"].advance(0.0)
    agents["ann"].advance(0.04)
    assert log == []
    agents["ann"].advance(0.05)
    assert log == [("ann", "timeout")]


def test_agents_may_be_added_and_removed_while_the_others_run():
    society, log = bdi.Society(), []
    actions = bdi.InternalActions()

    def say(name):
        return lambda line: log.append((society.now, f"{name}: {line}"))

    @actions.add("floor.hire", least=1, most=1)
    def hire(call, name):
        program = bdi.parse("""!go. +!go <- .my_name(N); .send(ann, tell, here(N)); .wait(1000).
            +!stop <- .print(never). +bye <- .print(bye).""")
        bdi.Agent(program, name=str(name), society=society, print=say(name))
        return True

    @actions.add("floor.dismiss", least=1, most=1)
    def dismiss(call, name):
        society.leave(str(name))
        return True

    program = bdi.parse("""!go. +!go <- .wait(2000); floor.hire(bob); floor.hire(cyd); .wait(500);
            .broadcast(tell, bye); floor.dismiss(bob); .all_names(L); .print(L).
        +here(N) <- .print(N).""")
    bdi.Agent(program, name="ann", society=society, actions=actions, print=say("ann"))
    society.advance(2.0)
    assert log == [(2.0, "ann: bob"), (2.0, "ann: cyd")]
    assert [(agent.name, agent.now) for agent in society] == [
        *(("ann", 2.0), ("bob", 2.0), ("cyd", 2.0)),
    ]
    society.advance(9.0)
    assert log[2:] == [(2.5, "ann: [ann,cyd]"), (2.5, "cyd: bye")]


def test_agents_of_a_society_draw_different_random_numbers():
    def drawn(names, seed=0):
        society, log = bdi.Society(), []
        for name in names:
            program = bdi.parse("!go. +!go <- .random(X); Y = math.random; .print(X, Y).")
            bdi.Agent(
                program,
                name=name,
                society=society,
                print=log.append,
                settings=bdi.AgentSettings(seed=seed),
            )
        society.advance(0.0)
        return log

    three = drawn(["ann", "bob", "cyd"])
    assert len(set(three)) == 3
    assert three == drawn(["ann", "bob", "cyd"]) != drawn(["ann", "bob", "cyd"], seed=1)
    # Alone, and as the first of a society, an agent draws according to its seed.
    assert drawn(["ann"]) == drawn(["bob"]) == three[:1]


def test_a_message_wakes_an_agent():
    society, agents, _ = make({"ann": "a.", "bob": "+hi <- .print(hi)."})
    society.advance(1.0)
    assert agents["bob"].next_wakeup is None
    society.deliver("bob", bdi.Message(sender="ann", force="tell", content=bdi.parse_literal("hi")))
    assert agents["bob"].next_wakeup == 1.0


@pytest.mark.parametrize(
    ("message", "failure"),
    [
        ("send(dan, tell, x)", "receiver_not_found: there is no agent 'dan'"),
        ("send(f(bob), tell, x)", "internal_action: The TO parameter ('f(bob)') ... not an atom"),
        ("send(bob, tell, x, now)", "internal_action: The Message ID ('now') ... a message"),
        (
            "send(bob, askOne, at(X), at(7))",
            "ask_failed: reply of an ask message ('at(3)[source(bob)]') does not unify",
        ),
    ],
)
def test_invalid_messages_fail(message, failure):
    society, _, log = make(
        {
            "ann": f"""!go. +!go <- .{message}; .print(no).
                -!go[error(E), error_msg(M)] <- .concat(E, ": ", M, T); .print(T).""",
            "bob": "at(3).",
        }
    )
    society.advance(1.0)
    ((name, line),) = log
    begin, _, end = failure.partition(" ... ")
    assert name == "ann"
    assert line.startswith(begin)
    assert end in line


def test_messages_to_several_agents_to_itself_and_with_unknown_goals():
    society, _, log = make(
        {
            "ann": """!go. +!go <- .all_names(L); .print(L);
                .send([bob, cyd, ann], achieve, sing(1)); .wait(10);
                .send(bob, achieve, 3); .send(bob, tell, "text"); .wait(10);
                .send(bob, askOne, at(_)); .wait(10); .print(on).
                +!sing(N)[source(S)] <- .print(S).""",
            "bob": "at(1). +!sing(N)[source(S)] <- .print(S).",
            "cyd": "+!sing(N)[source(S)] <- .print(S).",
        }
    )
    society.advance(1.0)
    error = "Communication error -- "
    received = '+!kqml_received(ann,tell,"text",mid3)'
    nothing = f"Found a goal for which there is no applicable plan: {received}"
    assert log == [
        ("ann", "[ann,bob,cyd]"),
        ("ann", "self"),
        ("bob", "ann"),
        ("cyd", "ann"),
        ("bob", f"{error}body_var_not_literal: Variable 'NS::Goal' must be a Literal and not '3'"),
        ("bob", f"{error}no_applicable: {nothing}"),
        ("ann", "on"),
    ]


def test_a_late_answer_is_ignored():
    society, _, log = make(
        {
            "ann": """!go. +!go <- !ask |&| !drop. +!ask <- .send(bob, askOne, at(_), A); .print(A).
                +!drop <- .drop_intention(ask); .print(dropped).""",
            "bob": "at(3).",
        }
    )
    society.advance(1.0)
    assert log == [("ann", "dropped")]


def test_a_message_to_an_unknown_agent_fails():
    lines = printed("""!go. +!go <- .broadcast(tell, x); .all_names(L); .print(L);
            .send(bob, tell, x).
        -!go[error_msg(M)] <- .print(M).""")
    assert lines == ["[human]", "there is no agent 'bob'"]


def test_two_agents_of_a_society_cannot_have_the_same_name():
    society, _, _ = make({"ann": "a."})
    with pytest.raises(ValueError, match="two agents have the name 'ann'"):
        bdi.Agent(bdi.parse("b."), name="ann", society=society)
    society.leave("ann")
    society.leave("nobody")
    assert [agent.name for agent in society] == []


@pytest.mark.parametrize("time", [math.nan, math.inf])
def test_invalid_times_are_rejected(time):
    society = bdi.Society()
    agent = bdi.Agent(bdi.parse("p."), society=society)
    with pytest.raises(ValueError, match="expected a time in seconds"):
        society.advance(time)
    assert agent.now == 0.0
