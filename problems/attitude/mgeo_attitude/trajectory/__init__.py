"""A plan as a whole, to the end of its run or until the satellite is back at its attitude law."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
