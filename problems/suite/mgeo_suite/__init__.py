"""Which attitude sensors to fly, chosen together with how to calibrate them, as a pymoo problem."""

from mgeo_suite.catalog import Catalog
from mgeo_suite.problem import SensorSuiteProblem

__version__ = "0.1.0"

__all__ = ["Catalog", "SensorSuiteProblem"]
