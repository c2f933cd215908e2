"""A real run of mgeo, if a short one, for tests of what is made from run folders."""

from mgeo.runs.prepare import prepare_run
from mgeo.store.provenance import list_problem_versions
from mgeo.store.run import Run


def small_run(problem):
    """A front of a problem after three generations."""
    made = prepare_run("attitude", problem.to_options(), evaluations=1_080)
    return Run(made.configuration, made.solve(), list_problem_versions("attitude"))
