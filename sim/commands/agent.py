"""`floorwalker agent`: one agent alone, against a script of percepts."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from . import completion
from .terminal import say

if TYPE_CHECKING:
    from collections.abc import Iterator

    import bdi

    from .percept_script import Change


def agent(
    program: Annotated[
        str,
        typer.Argument(
            metavar="FILE.asl",
            help="The program, or a built-in personality.",
            autocompletion=completion.program,
        ),
    ],
    belief: Annotated[
        list[str] | None, typer.Option(help="A further initial belief, as station(a,0,0).")
    ] = None,
    percepts: Annotated[
        Path | None,
        typer.Option(
            help='A script, one {"t": seconds, "add": "literal"} or '
            '{"t": seconds, "remove": "literal"} a line.'
        ),
    ] = None,
    until: Annotated[
        float | None, typer.Option(help="Stop at this time, in seconds.", min=0.0)
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="Of the random numbers.")] = 0,
    trace: Annotated[
        bool, typer.Option("--trace", help="Print on stderr what happens inside.")
    ] = False,
) -> None:
    """Run an AgentSpeak program alone; print its actions and words."""
    import json

    import bdi

    from .percept_script import literal, read_percepts

    def show(**entry: object) -> None:
        say(json.dumps({"t": round(person.now, 9), **entry}, ensure_ascii=False))

    def act(action: bdi.Literal) -> bool:
        show(action=str(action))
        return True

    def follow(entry: bdi.Entry) -> None:
        say(str(entry), err=True)

    script = [] if percepts is None else read_percepts(percepts)
    beliefs = [literal(text, "--belief") for text in belief or []]
    person = bdi.Agent(
        bdi.load(program),
        beliefs=beliefs,
        act=act,
        print=lambda line: show(print=line),
        name="human",
        society=bdi.Society(),
        seed=seed,
        on_event=follow if trace else None,
    )
    for time, changes in _instants(script):
        if until is not None and time > until:
            break
        for change in changes:
            perceive = person.add_percept if change.added else person.remove_percept
            perceive(change.percept)
        person.advance(time)
    if until is not None:
        person.advance(until)
        return
    _run_out(person)


#: Without --until a program that wakes up again and again is stopped after this many wake-ups.
_MOST_WAKEUPS = 1_000_000


def _run_out(person: bdi.Agent) -> None:
    from floorplan import UserError

    for _ in range(_MOST_WAKEUPS):
        wakeup = person.next_wakeup
        if wakeup is None:
            return
        person.advance(wakeup)
    raise UserError(
        f"the program was still waking up at {person.now:g} s: say with --until when to stop"
    )


def _instants(script: list[Change]) -> Iterator[tuple[float, list[Change]]]:
    """Return the changes at each time of a script, in order."""
    from itertools import groupby

    for time, changes in groupby(script, key=lambda change: change.time):
        yield time, list(changes)
