"""Checks that any plugin can run on itself: they need nothing but what `mgeo` needs."""

from mgeo.plugins.checks import CheckError, check_algorithm, check_problem

__all__ = ["CheckError", "check_algorithm", "check_problem"]
