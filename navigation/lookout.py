"""Until when a machine may follow a motion and still stop for people, whatever they do."""

from __future__ import annotations

from .conditions import ROUNDING
from .kernels import lookout as kernel
from .monitor import RESOLUTION
from .separation import AnyLaw, kernel_of


class Lookout(kernel.Lookout):
    """The test for a machine to which `law` applies; `margin` metres are kept in addition."""

    def __init__(self, law: AnyLaw, margin: float) -> None:
        super().__init__(kernel_of(law), margin, ROUNDING, RESOLUTION)
