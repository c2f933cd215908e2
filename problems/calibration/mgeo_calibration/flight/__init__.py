"""Flights: what is true of a plan that is flown, and what gyro and sensors report of it."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
