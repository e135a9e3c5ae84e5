"""Rule sets and laws in files: keys, reading, and writing.

Laws are written as `{iso_ts_15066: {t1: 1.0, t2: 1.5}}`, `{fixed: 2.1}`, or `{package.module:Class:
{deceleration: 2.0}}` for custom laws.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import MISSING, Field, fields, replace
from pathlib import Path
from typing import Annotated, Any, get_type_hints

from pydantic import create_model, model_validator

from floorplan import InputError, Problem, UserError
from floorplan.files.documents import Document, read_yaml
from floorplan.files.fields import LARGEST, Expected, NotNegative, Positive
from floorplan.files.models import Strictly
from floorplan.files.problems import suggestion
from floorplan.files.reading import is_file
from navigation import ApproachLaw, FixedDistance, IntegralLaw, Scaled, SeparationLaw
from navigation.separation import AnyLaw

from ..core.custom_code import CodeFolder
from ..core.rules import (
    PAPER,
    RULE_SETS,
    Lasting,
    MachineMeasure,
    Notice,
    RuleSet,
    rule_set,
)
from ..safety.laws import LAW, LawError, OwnLaw

LAWS: dict[str, Any] = {
    "iso_ts_15066": SeparationLaw,
    "iso_ts_15066_integral": IntegralLaw,
    "iso_13855": ApproachLaw,
    "fixed": FixedDistance,
}
"""Laws by their names in files."""

Terms = Annotated[
    dict[str, Any], Expected("a law with its terms, as {iso_13855: {time: 1.0}}", dict)
]
"""Law in a file: its name with its terms."""


class WrittenLawError(UserError):
    """Invalid law, and the `place` of the fault among its keys."""

    def __init__(self, message: str, *place: str) -> None:
        super().__init__(message)
        self.place = place


def read_law(terms: Mapping[str, Any], folder: CodeFolder, place: str = "") -> AnyLaw:
    """Return the law with these `terms`. `WrittenLawError` if they are invalid.

    Custom laws are in `folder`, and imported later. Their errors at that time name the `place`.
    """
    if len(terms) != 1:
        raise WrittenLawError(
            f"give one law with its terms: {', '.join(LAWS)}, or package.module:Class"
        )
    ((name, values),) = terms.items()
    if ":" not in name and name not in LAWS:
        raise WrittenLawError(
            f"no law is called {name!r}; {suggestion(name, LAWS)}"
            " (your own is package.module:Class)"
        )
    if name == "fixed" and not isinstance(values, Mapping):
        values = {"metres": values}
    values = {} if values is None else values
    if not isinstance(values, Mapping) or not all(isinstance(key, str) for key in values):
        needed = f" ({', '.join(_needed(name))})" if name in LAWS else ""
        raise WrittenLawError(
            f"expected the terms of the law{needed} with their values, found {values!r}", name
        )
    if ":" in name:
        return _own_law(name, values, folder, place)
    form = LAWS[name]
    term_fields = {term.name: term for term in fields(form)}
    for term, value in values.items():
        _check_term(name, term, value, term_fields)
    if missing := [term for term in _needed(name) if term not in values]:
        be = "is" if len(missing) == 1 else "are"
        raise WrittenLawError(f"{' and '.join(missing)} {be} missing", name)
    try:
        law: AnyLaw = form(**{term: value for term, value in values.items() if value is not None})
        return law
    except ValueError as why:
        at = next((term for term in values if str(why).startswith(f"{term} ")), None)
        raise WrittenLawError(str(why), name, *([at] if at else [])) from why


def _own_law(name: str, values: Mapping[str, Any], folder: CodeFolder, place: str) -> AnyLaw:
    try:
        folder.find(name, LAW)
    except LawError as why:
        raise WrittenLawError(str(why), name) from why
    return OwnLaw(name, values, folder.path, place)


def _no_term(law: str, term: str, terms: Iterable[str]) -> WrittenLawError:
    there = ", ".join(terms)
    hint = f"its terms: {there}" if there else "it has none"
    return WrittenLawError(f"{law} has no term {term!r}; {hint}", law, term)


def _needed(law: str) -> list[str]:
    """Return the terms of a law that have no default."""
    return [term.name for term in fields(LAWS[law]) if term.default is MISSING]


def _check_term(law: str, term: str, value: object, term_fields: Mapping[str, Field[Any]]) -> None:
    if term not in term_fields:
        raise _no_term(law, term, term_fields)
    if value is None and term_fields[term].default is None:
        return
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise WrittenLawError(f"expected a number, found {value!r}", law, term)
    if math.inf > abs(value) > LARGEST:
        raise WrittenLawError("the number is too large", law, term)


def written_law(law: AnyLaw) -> Terms:
    """Return the law in the form of a file. `UserError` if it cannot be written."""
    if isinstance(law, OwnLaw):
        return {law.name: law.terms}
    for name, form in LAWS.items():
        if type(law) is form:
            return {name: {term.name: getattr(law, term.name) for term in fields(LAWS[name])}}
    raise UserError(f"the law {law!r} can't be written: it came from no file")


class RulesError(InputError):
    """Invalid file of a rule set."""


class NoticeKeys(Strictly):
    """Keys of noticing the gantry. Missing keys are those of the base."""

    law: Terms | None = None
    factor: Positive | None = None
    cap: Positive | None = None
    every: Positive | None = None
    parting: Positive | None = None
    silent: NotNegative | None = None


class Disable(Strictly):
    """Measure for the machine with its duration, short for `gantry_disabled`."""

    disable: Lasting


class RuleKeys(Strictly):
    """Keys of a rule set. Missing keys are those of the base.

    Text is the name of a built-in rule set, or a file (`source`). These keys differ from the fields
    of a `RuleSet`. `RuleForm` has all keys.
    """

    source: str | None = None
    based_on: str = PAPER.name
    name: str | None = None
    gantry_law: Terms | None = None
    agv_law: Terms | None = None
    laws: dict[str, Terms] = {}
    notice: NoticeKeys = NoticeKeys()
    reactions: dict[str, NotNegative] = {}

    @model_validator(mode="before")
    @classmethod
    def _named(cls, value: object) -> object:
        if isinstance(value, str):
            return {"source": value}
        if isinstance(value, Mapping) and (laws := [name for name in LAWS if name in value]):
            raise UserError(f"{laws[0]} is a law; give it as gantry_law or agv_law, or in laws")
        if isinstance(value, Mapping) and "source" in value:
            raise UserError("unknown key 'source'; for a rule set of a file write rules: FILE")
        return value


_HINTS = get_type_hints(RuleSet, include_extras=True) | {"machine": MachineMeasure | Disable}
_ALIKE: dict[str, Any] = {
    key.name: (_HINTS[key.name] | None, None)
    for key in fields(RuleSet)
    if key.compare and key.name not in RuleKeys.model_fields
}
"""Keys with the same names and values as fields, with their types and defaults."""

RuleForm = create_model("RuleForm", __base__=RuleKeys, **_ALIKE)
"""All keys of a rule set in a file."""


def load_rules(path: str | Path, *, own_code: bool = True) -> RuleSet:
    """Return the rule set in a YAML file.

    Custom laws must be beside the file. They are imported when the rules are first applied.

    Parameters
    ----------
    path : str or Path
        File.
    own_code : bool, optional
        Whether the file may name custom laws.

    Raises
    ------
    RulesError
        If the file cannot be read or contains errors. All errors are reported together.
    """
    path = Path(path)
    document = read_yaml(path, RulesError)
    keys = document.checked(RuleForm, RulesError)
    rules, problems = build_rules(keys, document, CodeFolder(path.parent, own_code))
    if problems:
        raise RulesError(document.file, problems)
    return rules if keys.name else replace(rules, name=path.name.split(".")[0])


def find_rules(source: str, folder: CodeFolder) -> RuleSet:
    """Return the built-in rule set called `source`, or the one in a file relative to `folder`.

    `RulesError` if the file is invalid, `UserError` if there is neither.
    """
    path = folder.path / source
    if source not in RULE_SETS and is_file(path):
        return load_rules(path, own_code=folder.allowed)
    return rule_set(source)


def build_rules(
    keys: RuleKeys, document: Document, folder: CodeFolder, *place: str
) -> tuple[RuleSet, list[Problem]]:
    """Return the rule set of `keys` at `place` in `document`, and its problems.

    If there are problems, the rule set is not valid.
    """
    if keys.source is not None:
        try:
            return find_rules(keys.source, folder), []
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

    def law(terms: Terms | None, *key: str) -> AnyLaw | None:
        if terms is None:
            return None
        at = f"{document.file}: {document.problem('', *place, *key)}".removesuffix(": ")
        try:
            return read_law(terms, folder, at)
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
        | {key: of_machine for key, of_machine in of_machines.items() if of_machine is not None},
        notice=_notice(keys.notice, base.notice, noticed_by),
        reactions={**base.reactions, **keys.reactions},
        **_plain(keys),
    )
    if rules.between == "surfaces":
        if getattr(keys, "agv_offset", None):
            message = "distances between surfaces are not measured to a point; leave it out"
            problems.append(document.problem(message, *place, "agv_offset"))
        rules = replace(rules, agv_offset=0.0)
    return rules, problems


def _plain(keys: RuleKeys) -> dict[str, Any]:
    """Return the values of simple keys. Missing and null keys are those of the base."""
    values = {key: getattr(keys, key) for key in _ALIKE if key in keys.model_fields_set}
    if isinstance(measure := values.get("machine"), Disable):
        values |= {"machine": "disable", "gantry_disabled": measure.disable}
    may_be_none = "report_every"
    return {key: value for key, value in values.items() if value is not None or key == may_be_none}


def _notice(keys: NoticeKeys, base: Notice, law: AnyLaw) -> Notice:
    present = keys.model_fields_set
    factor = base.law.factor if keys.factor is None else keys.factor
    cap = (keys.cap or math.inf) if "cap" in present else base.law.cap
    every = keys.every if "every" in present else base.every
    parting = keys.parting or (math.inf if keys.every else base.parting)
    if every is None and parting == math.inf:
        parting = Notice(law=base.law).parting
    silent = base.silent if keys.silent is None else keys.silent
    return Notice(law=Scaled(law, factor, cap), parting=parting, every=every, silent=silent)


def written_rules(rules: RuleSet) -> str | dict[str, Any]:
    """Return the keys in which a rule set differs from its base, or its built-in name.

    `UserError` if one of its laws cannot be written.
    """
    if RULE_SETS.get(rules.name) == rules:
        return rules.name
    if rules.between == "surfaces":
        rules = replace(rules, agv_offset=0.0)
    own, base = _all_keys(rules), _all_keys(PAPER)
    if own["gantry_law"] != base["gantry_law"]:
        del base["notice"]  # by default it has the law of the gantry
    changed = {key: value for key, value in own.items() if key not in base or base[key] != value}
    return {"based_on": PAPER.name, "name": rules.name, **changed}


def _all_keys(rules: RuleSet) -> dict[str, Any]:
    notice = rules.notice
    laws = {name: written_law(law) for name, law in rules.laws.items()}
    return {
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
            for key in _ALIKE
            for value in (getattr(rules, key),)
            if value is not None or key != "between_people"
            if value != "centres" or key != "between"
        },
    }
