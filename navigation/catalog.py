"""The planners there are, by name, and their parameters."""

from __future__ import annotations

import inspect
import math
import re
from collections.abc import Mapping
from contextlib import suppress
from functools import cache
from typing import Any, TypeAlias

import ompl.base as ob
import ompl.geometric as og

from floorplan import UserError, suggestion

from .path import PlannerInfo

ROADMAP = "Roadmap"
"""The name of the default planner."""

Setting: TypeAlias = "bool | int | float | str"
"""Value of one parameter of a planner."""

SPACE_TIME = "STRRTstar"
"""OMPL's planner in space and time, where it has one: OMPL 2.0.1 has it in C++ alone. It can't be
asked for a path in space."""

_KNOWN = {
    "AORRTC": ("RRTConnect again and again, each time for a shorter path", True, 2_000),
    "BFMT": ("fast marching trees from both ends over one batch of samples", True, 100_000),
    "BITstar": ("batches of samples, searched in order of promise", True, 4_000),
    "BKPIECE1": ("trees from both ends into the least covered cells", False, 20_000),
    "FMT": ("a fast marching tree over one batch of samples", True, 100_000),
    "InformedRRTstar": ("RRT* that samples only where a shorter path may be", True, 2_000),
    "KPIECE1": ("a tree into the least covered cells", False, 20_000),
    "LBKPIECE1": ("BKPIECE that checks links only when needed", False, 100_000),
    "PRM": ("a roadmap of samples, linked to their neighbours", False, 1_000),
    "PRMstar": ("a roadmap of samples with links enough to be optimal", True, 1_000),
    "RRT": ("a tree of random steps from the start", False, 20_000),
    "RRTConnect": ("trees from both ends that reach for each other", False, 20_000),
    "RRTstar": ("RRT that rewires its tree for shorter paths", True, 2_000),
    "SORRTstar": ("Informed RRT* that takes its samples in order", True, 2_000),
}
"""Summary, whether it is optimal, and iterations, of the planners of OMPL 2."""

EVERY = ("iterations", "simplify")
"""The parameters that all of them have on top of OMPL's."""

ITERATIONS = 2_000
"""Budget of a planner that this file does not know."""

_NOT_A_NUMBER = ("ProjectionEvaluator", "DefaultConnectionStrategy")


_DEFAULT = PlannerInfo(ROADMAP, "the shortest path along the corners of what stands there", True)


def planners() -> tuple[PlannerInfo, ...]:
    """Return every planner that can be asked for by name, the default one first."""
    return (_DEFAULT, *_sampling_planners())


def planner_info(name: str) -> PlannerInfo:
    """Return the planner that is called `name`; `ValueError` with a hint if there is none."""
    if name == ROADMAP:
        return _DEFAULT
    known = {info.name: info for info in planners()}
    if name == SPACE_TIME:
        raise UserError(f"{name} plans in space and time; navigation.plan_among answers for that")
    if ":" in name:
        raise UserError(f"the planner {name} is code of your own: import it, and give its class")
    if name not in known:
        raise UserError(f"no planner is called {name!r}; {suggestion(name, known)}")
    return known[name]


@cache
def _sampling_planners() -> tuple[PlannerInfo, ...]:
    """Return the geometric planners of the OMPL that is installed, by name."""
    found = []
    for name in sorted(dir(og)):
        kind = getattr(og, name)
        if isinstance(kind, type) and issubclass(kind, ob.Planner) and name != SPACE_TIME:
            known = _KNOWN.get(name, (f"OMPL's {name}", False, ITERATIONS))
            found.append(PlannerInfo(name, *known, (*EVERY, *_setters(kind))))
    return tuple(found)


def check_parameters(info: PlannerInfo, parameters: Mapping[str, Setting]) -> None:
    """Raise `ValueError` for a parameter that planner `info` has not, or a value that is unfit."""
    if info.name == ROADMAP:
        if parameters:
            raise UserError(f"{ROADMAP} has no parameters, found {', '.join(parameters)}")
        return
    for name in parameters:
        if name not in info.parameters:
            hint = suggestion(name, info.parameters)
            raise UserError(f"{info.name} has no parameter {name!r}; {hint}")
    settings = without_every(parameters)
    if settings:
        space = ob.RealVectorStateSpace(2)
        planner = getattr(og, info.name)(ob.SpaceInformation(space))
        for name, value in settings.items():
            set_parameter(planner, name, value)


def check_own(kind: type, parameters: Mapping[str, Setting]) -> None:
    """Raise `ValueError` unless `kind` is made of a space information and these parameters."""
    try:
        signature = inspect.signature(kind)
    except (TypeError, ValueError):  # written in C++
        return
    given = without_every(parameters)
    try:
        signature.bind(None, **given)
    except TypeError as why:
        known = [*list(signature.parameters)[1:], *EVERY]
        unknown = [name for name in given if name not in known]
        hint = f"; {suggestion(unknown[0], known)}" if unknown else ""
        raise UserError(f"{kind.__qualname__}: {why}{hint}") from None


def without_every(parameters: Mapping[str, Setting]) -> dict[str, Setting]:
    """Return `parameters` without those that all planners have; `ValueError` if one is unfit."""
    rest = dict(parameters)
    fit("iterations", rest.pop("iterations", 1), 1)
    fit("simplify", rest.pop("simplify", True), True)
    return rest


def _setters(kind: type) -> tuple[str, ...]:
    """Return the names of the parameters of an OMPL planner class, from its setters."""
    own = [m[3:] for m in dir(kind) if m.startswith("set") and not hasattr(ob.Planner, m)]
    return tuple(_snake(name) for name in own if name not in _NOT_A_NUMBER)


def _snake(name: str) -> str:
    return re.sub(r"(?<=[a-z])(?=[A-Z])", "_", name).lower()


def set_parameter(planner: Any, parameter: str, value: object) -> None:
    (camel,) = (m[3:] for m in dir(planner) if m[:3] == "set" and _snake(m[3:]) == parameter)
    now = getattr(planner, f"get{camel}")()
    getattr(planner, f"set{camel}")(fit(parameter, value, now))


def fit(parameter: str, value: object, like: Any) -> Any:
    """Return `value` as the kind of number that `like` is; `ValueError` if it isn't one."""
    if isinstance(like, bool):
        if isinstance(value, bool):
            return value
        raise UserError(f"parameter {parameter!r} must be true or false, found {value!r}")
    number = math.nan
    if isinstance(value, int | float) and not isinstance(value, bool):
        with suppress(OverflowError):
            number = float(value)
    if isinstance(like, int):
        if number > 0 and number.is_integer():
            return int(number)
        raise UserError(f"parameter {parameter!r} must be a whole number above 0, found {value!r}")
    if 0 <= number < math.inf:
        return number
    raise UserError(f"parameter {parameter!r} must be a number, 0 or more, found {value!r}")
