"""What the kernels name `cython` where they are not compiled: decorators that do nothing.

Importing Cython itself would take longer than all else here, and it need not be installed.
"""

from collections.abc import Callable
from typing import TypeVar

T = TypeVar("T")

compiled = False


def cclass(decorated: T) -> T:
    """Return a class or function as it is."""
    return decorated


cfunc = ccall = final = inline = cclass


def exceptval(*_: object, **__: object) -> Callable[[T], T]:
    """Return a decorator that leaves a function as it is."""
    return cclass
