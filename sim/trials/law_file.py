"""Laws as files have them: a name with its terms.

`{iso_ts_15066: {t1: 1.0, t2: 1.5}}`, `{fixed: 2.1}`, or one of the user's own,
`{package.module:Class: {deceleration: 2.0}}`.
"""

from __future__ import annotations

import ast
import math
from collections.abc import Iterable, Mapping
from dataclasses import MISSING, Field, fields
from pathlib import Path
from typing import Any

from floorplan import LARGEST, UserError, suggestion
from navigation import AnyLaw, ApproachLaw, FixedDistance, IntegralLaw, SeparationLaw

from ..core.own_parameters import parameters
from ..core.own_source import REFUSED, OwnCodeError, find_source
from ..safety.own_law import LAW, OwnLaw

LAWS: dict[str, Any] = {
    "iso_ts_15066": SeparationLaw,
    "iso_ts_15066_integral": IntegralLaw,
    "iso_13855": ApproachLaw,
    "fixed": FixedDistance,
}
"""The laws that files name."""

Terms = dict[str, Any]
"""A law as it is written: its name, and with it its terms."""


class WrittenLawError(UserError):
    """A law that is wrong, and the `place` among its keys."""

    def __init__(self, message: str, *place: str) -> None:
        super().__init__(message)
        self.place = place


def read_law(
    terms: Mapping[str, Any], folder: Path, *, own_code: bool = True, place: str = ""
) -> AnyLaw:
    """Return the law that is written as `terms`; `WrittenLawError` says what is wrong with it.

    Laws of one's own stand in `folder`, and are not imported yet: what only that can show they say
    when they are first asked, with their `place`. Without `own_code` they are refused.
    """
    if len(terms) != 1:
        raise WrittenLawError(
            f"give one law with its terms: {', '.join(LAWS)}, or package.module:Class"
        )
    ((name, given),) = terms.items()
    if ":" not in name and name not in LAWS:
        raise WrittenLawError(
            f"no law is called {name!r}; {suggestion(name, LAWS)}"
            " (your own is package.module:Class)"
        )
    if name == "fixed" and not isinstance(given, Mapping):
        given = {"metres": given}
    given = {} if given is None else given
    if not isinstance(given, Mapping) or not all(isinstance(key, str) for key in given):
        raise WrittenLawError(
            f"expected the terms of the law with their values, found {given!r}", name
        )
    if ":" in name:
        return _own_law(name, given, folder, own_code, place)
    form = LAWS[name]
    known = {term.name: term for term in fields(form)}
    for term, value in given.items():
        _check_term(name, term, value, known)
    needed = [term for term, field in known.items() if field.default is MISSING]
    _require_terms(name, needed, given)
    try:
        law: AnyLaw = form(**{term: value for term, value in given.items() if value is not None})
        return law
    except ValueError as why:
        at = next((term for term in given if str(why).startswith(f"{term} ")), None)
        raise WrittenLawError(str(why), name, *([at] if at else [])) from why


def _own_law(
    name: str, given: Mapping[str, Any], folder: Path, own_code: bool, place: str
) -> AnyLaw:
    if not own_code:
        raise WrittenLawError(REFUSED, name)
    try:
        source = find_source(name, folder, LAW)
    except OwnCodeError as why:
        raise WrittenLawError(f"the law {why}", name) from why
    assert isinstance(source.definition, ast.ClassDef)  # as it is a law
    takes = parameters(source.definition)
    if takes is not None:
        for term in given:
            if term not in takes.names and not takes.any_name:
                raise _no_term(name, term, takes.names)
        _require_terms(name, takes.needed, given)
    return OwnLaw(name, given, folder, place)


def _no_term(law: str, term: str, known: Iterable[str]) -> WrittenLawError:
    there = ", ".join(known)
    hint = f"its terms: {there}" if there else "it has none"
    return WrittenLawError(f"{law} has no term {term!r}; {hint}", law, term)


def _require_terms(law: str, needed: Iterable[str], given: Mapping[str, Any]) -> None:
    if missing := [term for term in needed if term not in given]:
        be = "is" if len(missing) == 1 else "are"
        raise WrittenLawError(f"{' and '.join(missing)} {be} missing", law)


def _check_term(law: str, term: str, value: object, known: Mapping[str, Field[Any]]) -> None:
    if term not in known:
        raise _no_term(law, term, known)
    if value is None and known[term].default is None:
        return
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise WrittenLawError(f"expected a number, found {value!r}", law, term)
    if math.inf > abs(value) > LARGEST:
        raise WrittenLawError("the number is too large", law, term)


def written_law(law: AnyLaw) -> Terms:
    """Return the law as a file has it; `ValueError` if it can't be written."""
    if isinstance(law, OwnLaw):
        return {law.name: law.terms}
    for name, form in LAWS.items():
        if type(law) is form:
            return {name: {term.name: getattr(law, term.name) for term in fields(LAWS[name])}}
    raise UserError(f"the law {law!r} can't be written: it came from no file")
