"""Endless chains of failures: reported with their line, within a short time."""

import pytest

import bdi

CHAINS = {
    "a recovery without a plan": "!a. +!a <- .fail. -!a <- !b.",
    "a retry": "!a. +!a <- .fail.\n-!a <- !a.",
    "a retry that goes on": "!a. +!a <- .fail. -!a <- !a; .print(x).",
    "two in turn": "!a. +!a <- .fail. -!a <- !b. +!b <- .fail. -!b <- !a.",
    "new intentions": "!a. +!a <- .fail. -!a <- !!a.",
    "a failing test": "!a. +!a <- ?nothing. -!a <- ?other.",
    "a failing failure plan": "!a. +!a <- .fail. -!a <- .fail.",
    "other arguments": "!a(0). +!a(N) <- .fail. -!a(N) <- !a(N+1).",
}


@pytest.mark.parametrize("chain", CHAINS)
def test_an_endless_chain_of_failures_is_reported_with_its_line(chain):
    """Use the default number of cycles, which would take minutes if all were used."""
    agent = bdi.Agent(bdi.parse(CHAINS[chain]), print=lambda text: None)
    with pytest.raises(bdi.EndlessProgramError, match=r"<text>:\d:.* does not end"):
        agent.advance(0.0)


def test_thousands_of_goals_may_fail_at_one_time():
    printed = []
    text = """
        !all.
        +!all <- for (.range(N, 1, 5000)) { !try(N) }; .print(done).
        +!try(N) <- .fail.
        -!try(N).
    """
    bdi.Agent(bdi.parse(text), print=printed.append).advance(0.0)
    assert printed == ["done"]


def test_failures_at_different_times_are_no_chain():
    agent = bdi.Agent(bdi.parse("!a. +!a <- .wait(1000); .fail. -!a <- !a."))
    for second in range(1, 3000):
        agent.advance(float(second))
