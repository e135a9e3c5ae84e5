"""A script of percepts for an agent that runs alone, each with its time."""

from __future__ import annotations

import json
from pathlib import Path
from typing import NamedTuple

import bdi
from floorplan import InputError, UserError
from floorplan.files.fields import is_figure
from floorplan.files.reading import read_lines


class Change(NamedTuple):
    """From `time` (seconds) on, `percept` is perceived (`added`) or no longer."""

    time: float
    added: bool
    percept: bdi.Literal


def read_percepts(path: Path) -> list[Change]:
    """Read the script at `path`, one `{"t": …, "add": …}` or `{"t": …, "remove": …}` a line.

    `ValueError` names the line that is none.
    """
    script: list[Change] = []
    for number, line in enumerate(read_lines(path, InputError), 1):
        if line.strip():
            earliest = script[-1].time if script else 0.0
            script.append(_change(line, f"{path}:{number}", earliest))
    return script


def _change(line: str, place: str, earliest: float) -> Change:
    try:
        entry = json.loads(line)
    except (ValueError, RecursionError):
        raise UserError(f"{place}: not a line of JSON: {line[:60]}") from None
    changes = [key for key in ("add", "remove") if isinstance(entry, dict) and key in entry]
    if len(changes) != 1 or set(entry) != {"t", changes[0]}:
        raise UserError(f'{place}: a line has "t" and either "add" or "remove"')
    time, what = entry["t"], entry[changes[0]]
    if not is_figure(time):
        raise UserError(f'{place}: "t" is a number of seconds, not {json.dumps(time)[:60]}')
    if time < 0:
        raise UserError(f'{place}: "t" is {time:g}, and the run begins at 0')
    if time < earliest:
        raise UserError(f"{place}: {time:g} s comes after {earliest:g} s")
    if not isinstance(what, str):
        raise UserError(f'{place}: "{changes[0]}" is a literal in quotes')
    return Change(float(time), changes[0] == "add", literal(what, place))


def literal(text: str, place: str) -> bdi.Literal:
    """Return the literal in `text`, which stands at `place`; `ValueError` if it is none."""
    try:
        return bdi.parse_literal(text)
    except bdi.ProgramError as error:
        raise UserError(f"{place}: {text[:100]}: {error.problems[0].message[:300]}") from None
