"""What tables and figures need of a problem; `SensorSuiteProblem` is one."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from mgeo_attitude import Scenario
from mgeo_attitude._typing import Floats, Ints
from numpy.typing import ArrayLike

from mgeo_suite.suites import SuiteModels

if TYPE_CHECKING:
    from mgeo_attitude import Evaluation


class SuiteProblem(Protocol):
    """A problem whose designs are a suite of sensors each, and maneuvers of one scenario."""

    scenario: Scenario
    suites: SuiteModels
    objectives: tuple[str, ...]

    def numbers(self, X: ArrayLike) -> Floats: ...
    def split(self, X: ArrayLike) -> tuple[Ints, Floats]: ...
    def evaluation(self, X: ArrayLike, history: bool = False) -> Evaluation: ...
