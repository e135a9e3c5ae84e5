"""Evasion: other paths and passing places."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence

from shapely.geometry import Polygon

from floorplan.files.dataclass import dataclass

from ...core.body import Machine
from ...core.entries import Pose


@dataclass(frozen=True, kw_only=True)
class Evasion:
    """Path on which a machine evades others.

    Parameters
    ----------
    aside : Pose or None
        Passing place of the machine: x and y in metres, rotation in radians. None if it has none.
    """

    aside: Pose | None = None


class Evading(Machine):
    """Base class of machines that can evade others. Other machines only wait."""

    @abstractmethod
    def evade(self, taken: Sequence[Polygon], courses: Sequence[Polygon]) -> Evasion | None:
        """Choose another path to the goal, or to a passing place first.

        Parameters
        ----------
        taken : sequence of Polygon
            Areas that other machines occupy now, in metres.
        courses : sequence of Polygon
            Areas that other machines cover on their paths.

        Returns
        -------
        Evasion or None
            None if the machine cannot.
        """

    @abstractmethod
    def make_way(self, taken: Sequence[Polygon], courses: Sequence[Polygon]) -> bool:
        """Move off the courses of other machines, if the machine has nothing to do.

        Parameters
        ----------
        taken, courses
            See `evade`.

        Returns
        -------
        bool
            Whether it moves.
        """

    def detour(self, taken: Sequence[Polygon], most: float) -> bool:
        """Choose another path to the goal around other machines.

        Parameters
        ----------
        taken : sequence of Polygon
            Areas that other machines occupy now, in metres.
        most : float
            Maximum additional time in seconds.

        Returns
        -------
        bool
            Whether there is one.
        """
        return False
