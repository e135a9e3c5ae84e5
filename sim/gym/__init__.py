"""Environments of gymnasium and PettingZoo in which policies drive machines among people."""

try:
    import gymnasium
    import pettingzoo  # noqa: F401
except ImportError as why:
    message = f"sim.gym needs {why.name}: pip install 'floorwalker[gym]'"
    raise ImportError(message, name=why.name) from None

from ..machines.policy import Interface
from .environment import FOLDER, FloorEnv, Transition, usual_reward
from .parallel import ParallelFloorEnv

__all__ = ["FloorEnv", "Interface", "ParallelFloorEnv", "Transition", "usual_reward"]

for _name in ("Amr", "Gantry"):
    gymnasium.register(
        f"floorwalker/{_name}-v0",
        "sim.gym:FloorEnv",
        kwargs={"trial": str(FOLDER / f"{_name.lower()}.study.yaml")},
    )
