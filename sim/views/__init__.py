"""Pictures and pages of a run."""

from . import plots

__all__ = ["plots"]
