"""Checks that any plugin can run on itself: they need nothing but what `mgeo` needs."""

from mgeo.testing.algorithm import check_algorithm
from mgeo.testing.problem import CheckError, check_problem

__all__ = [
    "CheckError",
    "check_algorithm",
    "check_problem",
]
