"""Goals whose events still wait in the queue, and steps and plans that fail."""

import pytest
from goals import printed

import bdi

OUTER = """
!outer. !go.
+!outer <- .wait(10); !work; .print(on).
-!outer <- .print(failed).
+!work <- .print(works).
+bell(_).
"""


def heard(program, act=lambda action: True, until=(0.0, 0.01, 0.02, 0.03), bells=range(9)):
    """Return the printed lines. Bells at 10 ms fill the queue of events."""
    lines = []
    agent = bdi.Agent(bdi.parse(program), act=act, print=lines.append)
    for t in until:
        if t == 0.01:
            for k in bells:
                agent.add_percept(f"bell({k})")
        agent.advance(t)
    return lines


@pytest.mark.parametrize(
    ("how", "lines"),
    [
        (".succeed_goal(work)", ["on", "later"]),
        (".drop_event(work)", ["later"]),
        (".drop_desire(work)", ["later"]),
        (".drop_desire(outer)", ["later"]),
        (".drop_intention(outer)", ["later"]),
        (".drop_all_events", ["later"]),
        (".drop_all_desires", ["later"]),
        (".drop_all_intentions", ["later"]),
        (".suspend(work)", ["later", "works", "on"]),
        (".suspend(outer)", ["later", "works", "on"]),
        (".suspend(outer); .resume(outer)", ["works", "on", "later"]),
        (".suspend(work); .succeed_goal(work)", ["on", "later"]),
        (".suspend(work); .drop_desire(work)", ["later"]),
        (".suspend(work); .drop_intention(outer)", ["later"]),
        (".suspend(work); .drop_all_intentions", ["later"]),
        ("if (.desire(work)) {.print(desired)}", ["desired", "works", "on", "later"]),
    ],
)
def test_a_queued_goal_can_be_ended(how, lines):
    program = f"{OUTER} +!go <- .wait(10); {how}; .wait(5); .print(later); .resume(work)."
    assert heard(program) == lines


@pytest.mark.parametrize(
    ("how", "lines"),
    [
        (".succeed_goal(work)", ["on", "end"]),
        (".fail_goal(work)", ["failed", "end"]),
        (".drop_intention(work)", ["end"]),
        (".drop_all_intentions", ["end"]),
        (".suspend(work)", ["end"]),
    ],
)
def test_a_goal_that_waits_for_an_action_can_be_ended(how, lines):
    """The environment never reports the result of the action."""
    program = (
        "!outer. !go."
        f" +!go <- .wait(10); {how}; .wait(5); .print(end)."
        " +!outer <- !work; .print(on). -!outer <- .print(failed). +!work <- press; .print(no)."
    )
    assert heard(program, act=lambda action: bdi.PENDING, bells=()) == lines


@pytest.mark.parametrize(
    ("step", "lines"),
    [
        ("V = here(1); +V; ?here(X); .print(X)", ["1"]),
        ("V = here(1); ++V; .wait(1); ?here(X); .print(X)", ["1"]),
        ("V = here(2); -+V; ?here(X); .print(X)", ["2"]),
        ("V = here(1); +V; -V; .count(here(_), N); .print(N)", ["0"]),
        ("V = helper(5); !V; .print(done)", ["5", "done"]),
        ("V = helper(5); !!V; .wait(1); .print(done)", ["5", "done"]),
        ("V = jump(1); V; .print(done)", ["done"]),
        ("V = {.print(a); .print(b)}; V; .print(c)", ["a", "b", "c"]),
        ("V = 7; !V", ["body_var_not_literal"]),
        ("V = 7; !!V", ["body_var_not_literal"]),
        ("V = 7; +V", ["body_var_not_literal"]),
        ("V = 7; ++V", ["body_var_not_literal"]),
        ("V = 7; -V", ["body_var_not_literal"]),
        ("V = 7; -+V", ["body_var_not_literal"]),
        ("V = 7; V", ["body_var_not_literal"]),
        ("!V", ["body_var_without_value"]),
        ("+V", ["body_var_without_value"]),
        ("?nothing(X)", ["test_goal_failed"]),
        ("?asked(X); .print(X)", ["9"]),
        ("1 > 2", ["constraint_failed"]),
        ('.fail(why(tired), error_msg("so it is"))', ["internal_action"]),
        ("!nobody_can", ["no_relevant"]),
        ("!not_now", ["no_applicable"]),
        ("!fails_twice", ["ia_failed"]),
        ("for (.member(X, [])) {.print(X)}; .print(none)", ["none"]),
        ("for (.range(X, 1, 2)) {.print(X)}", ["1", "2"]),
        (".print(a) |&| .print(b); .print(c)", ["a", "b", "c"]),
    ],
)
def test_the_step_prints_the_expected_lines(step, lines):
    done = []
    output = printed(
        f"!go. +!go <- {step}. -!go[error(E)] <- .print(E)."
        " +!helper(N) <- .print(N). +?asked(X) <- X = 9. +!not_now : false."
        " +!fails_twice <- .fail. -!fails_twice <- .fail.",
        act=lambda action: not done.append(str(action)),
    )
    assert output == lines
    assert done == (["jump(1)"] if "jump" in step else [])
