"""Robust searches and promises over few flights, which take longest, where code is only tried.

Every kernel begins with it (``PYTHONSTARTUP``), and so does every command of `terminal`.
"""

from typing import Any as _Any

import mgeo_attitude.problem as _problem
from mgeo_attitude.view.plans import Plans as _Plans

_kept = _Plans._kept


def _of_few(plans: _Any, flights: int = 200, *given: _Any, **options: _Any) -> _Any:
    return _kept(plans, min(flights, 20), *given, **options)


_Plans._kept = _of_few  # type: ignore[method-assign]
_problem._FLIGHTS = 16
