"""Problems and commands of others.

`discovery` finds them and says what a plugin may bring, `problems` builds a problem by its name,
`view` is what people are shown of its solutions, `protocol` and `shown` check what a problem and
its view give when they are asked, `checks` are for authors.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from mgeo.plugins.view import View, view_of

__all__ = ["View", "view_of"]


def __getattr__(name: str) -> Any:
    # names of plugins are told without pymoo, which this needs
    if name in __all__:
        return getattr(import_module("mgeo.plugins.view"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
