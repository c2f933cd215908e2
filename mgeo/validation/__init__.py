"""Checks of what a user passes in: each error names the value, what was expected, and where.

`arguments` are those of functions and constructors, `tables` what files hold, checked by pydantic.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
