"""A run as one HTML file to attach to a review: what was run, the front, and each of its plans."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
