"""Inner loops over tables of numbers, compiled if the installation has a compiler.

Each module is Python. Cython compiles it with the types in the `.pxd` of the same name. Results are
the same to the last bit, without fused multiplications, and with `norm` instead of `hypot`, which
differs between C and Python. Tables are rows of structs by value, and `cubics` has the mathematics
of motions. Other packages use the modules above.
"""

from . import encounter

COMPILED = not encounter.__file__.endswith(".py")
"""Whether the kernels are compiled."""
