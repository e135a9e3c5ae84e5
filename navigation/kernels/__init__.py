"""Hot loops over tables of numbers, compiled where the installation found a compiler.

Each module here is Python that runs as it is. Cython compiles it, with the types that stand in the
`.pxd` beside it, to the same results, to the last bit: no fused multiplications, and `norm` instead
of `hypot`, of which C's and Python's differ. Tables are rows of structs by value, and `cubics` has
the mathematics of motions. What the kernels compute is offered by the modules above.
"""

from . import encounter

COMPILED = not encounter.__file__.endswith(".py")
"""Whether the kernels are compiled."""
