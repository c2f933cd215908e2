"""The satellite problem for pymoo: which maneuvers calibrate best, soonest."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from functools import cached_property
from typing import Any

import numpy as np
import pandas as pd
import plotly.graph_objects as go
from numpy.typing import ArrayLike, NDArray
from pymoo.core.problem import Problem

from . import describe, figures
from .environment import Environment
from .filter.evaluator import evaluate
from .filter.model import FilterModel
from .filter.timeline import VARIABLES_PER_MANEUVER
from .scenario import Scenario

Floats = NDArray[np.float64]


class AttitudeManeuverProblem(Problem):
    """Minimize time to converge and final trace over constant-rate maneuvers, equation (5).

    Variables are ωx, ωy, ωz [deg/s] and duration [s] of each maneuver in turn; objectives are
    t_end [s] and the trace of the filter's covariance then (rad², rad²/s² and dimensionless
    squares, weighted by the scenario's trace weights).

    Parameters
    ----------
    scenario : Scenario, optional
        Default: `Scenario.paper()`.
    n_maneuvers : int, optional
        Default: the scenario's ``maneuvers.count``.
    threads : int, optional
        Threads of one evaluation; default: the processors this process may use. The result does
        not depend on it.

    Raises
    ------
    TypeError, ValueError
        For a scenario of another type, or a count below one.
    """

    var_names: list[str]
    obj_names = ("t_end [s]", "trace [-]")

    def __init__(
        self,
        scenario: Scenario | None = None,
        n_maneuvers: int | None = None,
        threads: int | None = None,
    ) -> None:
        scenario = Scenario.paper() if scenario is None else scenario
        if not isinstance(scenario, Scenario):
            raise TypeError(
                f"scenario = {scenario!r}: expected a Scenario, such as Scenario.paper() or "
                "Scenario.from_toml('file.toml')"
            )
        if threads is not None and (not isinstance(threads, int) or threads < 1):
            raise ValueError(f"threads = {threads!r}: expected an integer >= 1, or None")
        if n_maneuvers is not None:
            limits = dataclasses.replace(scenario.maneuvers, count=n_maneuvers)
            scenario = dataclasses.replace(scenario, maneuvers=limits)
        self.scenario = scenario
        self.threads = threads
        limits = scenario.maneuvers
        rates = [limits.max_rate_deg_s] * 3
        super().__init__(
            n_var=VARIABLES_PER_MANEUVER * limits.count,
            n_obj=2,
            xl=np.tile([*(-rate for rate in rates), 0.0], limits.count),
            xu=np.tile([*rates, limits.max_duration], limits.count),
            vtype=float,
        )
        self.var_names = [
            f"{name}_{m} [{unit}]"
            for m in range(1, limits.count + 1)
            for name, unit in (
                ("omega_x", "deg/s"),
                ("omega_y", "deg/s"),
                ("omega_z", "deg/s"),
                ("duration", "s"),
            )
        ]

    @cached_property
    def environment(self) -> Environment:
        """Orbit, Sun, field and shadow of the scenario; computed once, when first needed."""
        return Environment.from_scenario(self.scenario)

    @cached_property
    def model(self) -> FilterModel:
        """Tables of the filter; computed once, when first needed."""
        return FilterModel.from_scenario(self.scenario, self.environment)

    def _evaluate(self, X: Floats, out: dict[str, Any], *args: Any, **kwargs: Any) -> None:
        result = evaluate(self.model, X, self.threads)
        out["F"] = np.column_stack([result.t_end, result.trace])

    @classmethod
    def from_options(cls, options: Mapping[str, Any]) -> AttitudeManeuverProblem:
        """Build it from a scenario as nested dicts, see `Scenario.from_dict`; {} is the paper's."""
        return cls(Scenario.from_dict(options) if options else None)

    def options(self) -> dict[str, Any]:
        """The scenario as nested dicts of JSON's types, see `Scenario.to_dict`."""
        return self.scenario.to_dict()

    def indicator_space(self, F: ArrayLike) -> Floats:
        """Objectives as indicators see them: t_end / duration and (log10 trace + 6) / 5.

        With the paper's preset the reference point (1, 1) holds every solution worth having.

        Parameters
        ----------
        F : array_like, shape (n, 2)

        Returns
        -------
        array, shape (n, 2)
        """
        t_end, trace = np.atleast_2d(np.asarray(F, dtype=float)).T
        return np.column_stack([t_end / self.scenario.duration, (np.log10(trace) + 6.0) / 5.0])

    def describe(self, X: ArrayLike) -> pd.DataFrame:
        """Each solution, one row, in an engineer's terms."""
        return describe.describe(self, np.atleast_2d(np.asarray(X, dtype=float)))

    def front_summary(self, F: ArrayLike) -> dict[str, float]:
        """How many points of a front converge in the first orbit, and how many later."""
        return describe.front_summary(self.scenario, np.atleast_2d(np.asarray(F, dtype=float)))

    def figures(self, X: ArrayLike) -> dict[str, go.Figure]:
        """Interactive figures of a set of solutions; ``front`` is the picture of the front."""
        return figures.figures(self, np.atleast_2d(np.asarray(X, dtype=float)))
