"""As for plans, promises are looked at in few flights."""

from ..attitude.conftest import few_flights

__all__ = ["few_flights"]
