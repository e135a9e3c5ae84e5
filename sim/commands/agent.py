"""`floorwalker agent`: one agent alone, with a script of timed percepts."""

from __future__ import annotations

import json
from collections.abc import Iterator
from itertools import groupby
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NamedTuple

import typer

from .arguments import complete_program
from .terminal import say

if TYPE_CHECKING:
    import bdi


def agent(
    program: Annotated[
        str,
        typer.Argument(
            metavar="FILE.asl",
            help="Program file or built-in personality.",
            autocompletion=complete_program,
        ),
    ],
    belief: Annotated[
        list[str] | None,
        typer.Option(help="Further initial belief, such as station(a,0,0); repeat for more."),
    ] = None,
    percepts: Annotated[
        Path | None,
        typer.Option(
            help='Script with one {"t": seconds, "add": "literal"} or '
            '{"t": seconds, "remove": "literal"} per line.'
        ),
    ] = None,
    until: Annotated[float | None, typer.Option(help="End in seconds.", min=0.0)] = None,
    seed: Annotated[int, typer.Option(min=0, help="Random seed.")] = 0,
    trace: Annotated[
        bool, typer.Option("--trace", help="Print internal events on stderr.")
    ] = False,
) -> None:
    """Run an AgentSpeak program alone, and print its actions and messages."""
    import bdi

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
        settings=bdi.AgentSettings(seed=seed, on_event=follow if trace else None),
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


_MOST_WAKEUPS = 1_000_000
"""Number of wake-ups after which an endless program is stopped without --until."""


def _run_out(person: bdi.Agent) -> None:
    from floorplan import UserError

    for _ in range(_MOST_WAKEUPS):
        wakeup = person.next_wakeup
        if wakeup is None:
            return
        person.advance(wakeup)
    raise UserError(f"the program is still active at {person.now:g} s; set an end with --until")


def _instants(script: list[Change]) -> Iterator[tuple[float, list[Change]]]:
    """Return the changes at each time of a script, in order."""
    for time, changes in groupby(script, key=lambda change: change.time):
        yield time, list(changes)


class Change(NamedTuple):
    """Change of a percept at `time` (s): `added` or removed."""

    time: float
    added: bool
    percept: bdi.Literal


def read_percepts(path: Path) -> list[Change]:
    """Read a script with a line `{"t": …, "add": …}` or `{"t": …, "remove": …}` per change.

    `ValueError` names the invalid line.
    """
    from floorplan import InputError
    from floorplan.files.reading import read_lines

    script: list[Change] = []
    for number, line in enumerate(read_lines(path, InputError), 1):
        if line.strip():
            earliest = script[-1].time if script else 0.0
            script.append(_change(line, f"{path}:{number}", earliest))
    return script


def _change(line: str, place: str, earliest: float) -> Change:
    from floorplan import UserError
    from floorplan.files.fields import is_figure

    try:
        entry = json.loads(line)
    except (ValueError, RecursionError):
        raise UserError(f"{place}: not a line of JSON: {line[:60]}") from None
    changes = [key for key in ("add", "remove") if isinstance(entry, dict) and key in entry]
    if len(changes) != 1 or set(entry) != {"t", changes[0]}:
        raise UserError(f'{place}: a line must contain "t" and either "add" or "remove"')
    time, what = entry["t"], entry[changes[0]]
    if not is_figure(time):
        raise UserError(f'{place}: "t" must be a number of seconds, not {json.dumps(time)[:60]}')
    if time < 0:
        raise UserError(f'{place}: "t" must be 0 or more, not {time:g}')
    if time < earliest:
        raise UserError(f"{place}: times must increase, but {time:g} s comes after {earliest:g} s")
    if not isinstance(what, str):
        raise UserError(f'{place}: "{changes[0]}" must be a literal in quotes')
    return Change(float(time), changes[0] == "add", literal(what, place))


def literal(text: str, place: str) -> bdi.Literal:
    """Return the literal in `text` at `place`. `ValueError` if it is invalid."""
    import bdi
    from floorplan import UserError

    try:
        return bdi.parse_literal(text)
    except bdi.ProgramError as error:
        raise UserError(f"{place}: {text[:100]}: {error.problems[0].message[:300]}") from None
