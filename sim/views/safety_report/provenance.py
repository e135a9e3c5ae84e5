"""Provenance of a report: versions of all that computes, and digests of all that was read."""

from __future__ import annotations

import platform
from collections.abc import Mapping
from importlib.metadata import PackageNotFoundError, version

from navigation.kernels import COMPILED

from .parts import Facts, Table

LIBRARIES = ("numpy", "shapely", "ompl", "python-fcl", "ruckig", "simpy")
"""Packages that figures may depend on in their last digits."""


def software() -> Facts:
    """Return what computed the figures."""
    kernels = "compiled" if COMPILED else "not compiled"
    return Facts(
        (
            ("Floorwalker", f"{_version('floorwalker')}, kernels {kernels}"),
            ("Python", f"{platform.python_version()} ({platform.python_implementation()})"),
            ("platform", f"{platform.system()} {platform.machine()}"),
            ("libraries", ", ".join(f"{name} {_version(name)}" for name in LIBRARIES)),
        ),
        "Software",
    )


def inputs(digests: Mapping[str, str]) -> Table:
    """Return the digests of what was read."""
    words = "The first 64 bits of SHA-256. Another digest is another input."
    return Table(("what", "digest"), [*digests.items()], "Inputs", words)


def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:  # built into the system
        return "unknown"
