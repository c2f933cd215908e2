"""What a plan teaches the filter, what it leaves unknown, and what simpler plans would do."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
