"""Optimization of attitude maneuvers that calibrate sensors, as a pymoo problem."""

from __future__ import annotations

import copy
import dataclasses
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import cached_property
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike
from pymoo.core.problem import Problem

from mgeo.plugins.protocol import ProblemMixin
from mgeo_attitude._typing import Floats
from mgeo_attitude.criteria.constraints import list_constraints, validate_initial_state
from mgeo_attitude.criteria.evaluation_cache import EvaluationCache
from mgeo_attitude.criteria.objectives import (
    Objective,
    find_objective,
    is_refinable,
    scale_for_indicators,
)
from mgeo_attitude.criteria.robustness import (
    MonteCarloRun,
    MonteCarloRuns,
    evaluate_runs,
    reduce_runs,
)
from mgeo_attitude.environment.environment import Environment
from mgeo_attitude.filter.evaluator import Evaluation, evaluate
from mgeo_attitude.filter.model import FilterModel
from mgeo_attitude.lower_bound.assembly import compute_lower_bound
from mgeo_attitude.lower_bound.curves import LowerBound
from mgeo_attitude.maneuvers.schedule import decode_designs
from mgeo_attitude.refine.initial_designs import build_initial_designs
from mgeo_attitude.refine.local_refinement import iterate_refinement
from mgeo_attitude.scenario.criteria import MonteCarloSettings
from mgeo_attitude.scenario.housekeeping import check_channels
from mgeo_attitude.scenario.scenario import Scenario
from mgeo_attitude.scenario.toml import PRESETS

if TYPE_CHECKING:
    from mgeo_attitude.view.maneuver_view import ManeuverView

#: Default number of Monte Carlo runs of a robust problem, and default quantile of its objectives.
_N_RUNS, _QUANTILE = 512, 0.95
#: Recommended number of initial designs, and of evaluations before local refinement.
_N_INITIAL_DESIGNS, _N_EVALUATIONS_BEFORE_REFINEMENT = 12, 6_000
#: Smallest number of maneuvers for these recommendations: default, and by convergence rule; see
#: docs/how-to/better-plans.md.
_MIN_MANEUVERS, _MIN_MANEUVERS_BY_RULE = 6, {"end": 3}
#: Number of Monte Carlo runs at each fidelity level except the last one.
_FIDELITIES = 0, 16, 64
#: Value of "format" in a plan file.
PLAN_FORMAT = "mgeo-attitude-plan"


