"""Floorplans, and how they are written in Floorwalker's own format."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import shapely
from shapely.geometry import Polygon

from .checks import check
from .files.dataclass import dataclass
from .files.documents import MOST_TEXT, yaml_text
from .files.footprints import ring_keys
from .files.forms import Data, plain, written
from .files.problems import UserError
from .formats import OF_SUFFIX, ROS_MAP, WRITTEN, YAML, function
from .model import OF_ONE_LANE, Floor, Lane


def floor_keys(plan: Floor) -> Data:
    """Return the keys of `plan` in Floorwalker's own format."""
    zone = plan.safe_zone
    data: Data = {
        "name": plan.name,
        "title": plan.title,
        "source": plan.source,
        "boundary": ring_keys(plan.boundary.exterior),
        "holes": [ring_keys(ring) for ring in plan.boundary.interiors],
        "human": written(plan.human),
        "safe_zone": None if zone is None else written(zone),
        "stations": {one.name: plain(one.position) for one in plan.stations},
        "patrol": None if plan.patrol is None else [*plan.patrol],
        "obstacles": {one.name: written(one) for one in plan.obstacles},
        "agvs": _agvs(plan.lanes) if plan.lanes else None,
        "gantry": None if plan.gantry is None else written(plan.gantry, every=True),
        "doors": {door.name: written(door, every=True) for door in plan.doors},
        "zones": {one.name: written(one) for one in plan.zones},
        "gates": {gate.name: written(gate) for gate in plan.gates},
    }
    # By default the patrol has all stations, so that an empty patrol must be written.
    return {
        key: value
        for key, value in data.items()
        if key == "name" or value not in (None, "", [], {}) or (key == "patrol" and value == [])
    }


def write_yaml(plan: Floor, path: Path) -> None:
    """Write `plan` to `path` in Floorwalker's own format. `UserError` if it is too long."""
    text = yaml_text(floor_keys(plan))
    if len(text) > MOST_TEXT:
        reason = f"{len(text):,} characters, and one of more than {MOST_TEXT:,} can't be read"
        raise UserError(f"{path}: the floor would take {reason}; .geojson holds its shapes")
    path.write_text(text, encoding="utf-8", newline="\n")


def _agvs(lanes: Sequence[Lane]) -> Data:
    """Return the keys that all AGVs share, taken from the first, and the keys of each."""
    keys = {lane.name: written(lane, every=True) for lane in lanes}
    shared = {key: value for key, value in keys[lanes[0].name].items() if key not in OF_ONE_LANE}
    own = {
        name: {
            key: value
            for key, value in of_lane.items()
            if key in ("origin", "heading") or value not in ({}, shared.get(key))
        }
        for name, of_lane in keys.items()
    }
    return {**shared, "lanes": own}


def _svg_path(polygons: list[Polygon], colour: str, fine: float) -> str:
    """Return the SVG path of polygons, simplified by at most `fine` metres."""
    lines = []
    for polygon in shapely.simplify(polygons, fine).tolist():
        for ring in (polygon.exterior, *polygon.interiors):
            corners = " ".join(f"{x:.6g},{y:.6g}" for x, y, *_ in ring.coords[:-1])
            lines.append(f"M{corners}Z")
    return f'<path fill="{colour}" fill-rule="evenodd" d="{"".join(lines)}"/>'


USUAL = 0.05
"""Metres. Default size of a cell."""

FINEST = 1e-4
"""Metres. Minimum size of a cell."""


