"""What plans need of a problem; `AttitudeManeuverProblem` is one."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol

from mgeo_attitude._typing import Floats
from mgeo_attitude.bound import LimitCurves
from mgeo_attitude.criteria.robustness import FlightSamples
from mgeo_attitude.environment import Environment
from mgeo_attitude.filter.model import FilterModel
from mgeo_attitude.filter.start_times import StartTimes
from mgeo_attitude.scenario import FlightErrors, Scenario

if TYPE_CHECKING:
    from mgeo_attitude.filter.evaluator import Evaluation


class ManeuverProblem(Protocol):
    """A problem whose designs are maneuvers of one scenario."""

    scenario: Scenario
    threads: int | None
    objectives: tuple[str, ...]
    n_var: int
    n_obj: int
    n_ieq_constr: int

    obj_names: tuple[str, ...]

    def run(self, X: Floats, vary: Any = None, **asked: Any) -> Evaluation: ...
    def begun(self, x: Any) -> tuple[ManeuverProblem, Floats]: ...
    def flights_of(self, errors: FlightErrors) -> FlightSamples: ...
    def valued(self, model: FilterModel, result: Evaluation) -> Floats: ...
    def judged(self, X: Floats) -> Floats: ...
    def view(self, X: Any) -> Any: ...
    @property
    def environment(self) -> Environment: ...
    @property
    def model(self) -> FilterModel: ...
    @property
    def limit_curves(self) -> LimitCurves: ...
    @property
    def start_times(self) -> StartTimes | None: ...
    @property
    def flights(self) -> FlightSamples | None: ...
