"""Base class of all algorithms of the MGEO family, a pymoo `Algorithm`."""

import copy
from abc import ABC, abstractmethod
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pymoo.core.algorithm import Algorithm
from pymoo.core.individual import Individual
from pymoo.core.population import Population
from pymoo.core.problem import Problem
from pymoo.core.sampling import Sampling
from pymoo.problems.dyn import DynamicProblem

from mgeo._typing import BoolArray, FloatArray, IntArray
from mgeo.algorithms.archive import ParetoArchive
from mgeo.algorithms.encoding import BitEncoding, RealEncoding
from mgeo.algorithms.initial_designs import (
    build_initial_designs,
    count_allowed_evaluations,
    find_evaluated,
)
from mgeo.algorithms.run_state import ArchiveOutput, RunState
from mgeo.algorithms.variables import Variables
from mgeo.evaluation.evaluator import TolerantEvaluator
from mgeo.evaluation.individuals import build_population, get_values
from mgeo.validation.arguments import reject_unknown_keywords, validate_integer
from mgeo.validation.constructors import format_call, get_parameter_values, get_parameters

#: Default number of generations, multiplied by the number of walkers.
DEFAULT_WALKER_GENERATIONS = 5000
#: Largest number of walkers. Each walker has a random stream of several kilobytes.
MAX_WALKERS = 100_000

_OPTIONS = get_parameters(Algorithm, Algorithm).keys()
# Many examples of pymoo pass "pf", which pymoo ignores.
_SETUP_OPTIONS = _OPTIONS | {"pf"}


def is_dynamic(problem: Problem) -> bool:
    """Return True if a problem is dynamic, that is, if its objectives change over time."""
    return isinstance(problem, DynamicProblem) or callable(getattr(problem, "tic", None))


