"""Compile the kernels if there is a compiler. Without one, their Python sources run.

All other metadata of the distribution is in `pyproject.toml`.
"""

import os
from pathlib import Path

from Cython.Build import cythonize
from setuptools import setup

ROOT = Path(__file__).parent
MODULES = sorted(
    str(module.relative_to(ROOT))
    for package in ("floorplan", "navigation", "bdi", "sim")
    for module in (ROOT / package).glob("**/kernels/*.py")
    if module.with_suffix(".pxd").exists() and module.name not in ("tables.py", "cubics.py")
)
OPTIMISED = () if "-O" in os.environ.get("CFLAGS", "") else ("-O2",)

extensions = cythonize(
    MODULES,
    build_dir="build",
    compiler_directives={
        "language_level": 3,
        "boundscheck": False,
        "wraparound": False,
        "cdivision": True,
        "initializedcheck": False,
        # Both are unused, and together are a quarter of the compiler's input.
        "auto_pickle": False,
        "binding": False,
    },
)
for extension in extensions:
    extension.optional = True  # cythonize leaves this out
    if os.name == "posix":
        # A multiplication and an addition in one instruction would have other last bits, and so
        # would one call for sine and cosine.
        same_bits = ("-ffp-contract=off", "-fno-builtin-sin", "-fno-builtin-cos")
        extension.extra_compile_args += [*OPTIMISED, "-g0", *same_bits]

setup(ext_modules=extensions, options={"build_ext": {"parallel": os.cpu_count() or 1}})
