"""Interface of conditions on the motions of two bodies."""

from __future__ import annotations

from typing import Protocol

from .kernels.encounter import Encounter


class Condition(Protocol):
    """Interface of conditions on the motions of a person and a machine.

    Conditions combine as `~condition` and `condition & other`.
    """

    def holds(self, encounter: Encounter, begin: float, end: float) -> bool | None:
        """Evaluate the condition over an interval.

        Parameters
        ----------
        encounter : Encounter
            Bounds on the two motions.
        begin, end : float
            Interval within the encounter in seconds.

        Returns
        -------
        bool or None
            True if the condition holds throughout, False if it holds nowhere, None if undecided. It
            must be decided if `begin` equals `end`.
        """
        ...
