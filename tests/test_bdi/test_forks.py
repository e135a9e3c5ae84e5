"""Parallel branches: how they join, fail and end."""

import pytest
from goals import printed

TWO = "+!c <- !a |&| !b; .print(joined).\n"
ONE = "+!c <- !a ||| !b; .print(joined).\n"


def said(plans):
    """Return the lines printed within a second by `!c` and the steps after it."""
    return printed(f"!go.\n+!go <- !c; .print(after).\n{plans}")


@pytest.mark.parametrize(
    ("plans", "lines"),
    [
        (TWO + "+!a <- .wait(20); .print(a). +!b <- .wait(10); .print(b).", "b a joined after"),
        (ONE + "+!a <- .wait(20); .print(a). +!b <- .wait(10); .print(b).", "b joined after"),
        (
            "+!c <- !a |&| !b |&| !d; .print(joined). +!a <- .wait(30); .print(a)."
            " +!b <- .print(b). +!d <- .wait(10); .print(d).",
            "b d a joined after",
        ),
    ],
)
def test_branches_of_a_fork_join(plans, lines):
    assert said(plans) == lines.split()


@pytest.mark.parametrize(
    ("plans", "lines"),
    [
        # All branches are needed. The first failure ends the others and the goal.
        (TWO + "+!a <- .wait(10); .fail. +!b <- .wait(20); .print(b).", ""),
        (TWO + "+!a <- .wait(10); !nobody. +!b <- .wait(20); .print(b).", ""),
        (
            TWO + "+!a <- .wait(10); .fail. +!b <- .wait(20); .print(b). -!c <- .print(failed).",
            "failed after",
        ),
        # A failure handled inside a branch does not concern the other branches.
        (
            TWO + "+!a <- .wait(10); .fail. -!a <- .print(mended). +!b <- .wait(20); .print(b).",
            "mended b joined after",
        ),
        # One branch is enough. A branch that fails just ends.
        (ONE + "+!a <- .wait(10); .fail. +!b <- .wait(20); .print(b).", "b joined after"),
        (
            ONE + "+!a <- .wait(10); .fail. +!b <- .wait(20); .fail. -!c <- .print(failed).",
            "",
        ),
    ],
)
def test_failures_in_branches_end_the_fork(plans, lines):
    assert said(plans) == lines.split()


@pytest.mark.parametrize(
    ("plans", "lines"),
    [
        (TWO + "+!a <- .wait(10); .succeed_goal(c); .print(no). +!b <- .wait(50).", "after"),
        (TWO + "+!b <- .wait(10); .succeed_goal(c); .print(no). +!a <- .wait(50).", "after"),
        (TWO + "+!a <- .wait(10); .succeed_goal(c); .print(no). +!b <- .print(b).", "b after"),
        (
            TWO + "+!a <- .wait(10); .succeed_goal(a); .print(no). +!b <- .wait(50); .print(b).",
            "b joined after",
        ),
        (
            TWO + "+!a <- .wait(10); .fail_goal(c); .print(no). +!b <- .wait(50); .print(no)."
            " -!c <- .print(failed).",
            "failed after",
        ),
        (
            TWO + "+!a <- .wait(50); .print(no). +!b <- .wait(50); .print(no)."
            " !other. +!other <- .wait(10); .succeed_goal(c); .print(taken).",
            "after taken",
        ),
        (
            TWO + "+!a <- .wait(50); .print(no). +!b <- .wait(50); .print(no)."
            " !other. +!other <- .wait(10); .drop_intention(c); .print(dropped).",
            "dropped",
        ),
    ],
)
def test_a_goal_in_branches_is_ended_from_one_of_them_or_from_elsewhere(plans, lines):
    assert said(plans) == lines.split()


@pytest.mark.parametrize(
    "plans",
    [
        "+!c <- .succeed_goal(c); .print(no).",
        "+!c <- !d; .print(no). +!d <- .succeed_goal(c); .print(no).",
        "+!c <- !d; .print(no). +!d <- .wait(10); .succeed_goal(c); .print(no).",
        "@atomic[atomic] +!c <- .succeed_goal(c); .print(no).",
    ],
)
def test_an_intention_continues_after_its_own_goal_is_declared_achieved(plans):
    assert said(plans) == ["after"]


