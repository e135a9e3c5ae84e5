"""What the kernels name `cython` where they are not compiled.

Importing Cython itself would take longer than all else here, and it need not be installed.
"""

compiled = False
