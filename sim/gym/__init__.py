"""Environments of gymnasium and PettingZoo in which policies drive machines among people."""

from .environment import FloorEnv, Step, usual_reward
from ..machines.policy import Interface

__all__ = ["FloorEnv", "Interface", "Step", "register_envs", "usual_reward"]


def register_envs() -> None:
    """Register the environments with gymnasium, which calls this when it is imported."""
    from gymnasium import register

    from .environment import FOLDER

    for name in ("Amr", "Gantry"):
        trial = FOLDER / f"{name.lower()}.study.yaml"
        register(f"{name}-v0", "sim.gym:FloorEnv", kwargs={"trial": trial})
