"""What happens: trials, their simulation, the referee, and what is left of a run.

Names are imported when they are first used, so that the command answers `--help` without
loading planners and geometry.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from . import public
    from .public import *  # noqa: F403
    from .views import plots as plots

    __all__ = []
    __all__ += public.__all__


def __getattr__(name: str) -> Any:
    if name == "plots":
        return import_module(".views.plots", __name__)
    if name == "__all__" or not name.startswith("__"):
        public = import_module(".public", __name__)
        if name in (*public.__all__, "__all__"):
            globals()[name] = getattr(public, name)
            return globals()[name]
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
