"""Replacement for the module `cython` in kernels that are not compiled.

Importing Cython takes long, and it need not be installed.
"""

compiled = False
