"""Which attitude sensors to fly, chosen together with how to calibrate them, as a pymoo problem."""

from importlib.metadata import version

from mgeo_suite.catalog import Catalog
from mgeo_suite.problem import SensorSuiteProblem

__version__ = version("mgeo-suite")

__all__ = ["Catalog", "SensorSuiteProblem"]
