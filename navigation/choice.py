"""Choices of a planner: its name and its parameters, as files, options and Python write them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from floorplan import InputError, UserError, field_name, parse_yaml

from .catalog import (
    EVERY,
    ROADMAP,
    Setting,
    check_own,
    check_parameters,
    planner_info,
    without_every,
)

_FORMS = "a name, or {name: RRTConnect, range: 1.0}"


@dataclass(frozen=True)
class PlannerChoice:
    """A planner by its name, with parameters by theirs.

    The name is one of `planners()`, or `package.module:Class` for one of the user's own, whose
    class, a subclass of `ompl.base.Planner`, is `kind` once it has been imported.
    """

    name: str = ROADMAP
    parameters: tuple[tuple[str, Setting], ...] = ()
    kind: type | None = None

    def __str__(self) -> str:
        if not self.parameters:
            return self.name
        inner = ", ".join(f"{name}: {_written(value)}" for name, value in self.parameters)
        return f"{self.name}: {{{inner}}}"

    @property
    def is_own(self) -> bool:
        """True if it is code of the user's own."""
        return self.kind is not None or ":" in self.name

    @property
    def own_parameters(self) -> dict[str, Setting]:
        """The parameters but for those that every planner has."""
        return {name: value for name, value in self.parameters if name not in EVERY}

    @staticmethod
    def of(given: PlannerChoice | str | Mapping[str, Any] | type) -> PlannerChoice:
        """Return the choice that is written as `given`; `ValueError` if it is none.

        That is a name, `{name: RRTConnect, range: 1.0}`, `{RRTConnect: {range: 1.0}}`, a text with
        one of these in YAML, or the class of a planner of one's own.
        """
        if isinstance(given, PlannerChoice):
            return given
        if isinstance(given, type):
            return PlannerChoice(f"{given.__module__}:{given.__qualname__}", kind=given)
        if isinstance(given, str):
            return _in_text(given)
        if isinstance(given, Mapping) and given:
            if "name" in given:
                rest = {key: value for key, value in given.items() if key != "name"}
                return _chosen(given["name"], rest)
            if len(given) == 1:
                ((name, inner),) = given.items()
                return _chosen(name, {} if inner is None else inner)
        raise UserError(f"a planner is {_FORMS}; found {given!r}")

    def with_parameters(self, parameters: Mapping[str, Setting]) -> PlannerChoice:
        """Return this choice with further parameters, or others of the same names."""
        return replace(self, parameters=tuple({**dict(self.parameters), **parameters}.items()))

    def check(self) -> None:
        """Raise `ValueError` if there is no such planner, or if a parameter does not fit it.

        Of a planner of the user's own that has not been imported, only a run can tell.
        """
        if self.kind is not None:
            check_own(self.kind, dict(self.parameters))
        elif self.is_own:
            without_every(dict(self.parameters))
        else:
            check_parameters(planner_info(self.name), dict(self.parameters))


def _in_text(text: str) -> PlannerChoice:
    if not {*" {}\n"} & {*text.strip()}:
        return _chosen(text.strip(), {})
    try:
        value = parse_yaml(text, "planner", InputError).data
    except InputError as why:
        raise UserError(f"a planner is {_FORMS}; {text!r} is neither: {why}") from None
    if isinstance(value, Mapping):
        return PlannerChoice.of(value)
    return _chosen(text.strip(), {})


def _chosen(name: object, parameters: object) -> PlannerChoice:
    if not isinstance(name, str) or not name:
        raise UserError(f"a planner is {_FORMS}; found {name!r} as its name")
    if not isinstance(parameters, Mapping):
        raise UserError(f"the parameters of {name} are {{name: value, …}}; found {parameters!r}")
    for key, value in parameters.items():
        if not isinstance(value, bool | int | float | str):
            place = field_name((str(key),))
            raise UserError(f"parameter {place!r} of {name} must be a value, found {value!r}")
    return PlannerChoice(name, tuple((str(key), value) for key, value in parameters.items()))


def _written(value: Setting) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    return repr(value) if isinstance(value, float) else str(value)
