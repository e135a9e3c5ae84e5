"""What is told about a trial that can't be run."""

from __future__ import annotations

from floorplan import InputError


class TrialError(InputError):
    """A trial that can't be run."""
