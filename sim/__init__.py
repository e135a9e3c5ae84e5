"""What happens: trials, their simulation, the referee, and what is left of a run.

Names are imported when they are first used, so that the command answers `--help` without
loading planners and geometry. They are listed in `__init__.pyi`.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
