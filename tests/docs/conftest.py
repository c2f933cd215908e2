"""Pages show robust times over few Monte Carlo runs here, as the tests of plans do."""

from ..attitude.conftest import few_flights

__all__ = ["few_flights"]
