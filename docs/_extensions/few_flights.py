"""Robust searches and promises over few flights, which take longest, where code is only tried.

Every kernel begins with it (``PYTHONSTARTUP``), and so does every command of `terminal`.
"""

import mgeo_attitude.problem as _problem
from mgeo_attitude.view.plans import Plans as _Plans

_Plans.n_monte_carlo_runs = 20
_problem._N_RUNS = 16