class AttitudeManeuverProblem(ProblemMixin, Problem):
    """Optimization of satellite maneuvers at constant body rates, as a pymoo problem.

    The default objectives are the convergence time of a Kalman filter and the trace of its final
    covariance. The trace is the weighted trace of equation (5) of the paper, a sum of rad², rad²/s²
    and dimensionless squares. Variables are ωx, ωy, ωz [deg/s] and duration [s] of each maneuver in
    turn. Constraints of the scenario are inequality constraints; see `constraint_names`.

    Parameters
    ----------
    scenario : Scenario, optional
        Default: `Scenario.paper()`.
    n_maneuvers : int, optional
        Number of maneuvers. Default: ``maneuvers.count`` of the scenario.
    threads : int, optional
        Number of threads of one evaluation. Default: the number of processors available to this
        process. Results do not depend on it.
    objectives : sequence of str, optional
        Keys of `criteria.objectives`, or "trace:attitude,gyro.bias" for the trace of some 3-vectors
        of the state. Default: ``objectives`` of the scenario.
    n_runs : int, optional
        Number of Monte Carlo runs per plan, 0 for nominal runs only. Default:
        ``monte_carlo.n_runs`` of the scenario.
    quantile : float, optional
        Quantile of an objective over the Monte Carlo runs. Default: ``monte_carlo.quantile`` of the
        scenario.

    Raises
    ------
    TypeError, ValueError
        If the scenario has another type, a count is invalid, an objective is unknown, or the
        initial state violates a constraint; see `constraints.validate_initial_state`.

    Examples
    --------
    >>> from mgeo_attitude import AttitudeManeuverProblem, Scenario
    >>> problem = AttitudeManeuverProblem(Scenario.cubesat_6u(), objectives=("t_end", "trace"))
    >>> problem.n_var, problem.obj_names, problem.constraint_names
    (24, ('t_end [s]', 'trace [-]'), ())
    """

    var_names: list[str]
    obj_names: tuple[str, ...]
    obj_labels: tuple[str, ...]
    constraint_names: tuple[str, ...]
    without_effect = ("threads",)
    preset_descriptions = PRESETS

    def __init__(
        self,
        scenario: Scenario | None = None,
        n_maneuvers: int | None = None,
        threads: int | None = None,
        objectives: Sequence[str] | None = None,
        n_runs: int | None = None,
        quantile: float | None = None,
    ) -> None:
        scenario = Scenario.paper() if scenario is None else scenario
        if not isinstance(scenario, Scenario):
            raise TypeError(
                f"scenario = {scenario!r}: expected a Scenario, such as Scenario.paper() or "
                "Scenario.from_toml('file.toml')"
            )
        if threads is not None and (not isinstance(threads, int) or threads < 1):
            raise ValueError(f"threads = {threads!r}: expected an integer >= 1, or None")
        changes: dict[str, Any] = {} if objectives is None else {"objectives": objectives}
        if n_maneuvers is not None:
            changes["maneuvers"] = dataclasses.replace(scenario.maneuvers, count=n_maneuvers)
        given: dict[str, Any] = {"n_runs": n_runs, "quantile": quantile}
        given = {key: value for key, value in given.items() if value is not None}
        if n_runs == 0:
            changes["monte_carlo"] = None
        elif given:
            changes["monte_carlo"] = dataclasses.replace(
                scenario.monte_carlo or MonteCarloSettings(), **given
            )
        self.scenario = scenario = dataclasses.replace(scenario, **changes)
        validate_initial_state(scenario)
        check_channels(scenario.housekeeping_channels, scenario.suite)
        self.threads = threads
        self.objectives = scenario.objectives
        self._n_runs = scenario.monte_carlo.n_runs if scenario.monte_carlo else 0
        self._cache = EvaluationCache()
        self.obj_names = tuple(entry.label for entry in self._build_objectives())
        self.obj_labels = tuple(
            "time" if key == "t_end" else key.replace("_", "-") for key in self.objectives
        )
        self.constraint_names = tuple(entry.label for entry in list_constraints(scenario))
        limits = scenario.maneuvers
        upper = np.array([limits.max_rate_deg_s] * 3 + [limits.max_duration])
        xl = np.tile(upper * [-1.0, -1.0, -1.0, 0.0], limits.count)
        xu = np.tile(upper, limits.count)
        names = [*(f"omega_{axis}_{{}} [deg/s]" for axis in "xyz"), "duration_{} [s]"]
        self.var_names = [name.format(m + 1) for m in range(limits.count) for name in names]
        super().__init__(
            n_var=len(self.var_names),
            n_obj=len(self.objectives),
            n_ieq_constr=len(self.constraint_names),
            xl=xl,
            xu=xu,
            vtype=float,
        )

    @cached_property
    def environment(self) -> Environment:
        """Orbit, Sun direction, geomagnetic field and eclipses at all times of the scenario.

        The environment is computed on first use.
        """
        return Environment.from_scenario(self.scenario)

    @cached_property
    def model(self) -> FilterModel:
        """Model of the Kalman filter for the scenario, computed on first use."""
        return FilterModel.from_scenario(self.scenario, self.environment)

    def evaluate_nominal(
        self,
        X: Floats,
        modify_model: Callable[[FilterModel], FilterModel] | None = None,
        **options: Any,
    ) -> Evaluation:
        """Run the Kalman filter for each design in a nominal run, without random errors.

        Parameters
        ----------
        X : array, shape (n, n_var)
            Designs.
        modify_model : function, optional
            Returns the model to use instead of the problem's model.
        **options
            Further arguments of `filter.evaluator.evaluate`.

        Returns
        -------
        Evaluation
        """
        model = self.model if modify_model is None else modify_model(self.model)
        return evaluate(model, X, self.threads, **options)

    @cached_property
    def lower_bound(self) -> LowerBound:
        """Lower bounds on the trace and the 1-sigmas that hold for every plan in a nominal run.

        The bounds are computed on first use.

        Raises
        ------
        NoLowerBoundError
            If no lower bound can be proved for the scenario.
        """
        return compute_lower_bound(self.scenario, self.model)

    @cached_property
    def monte_carlo_runs(self) -> MonteCarloRuns | None:
        """Monte Carlo runs used to evaluate plans, or None for an evaluation in nominal runs."""
        errors = self.scenario.monte_carlo
        return None if errors is None else MonteCarloRuns(self.scenario, self.model, errors)

    def at_fidelity(self, fidelity: int) -> AttitudeManeuverProblem:
        """Return the problem at a given fidelity level, where level 0 is the lowest.

        A lower level evaluates fewer Monte Carlo runs. The level with all runs returns the problem
        itself. See `mgeo.MGEOStaged`.

        Parameters
        ----------
        fidelity : int
            Fidelity level, at least 0.

        Returns
        -------
        AttitudeManeuverProblem
        """
        errors = self.scenario.monte_carlo
        if (
            self.monte_carlo_runs is None
            or errors is None
            or errors.n_runs_at_fidelity(fidelity) == errors.n_runs
        ):
            return self
        problem = copy.copy(self)  # The copy shares the filter model and the Monte Carlo runs.
        problem._n_runs, problem._cache = errors.n_runs_at_fidelity(fidelity), EvaluationCache()
        return problem

    def _evaluate(self, X: Floats, out: dict[str, Any], *args: Any, **kwargs: Any) -> None:
        designs = np.asarray(X, dtype=float)
        if designs.ndim != 2 or designs.shape[1] != self.n_var:
            raise ValueError(f"X of shape {designs.shape}: expected (n, {self.n_var})")
        decode_designs(designs)  # An invalid design raises an error with its row number.
        ends = [self.n_obj, self.n_obj + self.n_ieq_constr]
        out["F"], out["G"], _ = np.split(self.evaluate_designs(designs), ends, axis=1)

    def evaluate_designs(self, X: Floats) -> Floats:
        """Return objectives, constraint values and relative violations, with one row per design.

        The violations are those of all bounds. The values are those of nominal runs or, with Monte
        Carlo runs, their quantiles or means. Designs of the previous batch are not evaluated again.

        Parameters
        ----------
        X : array, shape (n, n_var)

        Returns
        -------
        array, shape (n, n_obj + n_ieq_constr + n_bounds)
        """
        return self._cache.evaluate(X, self._evaluate_uncached)

    def _evaluate_uncached(self, X: Floats) -> Floats:
        if self.monte_carlo_runs is None or not self._n_runs:
            return self.compute_values(
                self.model, self.evaluate_nominal(X, covariance=self._needs_covariance)
            )
        values = self.evaluate_runs(self.monte_carlo_runs.iterate_runs(self._n_runs), X)
        return reduce_runs(values, self.n_obj, self.monte_carlo_runs.settings)

    def evaluate_runs(self, runs: Iterable[MonteCarloRun], X: Floats) -> Floats:
        """Evaluate each design in each Monte Carlo run.

        The array contains objectives, constraint values and relative violations of all bounds.

        Parameters
        ----------
        runs : iterable of MonteCarloRun
            The f runs.
        X : array, shape (n, n_var)
            Designs.

        Returns
        -------
        array, shape (f, n, n_obj + n_ieq_constr + n_bounds)
        """
        return evaluate_runs(runs, X, self.compute_values, self.threads, self._needs_covariance)

    def compute_values(self, model: FilterModel, result: Evaluation) -> Floats:
        """Compute objectives, constraint values and relative violations from filter results.

        The violations are those of all bounds.

        Parameters
        ----------
        model : FilterModel
        result : Evaluation
            Filter result of n designs, with covariances if objectives or constraints need them.

        Returns
        -------
        array, shape (n, n_obj + n_ieq_constr + n_bounds)
        """
        violations = [
            constraint.compute_violations(result) for constraint in list_constraints(self.scenario)
        ]
        columns = [entry.value(model, result) for entry in self._build_objectives()]
        columns += [each.max(axis=0) for each in violations]
        return np.column_stack([*columns, *chain.from_iterable(violations)])

    @property
    def _needs_covariance(self) -> bool:
        needed = any(each.needs_covariance for each in self._build_objectives())
        return needed or any(each.needs_covariance for each in list_constraints(self.scenario))

    def _build_objectives(self) -> list[Objective]:
        return [find_objective(name, self.scenario.suite) for name in self.objectives]

    @classmethod
    def from_options(cls, options: Mapping[str, Any]) -> AttitudeManeuverProblem:
        """Build the problem from the contents of a scenario file, given as nested dicts.

        An empty dict gives the paper's scenario. See `Scenario.from_dict`.

        Parameters
        ----------
        options : mapping
            Keys of a scenario file.

        Returns
        -------
        AttitudeManeuverProblem
        """
        return cls(Scenario.from_dict(options) if options else None)

    @classmethod
    def parse_document(cls, document: Mapping[str, Any]) -> tuple[Mapping[str, Any], Any] | None:
        if document.get("format") != PLAN_FORMAT:
            return None
        return document.get("scenario", {}), document.get("design")

    def build_document(self, x: ArrayLike) -> dict[str, Any]:
        from mgeo_attitude.plan.files import build_document
        from mgeo_attitude.plan.plan import ManeuverPlan

        return build_document(ManeuverPlan.from_design(self, x))

    @classmethod
    def read_files(cls, options: Mapping[str, Any], folder: Path) -> dict[str, Any]:
        """Replace references to files in a scenario by the contents of these files.

        The only such file is an orbit file, whose path is relative to `folder`.

        Parameters
        ----------
        options : mapping
            Keys of a scenario file.
        folder : Path
            Folder of the scenario file.

        Returns
        -------
        dict
        """
        orbit = options.get("orbit")
        if not isinstance(orbit, Mapping) or "file" not in orbit:
            return dict(options)
        return Scenario.from_dict(options, folder).to_dict()

    def to_options(self) -> dict[str, Any]:
        return self.scenario.to_dict()

    def map_to_indicator_space(self, F: ArrayLike) -> Floats:
        """Scale objectives for performance indicators such as the hypervolume.

        For t_end and trace the scaling is t_end / duration and (log10 trace + 6) / 5; see
        docs/explanation/paper.md. With the preset "paper", the reference point (1, 1) bounds every
        useful solution.

        Parameters
        ----------
        F : array_like, shape (n, n_obj)

        Returns
        -------
        array, shape (n, n_obj)
        """
        values = np.atleast_2d(np.asarray(F, dtype=float))
        return scale_for_indicators(self.objectives, values, self.scenario)

    def to_robust(self) -> AttitudeManeuverProblem:
        """Return a copy of the problem that evaluates each plan over Monte Carlo runs.

        By default these are 512 runs with the quantile 0.95 of each objective; the table
        ``monte_carlo`` of a scenario replaces these settings, with a warning. A search selects
        plans for which its own runs happen to be favorable. Because the quantile is larger than
        0.9, the predicted value still holds in about 90 % of other runs. Searches with fidelity
        levels start with nominal runs, and then use 16 and 64 of the Monte Carlo runs; see
        `mgeo.MGEOStaged`.

        Returns
        -------
        AttitudeManeuverProblem
        """
        defaults = MonteCarloSettings(n_runs=_N_RUNS, quantile=_QUANTILE)
        errors = self.scenario.monte_carlo or defaults
        if (errors.n_runs, errors.quantile) != (_N_RUNS, _QUANTILE) or errors.mean:
            value = "the mean" if errors.mean else f"the quantile {errors.quantile:g}"
            warnings.warn(
                f"The robust search uses [monte_carlo] of the scenario, with {value} over "
                f"{errors.n_runs} runs. Without this table it uses the quantile {_QUANTILE:g} over "
                f"{_N_RUNS} runs.",
                stacklevel=2,
            )
        fidelities = tuple(count for count in _FIDELITIES if count < errors.n_runs)
        settings = dataclasses.replace(errors, fidelities=errors.fidelities or fidelities)
        scenario = dataclasses.replace(self.scenario, monte_carlo=settings)
        return AttitudeManeuverProblem(scenario, threads=self.threads)

    def recommend_settings(self) -> dict[str, Any]:
        """Return recommended settings for a search of this problem.

        The settings are the number of initial designs, local refinement and the number of
        evaluations. The dict is empty for the paper's scenario, which is a reference study; for few
        maneuvers, where a search alone comes as close to the lower bound; and for Monte Carlo runs
        and magnetorquers, where refinement takes far longer than a search. With momentum budgets of
        wheels only initial designs are recommended.

        Returns
        -------
        dict
            Fields of `mgeo.plugins.protocol.RecommendedSettings`.
        """
        scenario, wheels = self.scenario, self.scenario.wheels
        min_maneuvers = _MIN_MANEUVERS_BY_RULE.get(scenario.convergence.rule, _MIN_MANEUVERS)
        is_small = scenario.maneuvers.count < min_maneuvers
        if (
            is_small
            or scenario.name == "paper"
            or scenario.monte_carlo
            or scenario.is_magnetorquer_driven
        ):
            return {}
        if not is_refinable(self.objectives) or (wheels and wheels.has_momentum_budget):
            return {"initial_designs": _N_INITIAL_DESIGNS}
        return {
            "initial_designs": _N_INITIAL_DESIGNS,
            "refine": True,
            "evaluations": _N_EVALUATIONS_BEFORE_REFINEMENT,
        }

    def suggest_initial_designs(self, n: int, random_state: np.random.Generator) -> Floats:
        """Return n initial designs for a search, as an array of shape (n, n_var).

        See `refine.initial_designs.build_initial_designs`.

        Parameters
        ----------
        n : int
            Number of designs.
        random_state : numpy Generator
            Draws the end times of the designs.

        Returns
        -------
        array, shape (n, n_var)
        """
        return build_initial_designs(self, n, random_state)

    def refine(self, X: ArrayLike) -> Iterator[Floats]:
        """Improve designs by local refinement, and yield all designs after each batch.

        The designs keep their order. Later elements have additional rows for other end times. See
        `refine_plans`.

        Parameters
        ----------
        X : array_like, shape (n, n_var)
            Designs to improve.

        Returns
        -------
        iterator of array, shape (k, n_var)

        Raises
        ------
        ValueError
            If the objectives are not t_end and one smooth objective.
        """
        return iterate_refinement(self, X, add_plans=True)

    def view(self, X: ArrayLike) -> ManeuverView:
        from mgeo_attitude.view.maneuver_view import ManeuverView

        return ManeuverView(self, X)
