"""Planners by name with their parameters, the choice of a planner, and the paths it returns."""

from __future__ import annotations

import inspect
import math
import re
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import field, replace
from functools import cache, cached_property
from typing import Any, Literal, NamedTuple, TypeAlias

import numpy as np
import ompl.base as ob
import ompl.geometric as og
from numpy.typing import NDArray

from floorplan import InputError, UserError
from floorplan.files.dataclass import dataclass
from floorplan.files.documents import parse_yaml
from floorplan.files.problems import field_name, suggestion

Reason = Literal["start_blocked", "goal_blocked", "unreachable", "not_found"]


@dataclass(frozen=True, eq=False, kw_only=True)
class Path:
    """Polyline on the floor that a disc can follow without touching anything.

    It converts to an array of its points, as in `walk(path)`.

    Parameters
    ----------
    points : numpy.ndarray
        Waypoints, shape (N, 2), in metres. The first and last are exactly start and goal.
    clear : float or callable
        Clearance in metres, or a function that computes it.
    planner : str
        Name of the planner.
    """

    points: NDArray[np.float64]
    clear: float | Callable[[], float] = field(repr=False)
    planner: str

    def __repr__(self) -> str:
        figures = f"{len(self.points)} waypoints, {self.clearance:.3f} m clear"
        return f"<{type(self).__name__} of {self.length:.3f} m by {self.planner}: {figures}>"

    def __getstate__(self) -> dict[str, Any]:
        """Return its fields, with the clearance as a number."""
        return vars(self) | {"clear": self.clearance}

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray[Any]:
        """Return the points, so that a path can replace an array."""
        return np.array(self.points, dtype=dtype, copy=True if copy is None else copy)

    @cached_property
    def clearance(self) -> float:
        """Minimum distance in metres from the polyline to obstacles and bodies.

        It is computed when it is first read, for the world at the time of planning.
        """
        return self.clear if isinstance(self.clear, float) else self.clear()

    @property
    def length(self) -> float:
        """Length in metres."""
        return float(np.hypot(*np.diff(self.points[:, :2], axis=0).T).sum())


class PlanningError(Exception):
    """There is no path, or none was found.

    Parameters
    ----------
    reason : str
        "start_blocked" or "goal_blocked" without room at that end; "unreachable" if it is proved
        that there is no path; "not_found" if a planner's budget ended first.
    message : str or callable
        Explanation with the obstacles in the way, or a function that returns it. It is computed
        when it is first read, for the world at the time of planning.
    """

    def __init__(self, reason: Reason, message: str | Callable[[], str]) -> None:
        super().__init__(reason)
        self.reason: Reason = reason
        self._message = message

    @property
    def message(self) -> str:
        """Explanation with the obstacles in the way."""
        if not isinstance(self._message, str):
            self._message = self._message()
        return self._message

    def __str__(self) -> str:
        return self.message

    def __reduce__(self) -> tuple[type[PlanningError], tuple[Reason, str]]:
        return (type(self), (self.reason, self.message))


class PlannerError(UserError):
    """Planner that is unknown, or that failed."""


@dataclass(frozen=True)
class PlannerInfo:
    """Planner with a name."""

    name: str
    summary: str
    optimal: bool
    """Whether paths approach the shortest one with a growing budget."""
    iterations: int = 0
    """Default budget."""
    parameters: tuple[str, ...] = ()
    """Names of the parameters."""


class Watch:
    """Observer of a search of an OMPL planner. This one does nothing.

    Subclasses implement a time limit, or a curve of cost over time.
    """

    def iteration(self, planner: Any) -> bool:
        """Return True to end the search. It is called before each iteration of OMPL's `planner`."""
        return False

    def solved(self) -> None:
        """Handle a path that was found, before it is simplified."""


ROADMAP = "Roadmap"
"""Name of the default planner."""

Setting: TypeAlias = "bool | int | float | str"
"""Value of one parameter of a planner."""

SPACE_TIME = "STRRTstar"
"""OMPL's planner in space and time, which cannot plan a path in space. OMPL 2.0.1 has it in C++
only."""

