"""Telemetry: what a satellite has reported, its files, columns, units and frames."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
