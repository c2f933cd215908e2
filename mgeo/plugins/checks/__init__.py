"""Checks that any plugin can run on itself: they need nothing but what `mgeo` needs."""

from mgeo.plugins.checks.algorithm import check_algorithm
from mgeo.plugins.checks.failure import CheckError
from mgeo.plugins.checks.problem import check_problem

__all__ = ["CheckError", "check_algorithm", "check_problem"]