IN_ONE = "+!d <- .wait(30); .print(d)."
NOT_IN_ONE = "+!d <- .wait(30); .print(no)."


@pytest.mark.parametrize(
    ("plans", "lines"),
    [
        # The outer fork waits for the steps after the inner one, and for its own other branch.
        (
            "+!c <- !a |&| !d; .print(joined). +!a <- (!e |&| !f); .print(a)."
            f" +!e <- .wait(10); .print(e). +!f <- .print(f). {IN_ONE}",
            "f e a d joined after",
        ),
        (
            "+!c <- !a ||| !d; .print(joined). +!a <- (!e ||| !f); .print(a)."
            f" +!e <- .wait(10); .print(e). +!f <- .wait(20); .print(f). {IN_ONE}",
            "e a joined after",
        ),
        (
            "+!c <- !a |&| !d; .print(joined). +!a <- (!e ||| !f); .print(a)."
            f" +!e <- .wait(10); .print(e). +!f <- .wait(20); .print(f). {IN_ONE}",
            "e a d joined after",
        ),
        # The first branch to end also ends all goals that the others have started.
        (
            "+!c <- !a ||| !d; .print(joined). +!a <- (!e |&| !f); .print(no)."
            f" +!e <- .wait(40); .print(no). +!f <- .wait(50); .print(no). {IN_ONE}",
            "d joined after",
        ),
        ("+!c <- (.print(a); .wait(5) ||| .wait(9)) |&| .print(b); .print(joined).", None),
        # A failure in the inner fork ends both.
        (
            "+!c <- !a |&| !d; .print(no). +!a <- (!e |&| !f); .print(no). +!e <- .wait(10); .fail."
            f" +!f <- .wait(20); .print(no). {NOT_IN_ONE} -!c <- .print(failed).",
            "failed after",
        ),
        (
            "+!c <- !a |&| !d; .print(joined). +!a <- (!e |&| !f); .print(no)."
            " +!e <- .wait(10); .fail. +!f <- .wait(20); .print(no). -!a <- .print(mended)."
            f" {IN_ONE}",
            "mended d joined after",
        ),
        (
            "+!c <- !a |&| !d; .print(no). +!a <- (!e |&| !f); .print(no). +!e <- .wait(10); .fail."
            f" +!f <- .wait(20); .print(no). {NOT_IN_ONE}",
            "",
        ),
        (
            "+!c <- !a ||| !d; .print(joined). +!a <- (!e |&| !f); .print(no)."
            f" +!e <- .wait(10); .fail. +!f <- .wait(20); .print(no). {IN_ONE}",
            "d joined after",
        ),
        # A failure is handled by the nearest goal above it with a plan for failures.
        (
            "+!c <- !a |&| !d; .print(joined). +!a <- !e. +!e <- !f. +!f <- .wait(10); .fail."
            f" -!a <- .print(mended). {IN_ONE}",
            "mended d joined after",
        ),
        (
            "+!c <- !a ||| !d; .print(joined). +!a <- !e. +!e <- !f. +!f <- .wait(10); .fail."
            f" -!a <- .print(mended). {NOT_IN_ONE}",
            "mended joined after",
        ),
        # A fork that has joined does not concern later failures.
        ("+!c <- !a ||| !b; .fail. +!a. +!b. -!c <- .print(failed).", "failed after"),
        ("+!c <- !a |&| !b; .fail. +!a. +!b. -!c <- .print(failed).", "failed after"),
        (
            "+!c <- !a |&| !d; .print(no). +!a <- (!e |&| !f); .print(no)."
            " +!e <- .wait(10); .succeed_goal(c); .print(no). +!f <- .wait(20); .print(no)."
            f" {NOT_IN_ONE}",
            "after",
        ),
    ],
)
def test_forks_may_be_nested(plans, lines):
    if lines is None:
        assert said(plans)[-2:] == ["joined", "after"]
    else:
        assert said(plans) == lines.split()


def test_endless_inner_forks_end_with_the_first_branch():
    plans = "+!c <- !dig(0); .print(joined). +!dig(N) : N < 5 <- .wait(100) ||| !dig(N + 1)."
    assert said(plans + " +!dig(N) <- .print(N).") == ["5", "joined", "after"]
