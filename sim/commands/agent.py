"""`floorwalker agent`: one agent alone, against a script of percepts."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from . import completion

if TYPE_CHECKING:
    from collections.abc import Iterator

    import bdi


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
    seed: Annotated[int, typer.Option(help="Of the random numbers.")] = 0,
    trace: Annotated[
        bool, typer.Option("--trace", help="Tell on stderr what happens inside.")
    ] = False,
) -> None:
    """Run an AgentSpeak program alone and print its actions and what it says."""
    import json
    import sys

    import bdi

    def show(**entry: object) -> None:
        print(json.dumps({"t": round(person.now, 9), **entry}, ensure_ascii=False))

    def act(action: bdi.Literal) -> bool:
        show(action=str(action))
        return True

    def follow(entry: bdi.Entry) -> None:
        print(entry, file=sys.stderr)

    script = [] if percepts is None else _read_script(percepts)
    beliefs = [_literal(text, "--belief") for text in belief or []]
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
        for add, percept in changes:
            (person.add_percept if add else person.remove_percept)(percept)
        person.advance(time)
    if until is not None:
        person.advance(until)
        return
    _run_out(person)


#: Without --until a program that wakes up again and again is stopped after this many wake-ups.
_MOST_WAKEUPS = 1_000_000


def _run_out(person: bdi.Agent) -> None:
    for _ in range(_MOST_WAKEUPS):
        wakeup = person.next_wakeup
        if wakeup is None:
            return
        person.advance(wakeup)
    raise ValueError(
        f"the program was still waking up at {person.now:g} s: say with --until when to stop"
    )


def _read_script(path: Path) -> list[tuple[float, bool, bdi.Literal]]:
    """The lines of a script of percepts: time, whether added, and what."""
    import json
    import math

    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except OSError as error:
        raise ValueError(f"{path}: cannot be read: {error.strerror}") from None
    except UnicodeDecodeError:
        raise ValueError(f"{path}: it is not UTF-8 text") from None
    script: list[tuple[float, bool, bdi.Literal]] = []
    for number, line in enumerate(lines, 1):
        if not line.strip():
            continue
        place = f"{path}:{number}"
        try:
            entry = json.loads(line)
        except (json.JSONDecodeError, RecursionError):
            raise ValueError(f"{place}: not a line of JSON: {line[:60]}") from None
        changes = [key for key in ("add", "remove") if isinstance(entry, dict) and key in entry]
        if len(changes) != 1 or set(entry) != {"t", changes[0]}:
            raise ValueError(f'{place}: a line has "t" and either "add" or "remove"')
        time, what = entry["t"], entry[changes[0]]
        if isinstance(time, bool) or not isinstance(time, int | float) or not math.isfinite(time):
            raise ValueError(f'{place}: "t" is a number of seconds, not {json.dumps(time)}')
        if time < 0:
            raise ValueError(f'{place}: "t" is {time:g}, and the run begins at 0')
        if script and time < script[-1][0]:
            raise ValueError(f"{place}: {time:g} s comes after {script[-1][0]:g} s")
        if not isinstance(what, str):
            raise ValueError(f'{place}: "{changes[0]}" is a literal in quotes')
        script.append((float(time), changes[0] == "add", _literal(what, place)))
    return script


def _literal(text: str, place: str) -> bdi.Literal:
    import bdi

    try:
        return bdi.parse_literal(text)
    except bdi.ProgramError as error:
        raise ValueError(f"{place}: {text}: {error.problems[0].message}") from None


def _instants(
    script: list[tuple[float, bool, bdi.Literal]],
) -> Iterator[tuple[float, list[tuple[bool, bdi.Literal]]]]:
    """What changes at each time of a script, in order."""
    from itertools import groupby

    for time, lines in groupby(script, key=lambda line: line[0]):
        yield time, [(add, percept) for _, add, percept in lines]
