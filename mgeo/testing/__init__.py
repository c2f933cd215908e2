"""Checks that any plugin can run on itself: they need nothing but what `mgeo` needs."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
