"""Rule sets in files: in the `rules` of a trial, or in a YAML file of their own."""

import math
from collections.abc import Mapping
from dataclasses import fields, replace
from pathlib import Path
from typing import Annotated, Any

from pydantic import AfterValidator, model_validator

import floorplan
from floorplan import (
    Document,
    InputError,
    NotNegative,
    Number,
    Positive,
    Problem,
    Strictly,
    UserError,
    suggestion,
)
from navigation import AnyLaw, Scaled

from ..core.rules import (
    NO_TIME,
    PAPER,
    RULE_SETS,
    MachineMeasure,
    Notice,
    PersonMeasure,
    RuleSet,
    rule_set,
)
from .law_file import Terms, WrittenLawError, read_law, written_law


class RulesError(InputError):
    """A file that holds no rule set."""


def _lasting(seconds: float) -> float:
    if seconds == 0:
        raise UserError(NO_TIME)
    return seconds


Lasting = Annotated[NotNegative, AfterValidator(_lasting)]
"""Time for which a machine is disabled, seconds."""


class NoticeKeys(Strictly):
    """Terms of noticing the gantry; what is left out is as in the rule set it is based on."""

    law: Terms | None = None
    factor: Positive | None = None
    cap: Positive | None = None
    every: Positive | None = None
    parting: Positive | None = None
    silent: NotNegative | None = None


class Disable(Strictly):
    """Measure for the machine, with its time: short for `gantry_disabled`."""

    disable: Lasting


class RuleKeys(Strictly):
    """A rule set; what is left out is as in the one it is based on.

    Or only text: the name of a built-in one, or a file (`source`).
    """

    source: str | None = None
    based_on: str = PAPER.name
    name: str | None = None
    gantry_law: Terms | None = None
    agv_law: Terms | None = None
    laws: dict[str, Terms] = {}
    agv_offset: Number | None = None
    notice: NoticeKeys = NoticeKeys()
    machine: MachineMeasure | Disable | None = None
    person: PersonMeasure | None = None
    gantry_disabled: Lasting | None = None
    grace: NotNegative | None = None
    report_every: Positive | None = None
    pause_after_violation: NotNegative | None = None
    pause_after_agv: NotNegative | None = None
    between_people: Positive | None = None
    reactions: dict[str, NotNegative] = {}

    @model_validator(mode="before")
    @classmethod
    def _named(cls, value: object) -> object:
        if isinstance(value, str):
            return {"source": value}
        if isinstance(value, Mapping) and "source" in value:
            raise UserError("unknown key 'source'; for a rule set of a file write rules: FILE")
        return value


def load_rules(path: str | Path, *, own_code: bool = True) -> RuleSet:
    """Return the rule set in the YAML file at `path`; laws of one's own stand beside it.

    They are imported when the rules are first applied; without `own_code` they are refused.
    `RulesError` has everything that is wrong with it, each with its line.
    """
    path = Path(path)
    document = floorplan.read_yaml(path, RulesError)
    keys = document.checked(RuleKeys, RulesError)
    rules, problems = build_rules(keys, document, path.parent, own_code=own_code)
    if problems:
        raise RulesError(document.file, problems)
    return rules if keys.name else replace(rules, name=path.name.split(".")[0])


def find_rules(source: str, folder: Path = Path(), *, own_code: bool = True) -> RuleSet:
    """Return the built-in rule set called `source`, or the one in a file seen from `folder`.

    `own_code` is as of `load_rules`. `RulesError` for a file that holds none, `ValueError` if
    there is neither.
    """
    path = folder / source
    if source not in RULE_SETS and floorplan.is_file(path):
        return load_rules(path, own_code=own_code)
    return rule_set(source)


