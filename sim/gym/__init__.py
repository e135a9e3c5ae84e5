"""Environments of gymnasium and PettingZoo in which policies drive machines among people."""

import lazy_loader

# Gymnasium imports this package for its registration while it is itself being imported.
__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
