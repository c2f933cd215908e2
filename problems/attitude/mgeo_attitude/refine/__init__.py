"""Plans made better without a global search: good starts, local polish, no unneeded maneuvers."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