def build_rules(
    keys: RuleKeys, document: Document, folder: Path, *place: str, own_code: bool = True
) -> tuple[RuleSet, list[Problem]]:
    """Return the rule set that `keys` describe, which stand at `place` in `document`.

    And what is wrong with it: then the rule set is only a stand-in.
    """
    if keys.source is not None:
        try:
            return find_rules(keys.source, folder, own_code=own_code), []
        except RulesError:
            raise
        except UserError as why:
            return PAPER, [document.problem(str(why), *place)]
    problems: list[Problem] = []
    base = RULE_SETS.get(keys.based_on)
    if base is None:
        message = f"no rule set is called {keys.based_on!r}; {suggestion(keys.based_on, RULE_SETS)}"
        problems.append(document.problem(message, *place, "based_on"))
        base = PAPER

    def law(terms: Terms | None, *key: str) -> "AnyLaw | None":
        if terms is None:
            return None
        at = f"{document.file}: {document.problem('', *place, *key)}".removesuffix(": ")
        try:
            return read_law(terms, folder, own_code=own_code, place=at)
        except WrittenLawError as why:
            problems.append(document.problem(str(why), *place, *key, *why.place))
            return None

    gantry_law = law(keys.gantry_law, "gantry_law")
    of_machines = {name: law(terms, "laws", name) for name, terms in keys.laws.items()}
    noticed_by = law(keys.notice.law, "notice", "law") or gantry_law or base.notice.law.law
    rules = replace(
        base,
        name=keys.name or f"{base.name}, changed",
        summary=f"based on {base.name}",
        gantry_law=gantry_law or base.gantry_law,
        agv_law=law(keys.agv_law, "agv_law") or base.agv_law,
        laws={**base.laws}
        | {key: found for key, found in of_machines.items() if found is not None},
        notice=_notice(keys.notice, base.notice, noticed_by),
        reactions={**base.reactions, **keys.reactions},
        **_plain(keys),
    )
    return rules, problems


def _plain(keys: RuleKeys) -> dict[str, Any]:
    """Return what the keys say as it stands; what is left out or null is as in the base."""
    given = {key: getattr(keys, key) for key in _PLAIN if key in keys.model_fields_set}
    if isinstance(keys.machine, Disable):
        given |= {"machine": "disable", "gantry_disabled": keys.machine.disable}
    may_be_none = "report_every"
    return {key: value for key, value in given.items() if value is not None or key == may_be_none}


_PLAIN = [
    name
    for name in RuleKeys.model_fields
    if name in {field.name for field in fields(RuleSet)}
    and name not in ("name", "gantry_law", "agv_law", "laws", "notice", "reactions")
]
"""Keys whose values are those of the fields of the same name."""


def _notice(keys: NoticeKeys, base: Notice, law: AnyLaw) -> Notice:
    given = keys.model_fields_set
    factor = base.law.factor if keys.factor is None else keys.factor
    cap = (keys.cap or math.inf) if "cap" in given else base.law.cap
    every = keys.every if "every" in given else base.every
    parting = keys.parting or (math.inf if keys.every else base.parting)
    if every is None and parting == math.inf:
        parting = Notice(law=base.law).parting
    silent = base.silent if keys.silent is None else keys.silent
    return Notice(law=Scaled(law, factor, cap), parting=parting, every=every, silent=silent)


def written_rules(rules: RuleSet) -> str | dict[str, Any]:
    """Return the rule set as a file has it: from what is written the same one is read again.

    `ValueError` if one of its laws can't be written.
    """
    if RULE_SETS.get(rules.name) == rules:
        return rules.name
    notice = rules.notice
    laws = {name: written_law(law) for name, law in rules.laws.items()}
    return {
        "based_on": PAPER.name,
        "name": rules.name,
        "gantry_law": written_law(rules.gantry_law),
        "agv_law": written_law(rules.agv_law),
        **({"laws": laws} if laws else {}),
        **({"reactions": dict(rules.reactions)} if rules.reactions else {}),
        "notice": {
            "law": written_law(notice.law.law),
            "factor": notice.law.factor,
            "cap": notice.law.cap if notice.law.cap < math.inf else None,
            "every": notice.every,
            **({"parting": notice.parting} if notice.parting < math.inf else {}),
            "silent": notice.silent,
        },
        **{
            key: value
            for key in _PLAIN
            for value in (getattr(rules, key),)
            if value is not None or key != "between_people"
        },
    }
