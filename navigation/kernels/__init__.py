"""Hot loops over tables of numbers, compiled where the installation found a compiler.

Each module here is Python that runs as it is, and that Cython compiles in its pure Python mode to
the same results, to the last bit: no fused multiplications, `sqrt(x * x + y * y)` instead of
`hypot` (of which C's and Python's differ). What they compute is offered by the modules above.
"""

from . import encounter

COMPILED = not encounter.__file__.endswith(".py")
"""Whether the kernels are compiled."""
