"""What tables and figures need of a problem; `AttitudeManeuverProblem` is one."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol

from mgeo_attitude.bound import LimitCurves
from mgeo_attitude.criteria.robustness import Flights
from mgeo_attitude.environment import Environment
from mgeo_attitude.filter.model import FilterModel
from mgeo_attitude.scenario import Scenario

if TYPE_CHECKING:
    import pandas as pd


class ManeuverProblem(Protocol):
    """A problem whose designs are maneuvers of one scenario."""

    scenario: Scenario
    threads: int | None
    objectives: tuple[str, ...]
    n_var: int

    obj_names: tuple[str, ...]

    def evaluate(self, X: Any, *args: Any, **kwargs: Any) -> Any: ...
    def promises(self, X: Any) -> pd.DataFrame: ...
    @property
    def environment(self) -> Environment: ...
    @property
    def model(self) -> FilterModel: ...
    @property
    def limit_curves(self) -> LimitCurves: ...
    @property
    def flights(self) -> Flights | None: ...
