"""Memory of this process, as the system counts it."""

from __future__ import annotations

import math
import re
from pathlib import Path

_STATUS = Path("/proc/self/status")
_RESET = Path("/proc/self/clear_refs")

_PEAK = "5\n"
"""Sets the peak to what there is now, since Linux 4.0: see proc(5)."""


class PeakMemory:
    """Growth of the resident memory from when this is made to its peak; Linux alone tells it.

    What the allocator has kept from before is not counted again, so that the first answers of a
    process grow more than later ones.
    """

    def __init__(self) -> None:
        self._before = math.nan
        try:
            _RESET.write_text(_PEAK, encoding="ascii")
            self._before = _megabytes("VmRSS")
        except OSError:  # no Linux, or not allowed
            return

    def grown(self) -> float:
        """Return the growth in MB; NaN where the system does not tell."""
        if math.isnan(self._before):
            return math.nan
        return max(0.0, _megabytes("VmHWM") - self._before)


def _megabytes(field: str) -> float:
    found = re.search(rf"^{field}:\s+(\d+) kB", _STATUS.read_text(encoding="ascii"), re.M)
    return int(found[1]) / 1024 if found else math.nan
