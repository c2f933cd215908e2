"""Checks of problems and algorithms, to be called from the tests of a plugin.

The checks have no dependencies beyond those of `mgeo`.
"""

from mgeo.testing.algorithm import check_algorithm
from mgeo.testing.check import CheckError
from mgeo.testing.problem import check_problem

__all__ = [
    "CheckError",
    "check_algorithm",
    "check_problem",
]
