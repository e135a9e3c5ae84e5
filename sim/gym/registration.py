"""Registration of the environments with gymnasium."""

from pathlib import Path

FOLDER = Path(__file__).parent.parent / "data" / "gym"
"""Folder of the built-in studies."""


def register_envs() -> None:
    """Register the environments. Gymnasium calls this when it is imported."""
    from gymnasium.envs.registration import register  # gymnasium itself is not imported yet

    for name in ("Amr", "Gantry"):
        trial = str(FOLDER / f"{name.lower()}.study.yaml")
        register(f"{name}-v0", "sim.gym:FloorEnv", kwargs={"trial": trial})
