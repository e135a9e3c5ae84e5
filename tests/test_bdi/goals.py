"""Runs of goals for tests."""

import bdi


def printed(program, until=1.0, **options):
    """Return the lines that a program prints up to a time (s)."""
    lines = []
    agent = bdi.Agent(bdi.parse(program), print=lines.append, **options)
    for time in until if isinstance(until, tuple) else (until,):
        agent.advance(time)
    return lines


def said(body, rest=""):
    """Return the lines that a goal with this body prints, and a line for its failure."""
    return printed(
        f"""!go.
        +!go <- {body}.
        -!go[error(E), error_msg(M)] <- .print(E, ": ", M).
        {rest}""",
        until=1000.0,
    )
