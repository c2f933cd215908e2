"""Flights by Basilisk: rigid-body dynamics, reaction wheels and sensors that nobody here wrote.

Nothing of Basilisk is imported until something is flown, and nothing is ever downloaded.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
