"""Floorplans: the floor, and what stands on it.

Names are imported when they are first used, from the modules in `__init__.pyi`.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
