"""Names of people and machines in topics, the same for all transports."""

from __future__ import annotations

import re

from ..machines.amr.amr import Amr
from ..simulation import Simulation


def prefix_of(simulation: Simulation, name: str) -> str:
    """Return the prefix of the topics of a body, empty for the only vehicle that drives freely."""
    free = [one for one, machine in simulation.machines.items() if isinstance(machine, Amr)]
    return "" if free == [name] else f"{plain(name)}/"


def plain(name: str) -> str:
    """Return a name as ROS allows it."""
    text = re.sub(r"\W", "_", name, flags=re.ASCII)
    return text if text[:1].isalpha() else f"body_{text}"
