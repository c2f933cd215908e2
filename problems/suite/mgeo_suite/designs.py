"""Suites with their plans, evaluated once for all that is told of them."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Protocol

from mgeo_attitude import Scenario
from mgeo_attitude._typing import Floats, Ints
from numpy.typing import ArrayLike

from mgeo.plugins.view import View
from mgeo_suite.suites import SuiteModels

if TYPE_CHECKING:
    from mgeo_attitude import Evaluation


class SuiteProblem(Protocol):
    """A problem whose designs are a suite of sensors each, and maneuvers of one scenario."""

    scenario: Scenario
    suites: SuiteModels
    objectives: tuple[str, ...]

    def split(self, X: ArrayLike) -> tuple[Ints, Floats]: ...
    def evaluation(self, X: ArrayLike, history: bool = False) -> Evaluation: ...


class Designs(View):
    """Designs, shape (n, n_var), and what their evaluation gives, each when first asked for."""

    problem: SuiteProblem

    @cached_property
    def choices(self) -> Ints:
        """Numbers of options, shape (n, n_places)."""
        return self.problem.split(self.X)[0]

    @cached_property
    def maneuvers(self) -> Floats:
        """Shape (n, 4 m)."""
        return self.problem.split(self.X)[1]

    @cached_property
    def resources(self) -> Floats:
        """Price [kEUR], mass [g] and power [mW], shape (n, 3)."""
        return self.problem.suites.resources(self.choices)

    @cached_property
    def result(self) -> Evaluation:
        """Filter runs."""
        return self.problem.evaluation(self.X)
