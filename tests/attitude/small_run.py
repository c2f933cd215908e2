"""Short runs of mgeo for tests of run folders and reports."""

from mgeo.runs.prepare import prepare_run
from mgeo.store.provenance import list_problem_versions
from mgeo.store.run import Run


def small_run(problem):
    """Return a run of about three generations, with its front."""
    made = prepare_run("attitude", problem.to_options(), evaluations=1_080)
    return Run(made.configuration, made.solve(), list_problem_versions("attitude"))
