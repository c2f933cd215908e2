"""A real run of mgeo, if a short one, for tests of what is made from run folders."""

from mgeo.runs import prepare
from mgeo.store import Run, installed_versions


def small_run(problem):
    """A front of a problem after three generations."""
    made = prepare("attitude", problem.options(), evaluations=1_080)
    return Run(made.configuration, made.solve(), installed_versions("attitude"))
