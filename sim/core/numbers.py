"""Numbers in files and events of the user's own."""

from __future__ import annotations

import math
import sys
from typing import Any


def is_number(value: Any) -> bool:
    """Return whether `value` is a finite number, and not true or false."""
    number = isinstance(value, int | float) and not isinstance(value, bool)
    return number and abs(value) <= sys.float_info.max


def times_until(end: float, begin: float, every: float | None) -> int:
    """Return how often something is there until `end` being there at `begin` and `every` so often.

    All are seconds. It is there at least once, and only once where a figure can't be.
    """
    found = (end - begin) / every if every else 0.0
    return max(1, math.ceil(found)) if math.isfinite(found) else 1
