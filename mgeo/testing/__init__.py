"""Checks that any plugin can run on itself: they need nothing but what `mgeo` needs."""

from mgeo.testing.algorithm import check_algorithm
from mgeo.testing.check import CheckError
from mgeo.testing.problem import check_problem

__all__ = [
    "CheckError",
    "check_algorithm",
    "check_problem",
]
