"""Warnings of valid programs that probably differ from the intention of the author."""

import pytest

import bdi

ACTIONS = {"move": (2, 3), "stop": (0, 0)}


def doubts_of(text):
    warnings = bdi.doubts(bdi.parse(text), actions=ACTIONS, events=["human_start", "met"])
    return [(one.line, one.message) for one in warnings]


@pytest.mark.parametrize(
    ("text", "line", "message"),
    [
        ("!go. +!goto <- stop.", 1, "there is no plan for the goal !go/0; did you mean goto/0?"),
        ("+met\n <- !go(1). +!go <- stop.", 2, "there is no plan for the goal !go/1"),
        ("+met <- if (x) { stop } else {\n walk }.", 2, "there is no action walk"),
        ("+met <- for (x) { while (y) {\nstp } }.", 2, "no action stp; did you mean stop?"),
        ("+met <- stop |&| {\n move(1) }.", 2, "the action move takes 2 to 3 arguments, found 1"),
        ("+met <- stop(3).", 1, "the action stop takes 0 arguments, found 1"),
        ('+met <- print("hi").', 1, "there is no action print; did you mean .print?"),
        ("+met <- .wait.", 1, "has not received the required number"),
        ("+met <- !a. +!a <- !b. { +!b <- !c. }", 1, "there is no plan for the goal !c/0"),
        ("+human_strat <- stop.", 1, "nothing adds human_strat; did you mean human_start?"),
    ],
)
def test_warnings_have_the_line_of_their_cause(text, line, message):
    ((at, words),) = doubts_of(text)
    assert at == line and message in words


@pytest.mark.parametrize(
    "text",
    [
        "+met <- !a(1). -!a(X) <- stop.",
        "+met <- !a. +!G <- stop.",
        "+met <- .add_plan({ +!a <- stop }); !a.",
        "+human_strat <- stop. +met <- +human_strat.",
        "human_strat. -human_strat <- stop. +something_else <- stop.",
        "+met : .print(1) <- X = 3; move(1, X); .wait(10); G = go; !G.",
        "+met <- other::walk; !other::go.",
    ],
)
def test_plausible_programs_cause_no_warning(text):
    assert doubts_of(text) == []
