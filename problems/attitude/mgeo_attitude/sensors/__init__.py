"""Gyro and sensors: their parameters, their error models, and their readings as arrays."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