_KNOWN = {
    "AORRTC": ("repeated RRTConnect for shorter paths", True, 2_000),
    "BFMT": ("fast marching trees from both ends over one batch of samples", True, 100_000),
    "BITstar": ("batches of samples, searched in order of estimated path length", True, 4_000),
    "BKPIECE1": ("trees from both ends into the least covered cells", False, 20_000),
    "FMT": ("a fast marching tree over one batch of samples", True, 100_000),
    "InformedRRTstar": ("RRT* that samples only where a shorter path is possible", True, 2_000),
    "KPIECE1": ("a tree into the least covered cells", False, 20_000),
    "LBKPIECE1": ("BKPIECE with lazy collision checks", False, 100_000),
    "PRM": ("a roadmap of samples, linked to their neighbours", False, 1_000),
    "PRMstar": ("a roadmap of samples with enough links to be optimal", True, 1_000),
    "RRT": ("a tree of random steps from the start", False, 20_000),
    "RRTConnect": ("trees from both ends that grow towards each other", False, 20_000),
    "RRTstar": ("RRT that rewires its tree for shorter paths", True, 2_000),
    "SORRTstar": ("Informed RRT* that takes its samples in order", True, 2_000),
}
"""Summary, whether it is optimal, and iterations of the planners of OMPL 2."""

EVERY = ("iterations", "simplify")
"""Parameters of all planners in addition to OMPL's."""

ITERATIONS = 2_000
"""Default budget of an unlisted planner."""

_NOT_A_NUMBER = ("ProjectionEvaluator", "DefaultConnectionStrategy")


_DEFAULT = PlannerInfo(ROADMAP, "the shortest path along the corners of what stands there", True)


def planners() -> tuple[PlannerInfo, ...]:
    """Return all planners with a name.

    Returns
    -------
    tuple of PlannerInfo
        `name`, `summary`, `optimal`, `iterations` (default budget) and `parameters` of each
        planner. The default planner is the first.

    Examples
    --------
    >>> from navigation import planners
    >>> [info.name for info in planners()][:3]
    ['Roadmap', 'AORRTC', 'BFMT']
    """
    return (_DEFAULT, *_sampling_planners())


def planner_info(name: str) -> PlannerInfo:
    """Return the planner called `name`. `UserError` with a suggestion if there is none."""
    if name == ROADMAP:
        return _DEFAULT
    infos = {info.name: info for info in planners()}
    if name == SPACE_TIME:
        raise UserError(f"{name} plans in space and time; navigation.plan_among answers for that")
    if ":" in name:
        raise UserError(f"the planner {name} is code of your own: import it, and give its class")
    if name not in infos:
        raise UserError(f"no planner is called {name!r}; {suggestion(name, infos)}")
    return infos[name]


@cache
def _sampling_planners() -> tuple[PlannerInfo, ...]:
    """Return the geometric planners of the installed OMPL, by name."""
    infos = []
    for name in sorted(dir(og)):
        kind = getattr(og, name)
        if isinstance(kind, type) and issubclass(kind, ob.Planner) and name != SPACE_TIME:
            facts = _KNOWN.get(name, (f"OMPL's {name}", False, ITERATIONS))
            infos.append(PlannerInfo(name, *facts, (*EVERY, *_setters(kind))))
    return tuple(infos)


def check_parameters(info: PlannerInfo, parameters: Mapping[str, Setting]) -> None:
    """Raise `ValueError` for a parameter that planner `info` does not have, or an invalid value."""
    if info.name == ROADMAP:
        if parameters:
            raise UserError(f"{ROADMAP} has no parameters, found {', '.join(parameters)}")
        return
    for name in parameters:
        if name not in info.parameters:
            hint = suggestion(name, info.parameters)
            raise UserError(f"{info.name} has no parameter {name!r}; {hint}")
    if own := settings_of(parameters).own:
        space = ob.RealVectorStateSpace(2)
        planner = getattr(og, info.name)(ob.SpaceInformation(space))
        for name, value in own.items():
            set_parameter(planner, name, value)


