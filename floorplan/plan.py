"""Floorplans: floors that can be saved."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from .checks import check
from .document import MOST_TEXT
from .map_writing import FINEST, USUAL, write_map
from .model import Floor
from .problems import UserError
from .writing import TEXTS


@dataclass(frozen=True, repr=False)
class Floorplan(Floor):
    """A floor: its boundary and what stands on it. Compare with `==`, share freely.

    Fields are those of `Floor`: obstacles, stations and lanes are tuples that also answer to
    names: `stations["dock"]`. `patrol` names the stations that people go to, in their order; None
    stands for all of them. `notices` are what was left out of the drawing it was read from, or
    taken for granted there.
    """

    def save(self, path: str | Path, *, resolution: float | None = None) -> None:
        """Write the floor to the file at `path`, in the format that its suffix says.

        Only Floorwalker's own (.yaml, .yml) holds all of it. GeoJSON (.geojson, .json) has no
        machines, no patrol and no measures of people; WKT (.wkt) is only the area that people can
        walk on. A ROS map (.pgm, with its .yaml beside it; or .yaml with a `resolution`) is this
        area in cells of `resolution` metres, 0.05 by default: a cell is free if all of it is.

        `FloorplanError` if the floor is not sound, `ValueError` for another suffix, for a YAML
        file too long to be read, or where people could walk nowhere, or in too many cells;
        `OSError` says why it can't be written.
        """
        check(self)
        path = Path(path)
        suffix = path.suffix.lower()
        is_map = suffix == ".pgm" or (suffix in (".yaml", ".yml") and resolution is not None)
        if resolution is not None and not (is_map and resolution >= FINEST):
            reason = f"a ROS map (.pgm, .yaml), of at least {FINEST:g} m"
            raise UserError(f"{path}: a resolution belongs to {reason}")
        if is_map:
            write_map(self, path, USUAL if resolution is None else resolution)
            return
        if suffix not in TEXTS:
            known = ", ".join((*TEXTS, ".pgm"))
            raise UserError(f"{path}: a floor can be written to files that end in one of {known}")
        text = TEXTS[suffix](self)
        if suffix in (".yaml", ".yml") and len(text) > MOST_TEXT:
            reason = f"{len(text):,} characters, and one of more than {MOST_TEXT:,} can't be read"
            raise UserError(f"{path}: the floor would take {reason}; .geojson holds its shapes")
        path.write_text(text, encoding="utf-8", newline="\n")

    def to_yaml(self) -> str:
        """Return the text of a file in Floorwalker's own format that holds this floor."""
        check(self)
        return TEXTS[".yaml"](self)
