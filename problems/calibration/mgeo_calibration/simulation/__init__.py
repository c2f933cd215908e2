"""Flights by the hundred: the error-state filter on board, what it claims, and calibrations."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