@dataclass(frozen=True, repr=False, kw_only=True)
class Floorplan(Floor):
    """Floor with everything that stands on it, as an immutable value.

    Obstacles, stations, lanes, doors, zones and gates are tuples that also accept names, as in
    `stations["dock"]`. Floorplans are compared with `==`.

    Parameters
    ----------
    name : str
        Name.
    boundary : shapely.Polygon
        Outline of the floor in metres.
    obstacles : sequence of Obstacle, optional
        Obstacles.
    stations : sequence of Station, optional
        Stations.
    patrol : tuple of str, optional
        Names of the stations that people visit, in their order. By default all stations.
    safe_zone : SafeZone, optional
        Start of people.
    human : Human, optional
        Measures of people.
    lanes : sequence of Lane, optional
        Lanes of AGVs.
    gantry : Gantry, optional
        Overhead robot.
    doors : sequence of Door, optional
        Doors.
    zones : sequence of Zone, optional
        Zones.
    gates : sequence of Gate, optional
        One-way gates.
    title, source : str, optional
        Title, and origin of the data.
    notices : tuple of Problem, optional
        Parts of a drawing that were ignored or assumed.

    Examples
    --------
    >>> from shapely.geometry import box
    >>> from floorplan import Floorplan, Obstacle, Station
    >>> table = Obstacle(name="table", footprint=box(2, 2, 3, 3.5), bottom=0.0, top=1.0)
    >>> Floorplan(
    ...     name="cell",
    ...     boundary=box(0, 0, 10, 6),
    ...     obstacles=[table],
    ...     stations=[Station("press", (4.0, 1.0))],
    ... )
    <Floorplan 'cell': 10 x 6 m, 1 obstacles, 1 stations, 0 lanes>
    """

    def _repr_html_(self) -> str:
        """Return a small picture for notebooks."""
        from html import escape

        west, south, east, north = self.boundary.bounds
        size = max(east - west, north - south) or 1.0
        fine = size / 1000
        shapes = [
            _svg_path([self.boundary], "#fff", fine),
            _svg_path([zone.area for zone in self.zones], "#fdd", fine),
            _svg_path([obstacle.footprint for obstacle in self.obstacles], "#999", fine),
        ]
        for station in self.stations:
            x, y = station.position
            dot = f'<circle cx="{x:g}" cy="{y:g}" r="{8 * fine:g}" fill="#06c">'
            shapes.append(f"{dot}<title>{escape(station.name)}</title></circle>")
        box = f"{west - fine:g} {-north - fine:g} {east - west + 2 * fine:g}"
        box = f'viewBox="{box} {north - south + 2 * fine:g}" width="420" style="max-height:420px"'
        pen = f'transform="scale(1,-1)" stroke="#333" stroke-width="{fine:g}"'
        drawing = f"<svg {box}><g {pen}>{''.join(shapes)}</g></svg>"
        return f"<figure><figcaption>{escape(repr(self))}</figcaption>{drawing}</figure>"

    def save(self, path: str | Path, *, resolution: float | None = None) -> None:
        """Write the floorplan to a file.

        Only YAML (`.yaml`, `.yml`) holds all of it. GeoJSON (`.geojson`, `.json`) has no machines,
        no patrol and no measures of people. WKT (`.wkt`) and ROS maps (`.pgm` with `.yaml`) hold
        the area that people can walk on. A cell of a map is free if all of it is free.

        Parameters
        ----------
        path : str or pathlib.Path
            File to write. Its suffix determines the format.
        resolution : float, optional
            Side of a cell of a ROS map in metres, 0.05 by default. It makes a `.yaml` file a ROS
            map.

        Raises
        ------
        FloorplanError
            If the floorplan is not correct.
        UserError
            If the suffix is unknown, the result too large to be read, or if people can walk
            nowhere.
        OSError
            If the file cannot be written.
        """
        check(self)
        path = Path(path)
        form = OF_SUFFIX.get(path.suffix.lower())
        is_map = form is ROS_MAP or (form is YAML and resolution is not None)
        if resolution is not None and not (is_map and resolution >= FINEST):
            reason = f"a ROS map (.pgm, .yaml), of at least {FINEST:g} m"
            raise UserError(f"{path}: a resolution belongs to {reason}")
        if is_map:
            write_map = function(ROS_MAP.writer)
            write_map(self, path, USUAL if resolution is None else resolution)
        elif form is not None and form.writer:
            write = function(form.writer)
            write(self, path)
        else:
            suffixes = ", ".join(WRITTEN)
            raise UserError(
                f"{path}: a floor can be written to files that end in one of {suffixes}"
            )

    def to_yaml(self) -> str:
        """Return the floorplan as a text in the YAML format."""
        check(self)
        return yaml_text(floor_keys(self))
