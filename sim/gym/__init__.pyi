from .environment import FloorEnv, Interface, Step, usual_reward
from .parallel import ParallelFloorEnv
from .registration import register_envs

__all__ = [
    "FloorEnv",
    "Interface",
    "ParallelFloorEnv",
    "Step",
    "register_envs",
    "usual_reward",
]
