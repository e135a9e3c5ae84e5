"""Messages between agents."""

import pytest

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


def test_taking_back_a_goal():
    society, _, log = make(
        {
            "ann": "!go. +!go <- .send(bob,achieve,w(1)); .wait(5); .send(bob,unachieve,w(_)).",
            "bob": "+!w(N) <- .print(begins); .wait(100); .print(ends).",
        }
    )
    society.advance(1.0)
    assert log == [("bob", "begins")]


def test_a_question_may_find_no_answer_in_time():
    _, agents, log = make(
        {"ann": "!go. +!go <- .send(bob,askOne,x(_),A,50); .print(A).", "bob": "a."}
    )
    agents["ann"].advance(0.0)
    agents["ann"].advance(0.04)
    assert log == []
    agents["ann"].advance(0.05)
    assert log == [("ann", "timeout")]


def test_sending_to_nobody():
    _, agents, log = make(
        {"ann": "!go. +!go <- .send(zoe,tell,x). -!go[error_msg(M)] <- .print(M)."}
    )
    agents["ann"].advance(0.0)
    assert log == [("ann", "there is no agent 'zoe'")]
    alone = bdi.Agent(
        bdi.parse("!go. +!go <- .send(zoe,tell,x). -!go[error_msg(M)] <- .print(M)."),
        print=lambda line: log.append(line),
    )
    alone.advance(0.0)
    assert "alone" in log[-1]


def test_names_are_taken_once():
    society = bdi.Society()
    bdi.Agent(bdi.parse("a."), name="x", society=society)
    with pytest.raises(ValueError, match="'x'"):
        bdi.Agent(bdi.parse("a."), name="x", society=society)


def test_mail_wakes_up():
    society, agents, _ = make({"ann": "a.", "bob": "+hi <- .print(hi)."})
    society.advance(1.0)
    assert agents["bob"].next_wakeup is None
    society.deliver("bob", bdi.Message("ann", "tell", bdi.parse_literal("hi")))
    assert agents["bob"].next_wakeup == 1.0
