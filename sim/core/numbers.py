"""Numbers in files and events of the user's own."""

from __future__ import annotations

import sys
from typing import Any


def is_number(value: Any) -> bool:
    """Return whether `value` is a finite number, and not true or false."""
    number = isinstance(value, int | float) and not isinstance(value, bool)
    return number and abs(value) <= sys.float_info.max
