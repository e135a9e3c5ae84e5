"""Notice about kernels that are not compiled."""

import multiprocessing
import sys
from functools import cache

from navigation.kernels import COMPILED

NOTICE = (
    "floorwalker: the kernels are not compiled, so that runs take 3 to 9 times longer. Install a C"
    " compiler and Python's headers (Debian: gcc and python3-dev), then run 'pip install -e .' in"
    " the checkout. Or install a wheel."
)


@cache
def notice_uncompiled() -> None:
    """Print the notice on stderr, once, but not in worker processes."""
    if not COMPILED and multiprocessing.current_process().name == "MainProcess":
        print(NOTICE, file=sys.stderr)
