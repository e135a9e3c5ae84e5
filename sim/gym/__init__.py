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

# A gantry has no laser scanner, unless `rays` asks for one.
for _name, _keys in (("Amr", {}), ("Gantry", {"rays": 0})):
    gymnasium.register(
        f"floorwalker/{_name}-v0",
        "sim.gym:FloorEnv",
        kwargs={"trial": str(FOLDER / f"{_name.lower()}.study.yaml"), **_keys},
    )
