"""Reduce the numbers of Monte Carlo runs, so that a short build of the site is fast.

Every kernel (``PYTHONSTARTUP``) and every command of `terminal` executes this file first.
"""

import mgeo_attitude.problem as _problem
from mgeo_attitude.view.plans import Plans as _Plans

_Plans.n_monte_carlo_runs = 20
_problem._N_RUNS = 16
