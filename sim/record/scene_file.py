"""Scene file of a recording (`scene.json`), and strict parsing of JSON.

Areas are GeoJSON polygons, everything else the fields of values by name. Fields that an older
recording lacks have their default.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable
from dataclasses import fields, is_dataclass
from typing import Any, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, ValidationError
from pydantic_core import from_json
from shapely import GEOSException
from shapely.geometry import Polygon, mapping, shape

from floorplan import Floorplan, Obstacle, UserError
from floorplan.checks import polygon_fault
from floorplan.files.dataclass import dataclass
from floorplan.files.fields import LARGEST
from floorplan.files.forms import BY_FIELDS
from floorplan.files.problems import field_name
from floorplan.model import LEFT_OUT_IF_EMPTY
from navigation import ApproachLaw, FieldSet, FixedDistance, IntegralLaw, Scaled, SeparationLaw

from ..core.body import MachineShape
from ..core.entries import Pose
from ..core.fields import MachineFields, keys_of_set
from ..core.recorder import Figure, Scene
from ..core.rules import Notice, RuleSet
from ..machines.kinds import machines_on
from ..safety.laws import OwnLaw

LARGEST_OF_ALL = 1e30
"""Maximum of all numbers of a run, including coefficients and seeds."""


def parse_json(text: str) -> Any:
    """Return the value in `text`. `ValueError` if it is no JSON or contains a larger number."""
    value = from_json(text, allow_inf_nan=False)
    require_figures(value, LARGEST_OF_ALL)
    return value


def require_figures(value: Any, most: float) -> None:
    """Raise `UserError` if a number in `value`, or nested in it, exceeds ±`most`."""
    if isinstance(value, dict):
        value = [*value.values()]
    if isinstance(value, list):
        for inner in value:
            require_figures(inner, most)
    elif isinstance(value, int | float) and not abs(value) <= most:
        raise UserError(f"a number is larger than {most:g}")


FORMAT = "floorwalker-scene/1"
"""Value of `format` that identifies the file."""

_LATER = r"floorwalker-scene/([2-9]|[1-9]\d+)"

OPTIONAL = (
    *LEFT_OUT_IF_EMPTY,
    "one_way",
    "passing",
    "controller",
    "between_people",
    "reactions",
    "outline",
    "fields",
)
"""Fields of floors, scenes and rule sets that are omitted if they are empty."""

_LAWS = {
    law.__name__: law for law in (SeparationLaw, IntegralLaw, ApproachLaw, FixedDistance, Scaled)
}


class SceneError(UserError):
    """Error of a text that is not a scene."""


@dataclass(frozen=True)
class ForeignLaw:
    """Custom law that a recording names. Its distances are unknown."""

    name: str

    def distance(self, human_speed: float, robot_speed: float) -> float:
        """Raise `SceneError`, because the distance is unknown."""
        raise SceneError(
            f"the recording was made with a law of its own, {self.name}, which it does not hold;"
            " use the trial instead of the recording"
        )


class _SceneFile(BaseModel):
    model_config = ConfigDict(arbitrary_types_allowed=True, allow_inf_nan=False, defer_build=True)

    trial: str
    seed: int
    floorplan: Floorplan
    rules: dict[str, Any]
    people: tuple[Figure, ...]
    starts: dict[str, Pose]
    machines: tuple[MachineShape, ...] | None = None
    passing: tuple[Obstacle, ...] = ()
    controller: str = ""
    fields: dict[str, MachineFields] = {}


def write_scene(scene: Scene) -> str:
    """Return the scene as JSON, with a line end."""
    data = {"format": FORMAT, **_plain(scene)}
    return json.dumps(data, ensure_ascii=False, allow_nan=False, separators=(",", ":")) + "\n"


def read_scene(text: str, later: Callable[[str], None] | None = None) -> Scene:
    """Return the scene in `text`, or raise `SceneError`.

    With `later`, a scene of a later version is accepted without its unknown fields, and `later` is
    called with a sentence about it.
    """
    try:
        data = parse_json(text)
    except ValueError as why:
        raise SceneError(f"is not JSON: {why}") from None
    figures = data.items() if isinstance(data, dict) else ()
    try:
        require_figures([value for key, value in figures if key != "seed"], LARGEST)
    except UserError as why:
        raise SceneError(str(why)) from None
    data = _with_polygons(data)
    form = data.get("format") if isinstance(data, dict) else None
    if form != FORMAT:
        if later is None or not re.fullmatch(_LATER, str(form)):
            raise SceneError(f"expected the format {FORMAT!r}, found {form!r}")
        later(f"made in the later format {form}; what this version knows of it is shown")
    try:
        # The fields by their names in Python. Keys of files may have others.
        extra: Literal["ignore"] | None = None if form == FORMAT else "ignore"
        scene = _SceneFile.model_validate(
            data, by_alias=False, by_name=True, extra=extra, context={BY_FIELDS: True}
        )
    except ValidationError as misfits:
        first = misfits.errors()[0]
        place = ".".join(str(part) for part in first["loc"])
        raise SceneError(f"{place}: {first['msg'][:1].lower()}{first['msg'][1:]}") from None
    for person in scene.people:
        if person.name not in scene.starts:
            raise SceneError(f"starts: no pose for {person.name!r}")
    return Scene(
        trial=scene.trial,
        seed=scene.seed,
        floorplan=scene.floorplan,
        rules=_rules(_known(scene.rules) if form != FORMAT else scene.rules),
        people=scene.people,
        starts=scene.starts,
        machines=machines_on(scene.floorplan) if scene.machines is None else scene.machines,
        passing=scene.passing,
        controller=scene.controller,
        fields=scene.fields,
    )


def _plain(value: Any) -> Any:
    """Return `value` in the form for JSON."""
    if isinstance(value, Polygon):
        return mapping(value)
    if hasattr(value, "distance") or hasattr(value, "required"):
        kind = type(value)
        if _LAWS.get(kind.__name__) is kind:
            return {"form": kind.__name__, **_fields(value)}
        own = isinstance(value, OwnLaw)
        return {"form": value.name if own else f"{kind.__module__}:{kind.__qualname__}"}
    if isinstance(value, FieldSet):
        return keys_of_set(value)
    if is_dataclass(value):
        return _fields(value)
    if isinstance(value, dict):
        return {key: _plain(inner) for key, inner in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(inner) for inner in value]
    return "inf" if value == math.inf else value


def _fields(value: Any) -> dict[str, Any]:
    """Return the fields of a value without empty optional ones and notices of a floor."""
    left_out = {"notices"} if isinstance(value, Floorplan) else set()
    if isinstance(value, Floorplan | Scene | RuleSet | MachineShape):
        left_out |= {name for name in OPTIONAL if not getattr(value, name, True)}
    if isinstance(value, RuleSet) and value.between == "centres":
        left_out.add("between")
    names = (field.name for field in fields(value) if field.name not in left_out)
    return {name: _plain(getattr(value, name)) for name in names}


def _with_polygons(data: Any, *place: str | int) -> Any:
    """Return the data at a place in the scene with GeoJSON converted to polygons."""
    if isinstance(data, list):
        return [_with_polygons(inner, *place, k) for k, inner in enumerate(data)]
    if not isinstance(data, dict):
        return data
    if data.get("type") != "Polygon":
        return {key: _with_polygons(inner, *place, key) for key, inner in data.items()}
    try:
        with np.errstate(invalid="ignore"):  # reported below
            polygon = shape(data)
    except (LookupError, OverflowError, TypeError, ValueError, GEOSException) as why:
        raise SceneError(f"{field_name(place)}: invalid polygon: {why}") from None
    if fault := polygon_fault(polygon):
        raise SceneError(f"{field_name(place)}: {fault}")
    return polygon


def _known(rules: dict[str, Any]) -> dict[str, Any]:
    """Return the fields of rules that this version has."""
    names = {field.name for field in fields(RuleSet)}
    return {name: value for name, value in rules.items() if name in names}


def _rules(data: dict[str, Any]) -> RuleSet:
    try:
        notice = Notice(**_terms(data["notice"]))
        laws = _terms(data.get("laws", {}))
        rules = RuleSet(**(_terms(data) | {"notice": notice, "laws": laws}))
    except (AttributeError, KeyError, TypeError, ValueError) as why:
        raise SceneError(f"rules: {why}") from None
    all_laws = (rules.gantry_law, rules.agv_law, notice.law, *laws.values())
    if not (isinstance(notice.law, Scaled) and all(map(_is_law, all_laws))):
        raise SceneError("rules: invalid law")
    return rules


def _is_law(law: object) -> bool:
    if isinstance(law, Scaled):
        return _is_law(law.law)
    return isinstance(law, (ForeignLaw, *_LAWS.values()))


def _terms(data: dict[str, Any]) -> dict[str, Any]:
    """Return the values of `data` with forms converted to laws."""
    return {key: _term(value) for key, value in data.items()}


def _term(value: Any) -> Any:
    if isinstance(value, dict) and "form" in value:
        terms = dict(value)
        form = terms.pop("form")
        return _LAWS[form](**_terms(terms)) if form in _LAWS else ForeignLaw(form)
    return math.inf if value == "inf" else value