class ExtremalOptimization(Algorithm, ABC):
    """Base class for generalized extremal optimization with any number of objectives.

    The search consists of `n_walkers` parallel search trajectories, called walkers. In each
    generation, each walker proposes candidates. All candidates are evaluated in one batch and added
    to the archive. Each walker then moves to one of its candidates, which it draws with a
    probability proportional to k^-tau, where k is the rank of the candidate. The walker moves even
    if the candidate is worse than its current point.

    A subclass implements `build_encoding`, `generate_candidates`, `accept` and
    `restart_idle_walkers`, and extends `create_state` and `reset_walkers` if it has additional
    state. It can call `restart_walkers` and `get_archived_points`. It must store each constructor
    parameter as an attribute of the same name, and all data that persist between generations in a
    `mgeo.algorithms.run_state.RunState`. `docs/how-to/write-an-algorithm.md` has an example.

    Parameters
    ----------
    tau : selection pressure, validated by the subclass.
    n_walkers : number of walkers.
    sampling : starting points of the first walkers: an array of shape (n, n_var) with n <=
        n_walkers, a population, or a pymoo `Sampling`. The other walkers start at random points.
        The first generation evaluates the starting points in addition to the candidates, so that
        the result is never worse than a starting point. Individuals that are already evaluated are
        archived at the start. Walkers that are bit strings start at the nearest string.
    archive_size : largest number of points in the front; None for no limit.
    options : options of every pymoo algorithm: `termination` (5000 // n_walkers generations by
        default), `callback`, `output`, `verbose`, `seed`, `save_history`, ...

    Attributes
    ----------
    front : ParetoArchive
        Nondominated points. They are the optimum `opt`, and so `res.X` and `res.F`.
    state : RunState
        Data that persist between generations.
    walkers, streams
        Current points and random streams of the walkers, from `state`.
    n_generations : int
        Number of completed generations.
    """

    #: Failed candidates keep their NaN objectives: `TolerantEvaluator` does not replace them.
    accepts_nan = True

    encoding: RealEncoding | BitEncoding
    variables: Variables
    state: RunState
    #: Proposed coordinates, which `generate_candidates` can store for `accept`.
    proposals: FloatArray

    def __init__(
        self,
        *,
        tau: float | str,
        n_walkers: int,
        sampling: Sampling | ArrayLike | None = None,
        archive_size: int | None = None,
        **options: Any,
    ) -> None:
        known = get_parameters(type(self), ExtremalOptimization).keys()
        reject_unknown_keywords(options, _OPTIONS, type(self).__name__, known)
        options.setdefault("output", ArchiveOutput())
        options.setdefault("evaluator", TolerantEvaluator())
        super().__init__(**options)
        self.tau = tau
        self.n_walkers = validate_integer("n_walkers", n_walkers, low=1, high=MAX_WALKERS)
        self.sampling = sampling
        if archive_size is not None:
            validate_integer("archive_size", archive_size, low=1)
        self.archive_size = archive_size
        self._pending_designs: Any = None
        # Number of initial designs at the beginning of `_pending_designs`.
        self._n_initial_designs = 0
        # Number of candidates of the first generation that exceed the evaluation budget.
        self._n_over_budget = 0

    def __repr__(self) -> str:
        return format_call(self, ExtremalOptimization)

    def __deepcopy__(self, memo: dict[int, Any]) -> Self:
        # pymoo copies the algorithm in each generation to save its history. Archived individuals
        # never change, so the copies share them to save memory.
        if "state" in self.__dict__:
            memo.update((id(each), each) for each in self.front.individuals.tolist())
        duplicate = memo[id(self)] = object.__new__(type(self))
        duplicate.__dict__.update(copy.deepcopy(self.__dict__, memo))
        return duplicate

    def get_params(self) -> dict[str, Any]:
        """Return the constructor parameters as a dict that maps names to values.

        The options of pymoo are not included. The convention is that of `get_params` in
        scikit-learn.

        Raises
        ------
        TypeError
            If the algorithm has no attribute with the name of a parameter.
        """
        return get_parameter_values(self, ExtremalOptimization, _OPTIONS)

    @property
    def n_generations(self) -> int:
        """Number of completed generations."""
        return 0 if self.problem is None else self.state.n_generations

    @property
    def front(self) -> ParetoArchive:
        """Archive of the nondominated points that the run has found so far."""
        return self.state.front

    @property
    def streams(self) -> list[np.random.Generator]:
        """Random number generators of the walkers, one per walker."""
        return self.state.streams

    @property
    def walkers(self) -> FloatArray:
        """Current points of the walkers as an array with one row per walker.

        The columns are the variables or, for a binary encoding, the bits.
        """
        return self.state.walkers

    def setup(
        self, problem: Problem, verbose: bool = False, progress: bool = False, **options: Any
    ) -> "ExtremalOptimization":
        """Prepare the algorithm for a problem, and draw the starting points of the walkers.

        Parameters
        ----------
        problem : Problem
            A pymoo problem with finite bounds, variables of supported types, and objectives that do
            not depend on time.
        verbose, progress, **options
            Options of every pymoo algorithm. As in pymoo, `pf` has no effect.

        Raises
        ------
        TypeError
            If an option is unknown. Parameters of the algorithm belong to its constructor.
        ValueError
            If the problem has unsupported variables, no finite bounds, or is dynamic.
        RuntimeError
            If the algorithm has already started a run.
        """
        name = type(self).__name__
        reject_unknown_keywords(options, _SETUP_OPTIONS, f"setup (or minimize) of {name}")
        if self.n_iter is not None:
            raise RuntimeError(
                f"this {name} has already started a run: expected a new {name}, or a copy.deepcopy "
                "made before the run"
            )
        if is_dynamic(problem):
            raise ValueError(
                f"{type(problem).__name__} is a dynamic problem, and the front of {name} would "
                "keep outdated objectives: expected a problem whose objectives do not depend on "
                "time. For dynamic problems, use DNSGA2 or KGB of pymoo"
            )
        self.encoding = self.build_encoding(problem)
        self.variables = self.encoding.variables
        if options.get("termination", self.termination) is None:
            # A limit on generations also ends runs that do not count evaluations.
            options["termination"] = ("n_gen", max(1, DEFAULT_WALKER_GENERATIONS // self.n_walkers))
        super().setup(problem, verbose=verbose or self.verbose, progress=progress, **options)
        self._initialize_run(problem)
        return self

    # ---- methods for subclasses to implement or extend --------------------------------------

    @abstractmethod
    def build_encoding(self, problem: Problem) -> RealEncoding | BitEncoding:
        """Return an encoding of a problem's variables as real vectors or as bit strings.

        Raises
        ------
        ValueError
            If the variables are not supported, or do not match the parameters.
        """

    @abstractmethod
    def generate_candidates(self) -> FloatArray:
        """Return the candidates that the walkers propose for the next generation.

        Returns
        -------
        array, shape (n_walkers * n_candidates, n_var)
            Variables of the candidates, first all candidates of the first walker. Each walker has
            the same number of candidates.
        """

    @abstractmethod
    def accept(self, F: FloatArray, violation: FloatArray) -> BoolArray:
        """Move the walkers, based on the objectives and constraint violations of their candidates.

        Parameters
        ----------
        F : array, shape (n, n_obj)
            Objectives of the candidates; NaN where the evaluation failed.
        violation : array, shape (n,)
            Constraint violations, 0 where feasible.

        Returns
        -------
        array of bool, shape (n_walkers,)
            True for each walker whose best fitness so far has improved.
        """

    @abstractmethod
    def restart_idle_walkers(
        self, has_progress: BoolArray, has_archived_candidate: BoolArray
    ) -> None:
        """Restart the walkers that have made no progress for a number of generations.

        The subclass defines this number.

        Parameters
        ----------
        has_progress : array of bool, shape (n_walkers,)
            Return value of `accept`.
        has_archived_candidate : array of bool, shape (n_walkers,)
            True for each walker with a candidate that entered the archive.
        """

    def create_state(
        self, streams: list[np.random.Generator], front: ParetoArchive, walkers: FloatArray
    ) -> RunState:
        """Create the initial state of a run.

        The per-walker arrays of the state may be uninitialized, because `reset_walkers` is called
        next.

        Parameters
        ----------
        streams : list of numpy.random.Generator
            Random number generators, one per walker.
        front : ParetoArchive
            Empty archive.
        walkers : array, shape (n_walkers, n_coordinates)
            Points at which the walkers start.
        """
        return RunState.create(streams, front, walkers)

    def reset_walkers(self, rows: IntArray) -> None:
        """Reset all data of the selected walkers except their current points."""
        self.state.n_idle_generations[rows] = 0

    # ---- implementation of pymoo's `Algorithm` ----------------------------------------------

    def _initialize_run(self, problem: Problem) -> None:
        # Not named `_setup`, because some wrappers of pymoo override that method.
        seeds = self.random_state.bit_generator.seed_seq.spawn(self.n_walkers)
        streams = [np.random.default_rng(seed) for seed in seeds]
        try:
            front = ParetoArchive(problem.n_obj, self.archive_size)
        except ValueError as error:
            raise ValueError(f"archive_size = {self.archive_size}: {error}") from error
        designs = build_initial_designs(
            self.sampling, problem, self.variables, self.n_walkers, self.random_state
        )
        n = len(designs)
        walkers = np.concatenate([self.encoding.encode(designs), self.encoding.draw(streams[n:])])
        self.state = self.create_state(streams, front, walkers)
        self.state.initial_designs = np.full((self.n_walkers, problem.n_var), np.nan)
        self.state.initial_designs[:n] = designs
        self.reset_walkers(np.arange(self.n_walkers))
        if isinstance(self.sampling, Population) and self.problem is problem:
            self._archive_evaluated_designs(self.sampling)

    def _archive_evaluated_designs(self, population: Population) -> None:
        """Move already evaluated initial designs from the first generation to the archive."""
        is_evaluated = find_evaluated(population, self.problem)
        evaluated = copy.deepcopy(population[is_evaluated])
        evaluated.set("n_gen", 0)
        if len(evaluated):
            F, violation, _ = self._get_objectives_and_violations(evaluated)
            self.front.add(F, evaluated, violation)
        self.state.initial_designs[: len(population)][is_evaluated] = np.nan

    def _initialize_infill(self) -> Population:
        """Return the individuals of the first generation.

        The initial designs come first. They are followed by as many candidates as the evaluation
        budget allows.
        """
        points = self.state.initial_designs
        points = points[~np.isnan(points).any(axis=1)]
        candidates = self._infill()
        self._n_initial_designs = len(points)
        if len(points):
            designs = self.variables.to_designs(points)
            self._pending_designs = np.concatenate([designs, self._pending_designs])
            candidates = Population.merge(build_population(designs), candidates)
        allowed = count_allowed_evaluations(self, len(points), len(candidates))
        self._n_over_budget = len(candidates) - allowed
        self._pending_designs = self._pending_designs[:allowed]
        return candidates[:allowed]

    def _initialize_advance(self, infills: Any = None, **kwargs: Any) -> None:
        self._advance(infills, **kwargs)

    def _infill(self) -> Population:
        self._pending_designs = self.variables.to_designs(self.generate_candidates())
        return build_population(self._pending_designs)

    def _advance(self, infills: Any = None, **kwargs: Any) -> None:
        infills = self._restore_ask_order(infills)
        F, violation, tolerated = self._get_objectives_and_violations(infills)
        entered = self.front.add(F, infills, violation)
        candidates = slice(self._n_initial_designs, None)
        F, tolerated, entered = F[candidates], tolerated[candidates], entered[candidates]
        if self._n_over_budget:  # Candidates that were not evaluated are ranked as failed.
            F = _append_rows(F, self._n_over_budget, np.nan)
            tolerated = _append_rows(tolerated, self._n_over_budget, 0.0)
            entered = _append_rows(entered, self._n_over_budget, False)
        self._n_initial_designs = self._n_over_budget = 0
        progress = self.accept(F, tolerated)
        self.restart_idle_walkers(progress, np.any(entered.reshape(self.n_walkers, -1), axis=1))
        self.pop = infills
        self._pending_designs = None
        self.__dict__.pop("proposals", None)
        self.state.n_generations = self.n_iter

    def restart_walkers(self, rows: IntArray, new_points: FloatArray | None = None) -> None:
        """Move the selected walkers to new points, and reset all their other data.

        Parameters
        ----------
        rows : array of int, shape (n,)
            Indices of the walkers.
        new_points : array, shape (n, n_var), optional
            New points; random points by default.
        """
        streams = [self.streams[walker] for walker in rows]
        points = (
            self.encoding.draw(streams) if new_points is None else self.encoding.encode(new_points)
        )
        self.walkers[rows] = points
        self.reset_walkers(rows)

    def get_archived_points(self, rows: Any) -> FloatArray:
        """Return the variables of the selected points of the archive, with one row per point.

        Parameters
        ----------
        rows : array of int or bool
            Indices or mask of the points in the archive.
        """
        return self.variables.to_numbers(get_values(self.front.individuals[rows], "X"))

    def _restore_ask_order(self, infills: Any) -> Population:
        """Return the individuals passed to `tell` in the order in which `ask` returned them."""
        if (
            infills is not None
            and self._pending_designs is not None
            and len(infills) == len(self._pending_designs)
        ):
            X = get_values(infills, "X")
            if np.array_equal(X, self._pending_designs):
                return infills
            values, expected = (
                self.variables.to_numbers(designs) for designs in (X, self._pending_designs)
            )
            rows, expected_rows = np.lexsort(values.T), np.lexsort(expected.T)
            if np.array_equal(values[rows], expected[expected_rows]):
                order = np.empty_like(rows)
                order[expected_rows] = rows
                return infills[order]
        raise ValueError(
            "tell: expected the candidates of the last ask(), unchanged, each once, in any order"
        )

    def _get_objectives_and_violations(
        self, population: Population
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return the objectives and the constraint violations of a population.

        The second array contains the violations by the default tolerance of pymoo, and the third
        array those by the current tolerance. Violations are 0 where feasible. The archive uses the
        default tolerance. The selection uses the current tolerance, from the configuration of the
        individuals. A constraint handling of pymoo may relax the current tolerance during a run.
        """
        F = get_values(population, "F")
        if F.shape != (len(population), self.problem.n_obj):
            raise ValueError(
                f"tell: F of shape {F.shape}: expected ({len(population)}, {self.problem.n_obj}), "
                "every candidate evaluated"
            )
        if not self.problem.has_constraints():
            return F, np.zeros(len(F)), np.zeros(len(F))
        CV, is_tolerated = (values[:, 0] for values in population.get("CV", "FEAS"))
        is_feasible = Individual.default_config()["cv_eps"] >= CV
        return F, np.where(is_feasible, 0.0, CV), np.where(is_tolerated, 0.0, CV)

    def _set_optimum(self) -> None:
        self.opt = self.front.individuals


def _append_rows(values: NDArray[Any], n: int, fill: float) -> NDArray[Any]:
    return np.concatenate([values, np.full((n, *values.shape[1:]), fill, dtype=values.dtype)])
