"""What goals do, as tests see it."""

import bdi


def said(body, rest="", limit=50):
    """What a goal with this body prints, and how it fails, if it does."""
    lines = []
    program = bdi.parse(f"""!go.
        +!go <- {body}.
        -!go[error(E), error_msg(M)] <- .print(E, ": ", M).
        {rest}""")
    agent = bdi.Agent(program, act=lambda action: True, print=lines.append)
    agent.advance(0.0)
    for _ in range(limit):
        if agent.next_wakeup is None:
            break
        agent.advance(agent.next_wakeup)
    return lines
