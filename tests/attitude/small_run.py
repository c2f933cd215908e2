"""A real run of mgeo, if a short one, for tests of what is made from run folders."""

from mgeo.runs.prepare import prepare
from mgeo.store.provenance import installed_versions
from mgeo.store.run import Run


def small_run(problem):
    """A front of a problem after three generations."""
    made = prepare("attitude", problem.options(), evaluations=1_080)
    return Run(made.configuration, made.solve(), installed_versions("attitude"))
