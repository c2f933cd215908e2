"""The loop that all algorithms of the family share, as a pymoo `Algorithm`."""

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
from mgeo.algorithms.coding import BitCode, RealCode
from mgeo.algorithms.run_state import ArchiveOutput, RunState
from mgeo.algorithms.starting import are_evaluated, evaluations_allowed, given_starts
from mgeo.algorithms.variables import Variables
from mgeo.evaluation.evaluator import TolerantEvaluator
from mgeo.evaluation.individuals import individuals, values_of
from mgeo.validation.arguments import refuse_unknown, validate_integer
from mgeo.validation.constructors import call, parameters, values

EXECUTIONS = 5000  # generations of all walkers together, unless a termination is given
MOST_WALKERS = 100_000  # each has its own random stream, of some kilobytes

_OPTIONS = parameters(Algorithm, Algorithm).keys()
_OPTIONS_OF_A_RUN = _OPTIONS | {"pf"}  # in pymoo's examples; pymoo itself does not read it


def is_dynamic(problem: Problem) -> bool:
    """Return whether the values of a problem change with time, as those of pymoo's `dyn` do."""
    return isinstance(problem, DynamicProblem) or callable(getattr(problem, "tic", None))


class ExtremalOptimization(Algorithm, ABC):
    """Generalized extremal optimization with any number of objectives.

    `n_walkers` walkers go side by side. In a generation each one proposes candidates. All
    candidates are evaluated in one batch and update the archive. Then each walker accepts one of
    its own with a probability proportional to k^-tau, k being its rank, be it better or not.

    A subclass says what is proposed, accepted and restarted, by the methods `representation`,
    `candidates`, `accept`, `restart_idle` and, if it carries more, `new_state` and `forget`;
    `restart_walkers` and `archived` are there to be used. It keeps each parameter of its
    constructor under the parameter's name, and all that it carries from one generation to the
    next in its `mgeo.algorithms.run_state.RunState`. `docs/your-algorithm.md` has an example.

    Parameters
    ----------
    tau : selection pressure, as the subclass has checked it.
    n_walkers : number of walkers.
    sampling : starting points of the first walkers: array of up to (n_walkers, n_var), population
        or pymoo `Sampling`; the others start at random. The first generation evaluates them, in
        addition to its candidates, so that no result is worse than a starting point. Individuals
        that are evaluated already are in the archive from the beginning. Where walkers are strings
        of bits, walkers start at the nearest string.
    archive_size : largest number of points in the front, None for all of them.
    options : options of every pymoo algorithm: `termination` (5000 // n_walkers generations unless
        given), `callback`, `output`, `verbose`, `seed`, `save_history`, ...

    Attributes
    ----------
    front : the `ParetoArchive`; `opt`, and so `res.X` and `res.F`, are its points.
    state : the `RunState`: all that is carried from one generation to the next.
    walkers, streams : those of the state.
    n_generations : how many generations are complete.
    """

    takes_nan = True  # for `TolerantEvaluator`: a failed candidate is ranked last, not archived

    code: RealCode | BitCode
    variables: Variables
    state: RunState
    proposed: FloatArray  # what `candidates` leaves for `accept`, if it does

    def __init__(
        self,
        *,
        tau: float | str,
        n_walkers: int,
        sampling: Sampling | ArrayLike | None = None,
        archive_size: int | None = None,
        **options: Any,
    ) -> None:
        known = parameters(type(self), ExtremalOptimization).keys()
        refuse_unknown(options, _OPTIONS, type(self).__name__, known)
        options.setdefault("output", ArchiveOutput())
        options.setdefault("evaluator", TolerantEvaluator())
        super().__init__(**options)
        self.tau = tau
        self.n_walkers = validate_integer("n_walkers", n_walkers, low=1, high=MOST_WALKERS)
        self.sampling = sampling
        if archive_size is not None:
            validate_integer("archive_size", archive_size, low=1)
        self.archive_size = archive_size
        self._asked: Any = None
        self._n_starts = 0  # the first of those asked for
        self._n_left_out = 0  # candidates beyond the budget of the first generation

    def __repr__(self) -> str:
        return call(self, ExtremalOptimization)

    def __deepcopy__(self, memo: dict[int, Any]) -> Self:
        """Copy all but the individuals of the archive, which never change.

        pymoo copies an algorithm after each generation to save its history, which would take the
        memory of the whole archive each time.
        """
        if "state" in self.__dict__:
            memo.update((id(each), each) for each in self.front.individuals.tolist())
        duplicate = memo[id(self)] = object.__new__(type(self))
        duplicate.__dict__.update(copy.deepcopy(self.__dict__, memo))
        return duplicate

    def get_params(self) -> dict[str, Any]:
        """The constructor's parameters by name, as scikit-learn's, without pymoo's own options.

        Raises
        ------
        TypeError : if the constructor does not keep one under its name.
        """
        return values(self, ExtremalOptimization, _OPTIONS)

    @property
    def n_generations(self) -> int:
        """How many generations are complete."""
        return 0 if self.problem is None else self.state.n_generations

    @property
    def front(self) -> ParetoArchive:
        """The archive."""
        return self.state.front

    @property
    def streams(self) -> list[np.random.Generator]:
        """One random stream per walker."""
        return self.state.streams

    @property
    def walkers(self) -> FloatArray:
        """(n_walkers, n_coordinates) the current points."""
        return self.state.walkers

    def setup(
        self, problem: Problem, verbose: bool = False, progress: bool = False, **options: Any
    ) -> "ExtremalOptimization":
        """Bind the algorithm to a problem and place the walkers.

        Parameters
        ----------
        problem : a pymoo problem with finite bounds, of variables that the algorithm can treat,
            whose values do not change during the run.
        verbose, progress, options : as for every pymoo algorithm. `pf`, of many of pymoo's
            examples, changes nothing, as in pymoo.

        Raises
        ------
        TypeError : for an option that pymoo's algorithms do not have; parameters of the
            algorithm itself belong into its constructor.
        ValueError : if the problem has other variables, no finite bounds, or is dynamic.
        RuntimeError : if the algorithm has begun a run already.
        """
        name = type(self).__name__
        refuse_unknown(options, _OPTIONS_OF_A_RUN, f"setup (or minimize) of {name}")
        if self.n_iter is not None:
            raise RuntimeError(
                f"this {name} has begun a run: expected a new one to set up, or a copy.deepcopy of "
                "one before its run"
            )
        if is_dynamic(problem):
            raise ValueError(
                f"{type(problem).__name__} is a dynamic problem, and the front of {name} would "
                "keep objectives of times that are past: expected a problem whose values do not "
                "change during a run (pymoo's DNSGA2 and KGB treat others)"
            )
        self.code = self.representation(problem)
        self.variables = self.code.variables
        if options.get("termination", self.termination) is None:
            # counted in generations, to end also where pymoo's evaluator is not used
            options["termination"] = ("n_gen", max(1, EXECUTIONS // self.n_walkers))
        super().setup(problem, verbose=verbose or self.verbose, progress=progress, **options)
        self._begin(problem)
        return self

    # ---- what a subclass supplies -----------------------------------------------------------

    @abstractmethod
    def representation(self, problem: Problem) -> RealCode | BitCode:
        """How walkers stand for the problem's variables, if the parameters fit them."""

    @abstractmethod
    def candidates(self) -> FloatArray:
        """(n_walkers * candidates a walker, n_var) variables to evaluate, walker by walker."""

    @abstractmethod
    def accept(self, F: FloatArray, violation: FloatArray) -> BoolArray:
        """Move the walkers by what their candidates are worth.

        Parameters
        ----------
        F : (n, n_obj) objectives of `candidates`.
        violation : (n,) constraint violations, 0 where feasible.

        Returns
        -------
        (n_walkers,) mask of the walkers that have made progress of their own.
        """

    @abstractmethod
    def restart_idle(self, progress: BoolArray, entered: BoolArray) -> None:
        """Restart walkers without progress; (n_walkers,) who made it, whose candidates entered."""

    def new_state(
        self, streams: list[np.random.Generator], front: ParetoArchive, walkers: FloatArray
    ) -> RunState:
        """The state to begin with; `forget` fills in what is known of walkers."""
        return RunState.begin(streams, front, walkers)

    def forget(self, rows: IntArray) -> None:
        """Let walkers begin: all but their points is as of new ones."""
        self.state.idle[rows] = 0

    # ---- the loop ---------------------------------------------------------------------------

    def _begin(self, problem: Problem) -> None:
        """What `_setup` is for, out of the way of pymoo's wrappers, which put theirs over it."""
        seeds = self.random_state.bit_generator.seed_seq.spawn(self.n_walkers)
        streams = [np.random.default_rng(seed) for seed in seeds]
        try:
            front = ParetoArchive(problem.n_obj, self.archive_size)
        except ValueError as error:
            raise ValueError(f"archive_size = {self.archive_size}: {error}") from error
        given = given_starts(
            self.sampling, problem, self.variables, self.n_walkers, self.random_state
        )
        n = len(given)
        walkers = np.concatenate([self.code.encode(given), self.code.draw(streams[n:])])
        self.state = self.new_state(streams, front, walkers)
        self.state.starts = np.full((self.n_walkers, problem.n_var), np.nan)
        self.state.starts[:n] = given
        self.forget(np.arange(self.n_walkers))
        if isinstance(self.sampling, Population) and self.problem is problem:
            self._archive_evaluated(self.sampling)

    def _archive_evaluated(self, given: Population) -> None:
        """Archive the starting points whose values are known, instead of evaluating them."""
        is_known = are_evaluated(given, self.problem)
        known = copy.deepcopy(given[is_known])
        known.set("n_gen", 0)
        if len(known):
            F, violation, _ = self._values(known)
            self.front.add(F, known, violation)
        self.state.starts[: len(given)][is_known] = np.nan

    def _initialize_infill(self) -> Population:
        """Return the starting points to evaluate and the first candidates, within the budget."""
        starts = self.state.starts[~np.isnan(self.state.starts).any(axis=1)]
        candidates = self._infill()
        self._n_starts = len(starts)
        if len(starts):
            designs = self.variables.designs(starts)
            self._asked = np.concatenate([designs, self._asked])
            candidates = Population.merge(individuals(designs), candidates)
        allowed = evaluations_allowed(self, len(starts), len(candidates))
        self._n_left_out = len(candidates) - allowed
        self._asked = self._asked[:allowed]
        return candidates[:allowed]

    def _initialize_advance(self, infills: Any = None, **kwargs: Any) -> None:
        self._advance(infills, **kwargs)

    def _infill(self) -> Population:
        self._asked = self.variables.designs(self.candidates())
        return individuals(self._asked)

    def _advance(self, infills: Any = None, **kwargs: Any) -> None:
        infills = self._in_asked_order(infills)
        F, violation, tolerated = self._values(infills)
        entered = self.front.add(F, infills, violation)
        own = slice(self._n_starts, None)
        F, tolerated, entered = F[own], tolerated[own], entered[own]
        if self._n_left_out:  # candidates without values are ranked as failed ones
            F = _extend(F, self._n_left_out, np.nan)
            tolerated = _extend(tolerated, self._n_left_out, 0.0)
            entered = _extend(entered, self._n_left_out, False)
        self._n_starts = self._n_left_out = 0
        progress = self.accept(F, tolerated)
        self.restart_idle(progress, np.any(entered.reshape(self.n_walkers, -1), axis=1))
        self.pop = infills
        self._asked = None
        self.__dict__.pop("proposed", None)
        self.state.n_generations = self.n_iter

    def restart_walkers(self, rows: IntArray, starts: FloatArray | None = None) -> None:
        """Let some walkers begin at given variables, (n, n_var), or at random points."""
        streams = [self.streams[walker] for walker in rows]
        points = self.code.draw(streams) if starts is None else self.code.encode(starts)
        self.walkers[rows] = points
        self.forget(rows)

    def archived(self, rows: Any) -> FloatArray:
        """(n, n_var) variables of these points of the archive."""
        return self.variables.values(values_of(self.front.individuals[rows], "X"))

    def _in_asked_order(self, infills: Any) -> Population:
        """Return the candidates of the last `ask`, told in any order, in the order of `ask`."""
        if infills is not None and self._asked is not None and len(infills) == len(self._asked):
            X = values_of(infills, "X")
            if np.array_equal(X, self._asked):
                return infills
            told, asked = (self.variables.values(designs) for designs in (X, self._asked))
            rows, places = np.lexsort(told.T), np.lexsort(asked.T)
            if np.array_equal(told[rows], asked[places]):
                order = np.empty_like(rows)
                order[places] = rows
                return infills[order]
        raise ValueError(
            "tell: expected the candidates of the last ask(), unchanged, each once, in any order"
        )

    def _values(self, evaluated: Population) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Objectives (n, n_obj) and constraint violations (n,), 0 where feasible.

        The violations come twice: as pymoo judges them, for the archive, and as the individuals'
        configuration does, in which a constraint handling may tolerate more for a while.
        """
        F = values_of(evaluated, "F")
        if F.shape != (len(evaluated), self.problem.n_obj):
            raise ValueError(
                f"tell: F of shape {F.shape}: expected ({len(evaluated)}, {self.problem.n_obj}), "
                "every candidate evaluated"
            )
        if not self.problem.has_constraints():
            return F, np.zeros(len(F)), np.zeros(len(F))
        CV, tolerated = (values[:, 0] for values in evaluated.get("CV", "FEAS"))
        feasible = Individual.default_config()["cv_eps"] >= CV
        return F, np.where(feasible, 0.0, CV), np.where(tolerated, 0.0, CV)

    def _set_optimum(self) -> None:
        self.opt = self.front.individuals


def _extend(values: NDArray[Any], n: int, fill: float) -> NDArray[Any]:
    """Append n rows of a constant."""
    return np.concatenate([values, np.full((n, *values.shape[1:]), fill, dtype=values.dtype)])