def check_own(kind: type, parameters: Mapping[str, Setting]) -> None:
    """Raise `ValueError` unless `kind` accepts a space information and these parameters."""
    try:
        signature = inspect.signature(kind)
    except (TypeError, ValueError):  # a class in C++
        return
    own = settings_of(parameters).own
    try:
        signature.bind(None, **own)
    except TypeError as why:
        names = [*list(signature.parameters)[1:], *EVERY]
        unknown = [name for name in own if name not in names]
        hint = f"; {suggestion(unknown[0], names)}" if unknown else ""
        raise UserError(f"{kind.__qualname__}: {why}{hint}") from None


class Settings(NamedTuple):
    """Parameters of a search: its budget, whether to simplify paths, and those of the planner."""

    iterations: int
    simplify: bool
    own: dict[str, Setting]


def settings_of(parameters: Mapping[str, Setting], iterations: int = ITERATIONS) -> Settings:
    """Return the settings of a search. `UserError` if one for all planners is invalid."""
    own = dict(parameters)
    budget = fit("iterations", own.pop("iterations", iterations), 1)
    return Settings(budget, fit("simplify", own.pop("simplify", True), True), own)


def _setters(kind: type) -> tuple[str, ...]:
    """Return the names of the parameters of an OMPL planner class by its setters."""
    own = [m[3:] for m in dir(kind) if m.startswith("set") and not hasattr(ob.Planner, m)]
    return tuple(_snake(name) for name in own if name not in _NOT_A_NUMBER)


def _snake(name: str) -> str:
    return re.sub(r"(?<=[a-z])(?=[A-Z])", "_", name).lower()


def set_parameter(planner: Any, parameter: str, value: object) -> None:
    """Set a parameter of an OMPL planner by name. `UserError` if the value is invalid."""
    (camel,) = (m[3:] for m in dir(planner) if m[:3] == "set" and _snake(m[3:]) == parameter)
    now = getattr(planner, f"get{camel}")()
    getattr(planner, f"set{camel}")(fit(parameter, value, now))


def fit(parameter: str, value: object, like: Any) -> Any:
    """Return `value` as a number of the type of `like`. `ValueError` if it is none."""
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


_FORMS = "a name, or {name: RRTConnect, range: 1.0}"


@dataclass(frozen=True)
class PlannerChoice:
    """Planner by name with its parameters.

    The name is one of `planners()`, or `package.module:Class` of a custom planner. After the
    import, `kind` is its class, derived from `ompl.base.Planner`.
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
        """True for a custom planner."""
        return self.kind is not None or ":" in self.name

    @staticmethod
    def of(choice: PlannerChoice | str | Mapping[str, Any] | type) -> PlannerChoice:
        """Return the choice in one of several forms. `ValueError` if it has none of these.

        Forms are a name, `{name: RRTConnect, range: 1.0}`, `{RRTConnect: {range: 1.0}}`, one of
        these as YAML text, and the class of a custom planner.
        """
        if isinstance(choice, PlannerChoice):
            return choice
        if isinstance(choice, type):
            return PlannerChoice(f"{choice.__module__}:{choice.__qualname__}", kind=choice)
        if isinstance(choice, str):
            return _in_text(choice)
        if isinstance(choice, Mapping) and choice:
            if "name" in choice:
                rest = {key: value for key, value in choice.items() if key != "name"}
                return _chosen(choice["name"], rest)
            if len(choice) == 1:
                ((name, inner),) = choice.items()
                return _chosen(name, {} if inner is None else inner)
        raise UserError(f"a planner is {_FORMS}; found {choice!r}")

    def with_parameters(self, parameters: Mapping[str, Setting]) -> PlannerChoice:
        """Return this choice with additional or changed parameters."""
        return replace(self, parameters=tuple({**dict(self.parameters), **parameters}.items()))

    def check(self) -> None:
        """Raise `ValueError` if there is no such planner or a parameter is invalid.

        A custom planner is checked only after its import.
        """
        if self.kind is not None:
            check_own(self.kind, dict(self.parameters))
        elif self.is_own:
            settings_of(dict(self.parameters))
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
