"""Maneuver plan: a design in a scenario, with the predicted accuracy and all analyses."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import cached_property, lru_cache

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike, NDArray
from pydantic.dataclasses import dataclass

from mgeo._text import format_duration
from mgeo_attitude._typing import Floats
from mgeo_attitude.environment.times import format_time_stamps
from mgeo_attitude.filter.history import FilterHistory, run_filter
from mgeo_attitude.geometry.quaternion import quaternions_from_matrices
from mgeo_attitude.lower_bound.samples import NoLowerBoundError
from mgeo_attitude.maneuvers.motion import Phase
from mgeo_attitude.maneuvers.schedule import build_hold_design
from mgeo_attitude.problem import AttitudeManeuverProblem
from mgeo_attitude.scenario.scenario import Scenario
from mgeo_attitude.sensors.suite import list_block_units
from mgeo_attitude.settings.base import Settings
from mgeo_attitude.settings.errors import InvalidValue
from mgeo_attitude.settings.types import DEG
from mgeo_attitude.trajectory.trajectory import SlewBack, Trajectory
from mgeo_attitude.view.maneuver_view import ManeuverView
from mgeo_attitude.view.observability import covariance, error_budget, improvements
from mgeo_attitude.view.overview import build_accuracy_table

#: Remaining share of an initial 1-sigma above which an error counts as not calibrated.
UNCALIBRATED_SHARE = 0.5


@dataclass(frozen=True)
class ManeuverPlan(Settings):
    """Sequence of calibration maneuvers in a scenario, with its predicted accuracy.

    A plan starts at the epoch of the scenario and ends when the filter has converged. With Monte
    Carlo runs, the last rate is held until the time at which the requested share of the runs has
    converged. A slew back to the initial attitude law follows if the scenario requests one.

    Plans are equal if their scenarios and designs are equal. Results are computed on first access.
    A plan may violate constraints of the scenario; see `list_violations`.

    Parameters
    ----------
    scenario : Scenario
    design : sequence of float
        ωx, ωy, ωz [deg/s] and duration [s] of each maneuver in turn. An empty design holds the
        initial rate.

    Raises
    ------
    InvalidValue
        (ValueError, TypeError) If the length of the design does not match the number of maneuvers,
        or if a value is outside the bounds of rates and durations.

    Examples
    --------
    >>> from mgeo_attitude import Scenario
    >>> from mgeo_attitude.plan import ManeuverPlan
    >>> design = [0.5, 0.3, -0.2, 400.0, -0.3, 0.6, 0.2, 500.0, 0.2, -0.4, 0.7, 600.0]
    >>> plan = ManeuverPlan(Scenario.paper(), design)
    >>> plan.t_end, plan.build_accuracy_table()["after"].head(3).round(3).to_list()  # deg
    (2337.0, [0.043, 0.046, 0.055])
    """

    scenario: Scenario
    """Scenario in which the plan is executed."""
    design: tuple[float, ...]
    """Body rates [deg/s] and duration [s] of each maneuver in turn."""

    def __post_init__(self) -> None:
        problem = self.problem
        hold_design = tuple(
            np.tile(
                build_hold_design(problem.model.initial_rate), self.scenario.maneuvers.count
            ).tolist()
        )
        if not self.design:
            object.__setattr__(self, "design", hold_design)
        # The initial rate of a tumbling satellite may exceed the bounds of maneuver rates.
        if self.design == hold_design:
            return
        if len(self.design) != problem.n_var:
            raise InvalidValue(
                "design",
                list(self.design),
                f"expected {problem.n_var} numbers, 4 for each of the scenario's "
                f"{self.scenario.maneuvers.count} maneuvers",
            )
        limits = zip(self.design, problem.xl, problem.xu, problem.var_names, strict=True)
        for i, (value, low, high, name) in enumerate(limits):
            if not low <= value <= high:
                raise InvalidValue(
                    f"design[{i}]", value, f"expected {low:g} to {high:g} for {name}"
                )

    @classmethod
    def from_design(
        cls, problem: AttitudeManeuverProblem, x: ArrayLike, F: Floats | None = None
    ) -> ManeuverPlan:
        """Construct a plan from a design vector of an optimization problem.

        The plan shares the problem's precomputed data, such as environment and filter model.

        Parameters
        ----------
        problem : AttitudeManeuverProblem
        x : array_like, shape (n_var,)
            Design vector.
        F : array, shape (n_obj,), optional
            Objectives of the design if they are available, for example from a run folder. They
            are then not evaluated again.

        Returns
        -------
        ManeuverPlan

        Raises
        ------
        ValueError, TypeError
            If the design is invalid, as in the constructor.
        """
        design = np.asarray(x, dtype=float)
        if design.ndim != 1:
            raise ValueError(f"x of shape {design.shape}: expected ({problem.n_var},)")
        plan = cls(problem.scenario, tuple(design.tolist()))
        plan.__dict__["problem"] = problem
        if F is not None:
            plan.view.F = np.array([F], dtype=float)
        return plan

    @cached_property
    def problem(self) -> AttitudeManeuverProblem:
        """Optimization problem that is defined by the scenario.

        Plans with equal scenarios share one problem.
        """
        return _build_problem(self.scenario)

    @cached_property
    def view(self) -> ManeuverView:
        """Tables, texts and figures of this plan, as a `ManeuverView`."""
        return self.problem.view([self.design])

    @cached_property
    def history(self) -> FilterHistory:
        """History of the filter covariance along the plan, in a run without random errors.

        The history is computed on first access.
        """
        return run_filter(self.problem.model, self.design)

    @property
    def t_end(self) -> float:
        """Convergence time of the filter in the nominal run [s].

        If the filter does not converge, the time is the duration of the scenario.

        Raises
        ------
        ValueError
            If the covariance loses positivity.
        """
        t_end = float(self.view.nominal.t_end[0])
        if math.isnan(t_end):
            raise ValueError(
                f"design {list(self.design)}: the covariance of the filter loses positivity"
            )
        return t_end

    @property
    def converged(self) -> bool:
        """True if the filter converges before the end of the scenario."""
        return self.t_end < self.problem.model.duration

    @property
    def trace(self) -> float:
        """Weighted trace of the filter covariance at the convergence time `t_end`."""
        return float(self.view.nominal.trace[0])

    @property
    def covariance(self) -> Floats:
        """Filter covariance at the convergence time `t_end`, shape (n_states, n_states), in the
        internal units of the filter.
        """
        covariance: Floats = self.view.nominal.covariance[0]
        return covariance

    @property
    def sigma(self) -> Floats:
        """Predicted 1-sigma of each state at `t_end`, shape (n_states,), in the internal units of
        the filter.

        With magnetorquers this is the root mean square over Monte Carlo runs; see `Plans.sigma`.
        """
        sigma: Floats = self.view.sigma[0]
        return sigma

    @property
    def attitude_sigma_deg(self) -> float:
        """Predicted 1-sigma of the attitude about the worst body axis at `t_end` [deg].

        See `sigma`.
        """
        return float(DEG.factor * self.sigma[:3].max())

    @property
    def summary(self) -> str:
        """Convergence time and predicted 1-sigmas of the plan in one line of text."""
        (summary,) = self.view.summaries()
        return summary

    def compare_with_monte_carlo(self) -> pd.DataFrame:
        """Compare each predicted objective with its 0.9-quantile over Monte Carlo runs.

        Returns
        -------
        DataFrame
            One row per objective. Columns: ``predicted``; ``Monte Carlo``, the 0.9-quantile over
            the runs; and their ratio ``Monte Carlo / predicted [-]``. See
            `Plans.compare_with_monte_carlo`.
        """
        values = self.view.compare_with_monte_carlo().to_numpy(float).reshape(-1, 3)
        names = pd.Index(self.problem.obj_names, name="objective")
        return pd.DataFrame(
            values, names, ["predicted", "Monte Carlo", "Monte Carlo / predicted [-]"]
        )

    @cached_property
    def hold_end(self) -> float:
        """Time until which the satellite keeps the rate of the last maneuver [s].

        The time is at least `t_end`; see `Plans.hold_end`.
        """
        (hold_end,) = self.view.hold_end
        return float(hold_end)

    @cached_property
    def trajectory(self) -> Trajectory:
        """Attitude trajectory of the satellite from the epoch to the end of the plan."""
        design = np.array(self.design)
        return Trajectory(self.scenario, self.problem.model, design, self.t_end, self.hold_end)

    @property
    def phases(self) -> tuple[Phase, ...]:
        """Phases of the plan in time order: maneuvers, ramps, constant-rate hold and slew back."""
        return self.trajectory.phases

    @property
    def _calibration_phases(self) -> list[Phase]:
        return [phase for phase in self.phases if phase.end <= self.t_end]

    @property
    def slew_back(self) -> SlewBack | None:
        """Slew after `hold_end` that returns the satellite to its initial attitude law.

        None if the scenario requests no slew back.
        """
        return self.trajectory.slew_back

    @property
    def duration(self) -> float:
        """Time from the epoch to the end of the plan, including the slew back [s]."""
        return self.trajectory.end

    @property
    def attitude(self) -> Floats:
        """Rotation matrices from GCRF to body axes at all filter steps, shape (n + 1, 3, 3)."""
        return self.trajectory.attitude

    def to_steps(self, times: ArrayLike) -> NDArray[np.int64]:
        """Convert times [s] to the indices of the nearest filter steps.

        Parameters
        ----------
        times : array_like
            Times after the epoch of the scenario [s].

        Returns
        -------
        array of int
        """
        return np.rint(np.asarray(times) / self.scenario.step).astype(np.int64)

    def describe_hold(self) -> list[str]:
        """Describe until when the last rate is held after `t_end`, in one line of text.

        The list is empty if the plan has no such hold.
        """
        if self.hold_end <= self.t_end:
            return []
        return [
            f"the filter has converged after {format_duration(self.t_end)} ({self.t_end:.6g} s) in "
            f"the nominal run; the last rate is held until {format_duration(self.hold_end)} "
            f"({self.hold_end:.6g} s) for runs that converge later"
        ]

    def build_timeline(self) -> pd.DataFrame:
        """Return the timeline of the plan as a table with one row per phase.

        The columns contain the start and end times, body rates, rotation angles and attitudes.

        Attitudes are quaternions of the rotation from GCRF to the body, with the scalar part last
        (see `quaternions_from_matrices`). The column ``rotation [deg]`` is the integral of the
        rate, not the angle between start and end attitude.
        """
        edges = np.array([*(phase.start for phase in self.phases), self.duration])
        texts = format_time_stamps(self.scenario.epoch, edges)
        q = quaternions_from_matrices(self.attitude[self.to_steps(edges)])
        rates = np.array([phase.rates_deg_s for phase in self.phases])
        columns: dict[str, object] = {
            "phase": [phase.label for phase in self.phases],
            "start [s]": edges[:-1],
            "end [s]": edges[1:],
            "duration [s]": np.diff(edges),
            "start UTC": texts[:-1],
            "end UTC": texts[1:],
        }
        columns |= {f"rate {axis} [deg/s]": rates[:, i] for i, axis in enumerate("xyz")}
        columns["rotation [deg]"] = [phase.rotation_deg for phase in self.phases]
        for name, values in (("start", q[:-1]), ("end", q[1:])):
            columns |= {f"{name} q{part}": values[:, i] for i, part in enumerate("123c")}
        return pd.DataFrame(columns)

    def build_accuracy_table(self) -> pd.DataFrame:
        """Compare the predicted 1-sigma of every state at `t_end` with the 1-sigma before the plan.

        Returns
        -------
        DataFrame
            One row per state. Columns: ``unit``, ``before``, ``after`` and ``after / before [-]``.
        """
        states = covariance.StateLabels.from_suite(self.problem.model.suite)
        before, after = self.problem.model.initial_sigma, self.sigma
        return pd.DataFrame(
            {
                "unit": states.units,
                "before": before * states.factors,
                "after": after * states.factors,
                "after / before [-]": after / before,
            },
            index=pd.Index(states.names, name="state"),
        )

    @cached_property
    def accuracy(self) -> pd.DataFrame:
        """Table of the 1-sigmas about the worst body axis before the plan and at `t_end`.

        The table also contains lower bounds; see `overview.build_accuracy_table` for the columns.
        """
        return build_accuracy_table(self.view)

    def compare_trace_with_lower_bound(self) -> pd.DataFrame:
        """Compare the trace at `t_end` with its lower bound over all maneuvers.

        The table has one row, or no row if no lower bound can be proved.
        """
        columns = ["predicted", "lower bound", "ratio"]
        try:
            (min_trace,) = self.problem.lower_bound.evaluate_trace(np.array([self.t_end]))
        except NoLowerBoundError:
            return pd.DataFrame(columns=columns)
        row = [self.trace, min_trace, self.trace / min_trace]
        return pd.DataFrame([row], ["trace [-]"], columns).rename_axis("quantity")

    def list_uncalibrated_errors(self) -> list[str]:
        """List the estimated errors that keep more than half of their initial 1-sigma.

        Each text contains the remaining share, as in "sun bias (92 %)".

        Plans with a short t_end may satisfy the convergence rule because the filter stalls; this
        list reveals them.
        """
        suite = self.problem.model.suite
        # The reference is the uncertainty before any calibration, because a plan that follows a
        # calibration need not reduce the uncertainty much further.
        initial = suite.initial_sigma(np.radians(self.scenario.initial.attitude_deg))
        remaining = (np.sqrt(np.diag(self.covariance)) / initial).reshape(-1, 3).max(axis=1)
        blocks = list_block_units(suite)
        return [
            f"{block.label} ({100.0 * share:.0f} %)"
            for block, share in zip(blocks, remaining, strict=True)
            if share > UNCALIBRATED_SHARE
        ]

    def build_constraint_table(self) -> pd.DataFrame:
        """Return a table with the value, bound and margin of each constraint of the scenario.

        Returns
        -------
        DataFrame
            One row per constraint. Columns: ``unit``; ``value``; ``bound_type`` ("at most" or "at
            least"); ``bound_value``; ``margin``, negative if the constraint is violated; and
            ``satisfied``. See `ManeuverView.constraints`.
        """
        (table,) = self.view.constraints()
        return table.assign(satisfied=table["margin"].to_numpy(float) >= 0.0)

    def list_violations(self) -> list[str]:
        """Describe each violated constraint in one line of text.

        The line contains the value, the bound and the amount of the violation.
        """
        table = self.build_constraint_table()
        return [
            f"{label} {row['value']:.6g} {row['unit']}, {row['bound_type']} "
            f"{row['bound_value']:.6g} {row['unit']}, violated by {-row['margin']:.3g} "
            f"{row['unit']}"
            for label, row in table[~table["satisfied"].astype(bool)].iterrows()
        ]

    def compute_uncertainty_by_phase(self) -> pd.DataFrame:
        """Return a table of the uncertainty at the start of the plan and at the end of each phase.

        The table contains the trace and the 1-sigma of every state.
        See `error_budget.compute_uncertainty_by_phase` for the columns.
        """
        return error_budget.compute_uncertainty_by_phase(
            self.problem.model, self.design, self.history
        )

    @cached_property
    def _error_budget(self) -> pd.DataFrame:
        return error_budget.compute_error_budget(self.problem.model, self.design, self.history)

    @cached_property
    def _improvements(self) -> pd.DataFrame:
        rate = self.scenario.maneuvers.max_rate_deg_s
        return improvements.evaluate_improvements(self.problem.model, self.design, self.t_end, rate)

    def compute_error_budget(self) -> pd.DataFrame:
        """Return a table with the contribution of each error source to the 1-sigmas at `t_end`.

        The 1-sigmas are those of the worst axis of each 3-vector of the state.
        See `error_budget.compute_error_budget` for rows and columns.
        """
        return self._error_budget.copy()

    def evaluate_improvements(self) -> pd.DataFrame:
        """Evaluate the effect of halved error sources and of longer plans on the 1-sigmas.

        Each row of the table halves one error source or extends the plan; see
        `improvements.evaluate_improvements`.
        """
        return self._improvements.copy()

    def find_error_drivers(self) -> pd.DataFrame:
        """Return the three largest error sources of each 1-sigma that the scenario constrains.

        If the scenario constrains none, the table contains the error sources of the attitude.
        See `error_budget.find_error_drivers` for the columns.
        """
        return error_budget.find_error_drivers(
            self.problem.model, self._error_budget, self._improvements
        )

    def compute_measurement_times(self) -> pd.DataFrame:
        """Return a table of the time [s] during which each sensor provides measurements.

        The table has one row per phase until `t_end` and one column per sensor.
        """
        arguments = self._calibration_phases, self.design, self.history
        return error_budget.compute_measurement_times(self.problem.model, *arguments)

    def compute_correlations(self) -> pd.DataFrame:
        """Return the correlation matrix of the state errors at `t_end`.

        The matrix is a table with the names of the states as index and columns.
        """
        return covariance.compute_correlations(self.problem.model, self.covariance)

    def find_least_observable(self, n_directions: int = 3) -> pd.DataFrame:
        """Find the least observable directions in the state space of the filter.

        In these directions, the ratio of the uncertainty at `t_end` to the initial uncertainty is
        largest.

        See `covariance.find_least_observable` for the columns.

        Parameters
        ----------
        n_directions : int
            Number of directions.
        """
        return covariance.find_least_observable(self.problem.model, self.covariance, n_directions)

    def compare_with_designs(self, designs: Mapping[str, ArrayLike] | None = None) -> pd.DataFrame:
        """Compare the accuracy of the plan with that of other designs at `t_end`.

        Parameters
        ----------
        designs : mapping, optional
            Designs by name. Default: `improvements.build_baselines` with the total maneuver time
            of the plan.

        Returns
        -------
        DataFrame
            Table of `improvements.compare_designs`, with the plan in the first row.
        """
        if designs is None:
            designs = improvements.build_matching_baselines(self.scenario, self._calibration_phases)
        return improvements.compare_designs(
            self.problem, {"plan": self.design, **designs}, self.t_end
        )


@lru_cache(maxsize=4)  # The precomputed data of a problem take some MB.
def _build_problem(scenario: Scenario) -> AttitudeManeuverProblem:
    return AttitudeManeuverProblem(scenario)
