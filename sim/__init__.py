"""Trials, their simulation, the referee, and the results of a run.

Names are imported when they are first used, so that the command answers `--help` without
loading planners and geometry. They are listed in `__init__.pyi`.
"""

from importlib.util import find_spec
from pathlib import Path

import lazy_loader

for _name in ("floorplan", "navigation", "bdi"):
    _spec = find_spec(_name)
    _place = "" if _spec is None else [*(_spec.submodule_search_locations or ()), _spec.origin][0]
    if _place and Path(_place).resolve().parent != Path(__file__).resolve().parents[1]:
        raise ImportError(
            f"{_place} hides Floorwalker's package {_name}: rename it, or start Python elsewhere"
        )

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
