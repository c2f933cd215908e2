"""A plan as an artefact: picked from a front, looked at, written, read back and flown."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
