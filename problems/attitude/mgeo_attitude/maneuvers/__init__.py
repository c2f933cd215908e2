"""What a plan's turns are: designs as rates over time, ramps between them, and phases for people.

Nothing here knows of a filter; `filter` runs along a `Schedule`.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
