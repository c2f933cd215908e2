"""The loop that all algorithms of the family share, as a pymoo `Algorithm`."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from pymoo.core.algorithm import Algorithm
from pymoo.core.individual import Individual
from pymoo.core.population import Population
from pymoo.core.problem import Problem
from pymoo.core.sampling import Sampling
from pymoo.core.termination import Termination
from pymoo.termination.max_gen import MaximumGenerationTermination

from mgeo._typing import FloatArray, IntArray
from mgeo._validation import refuse_unknown, validate_choice, validate_integer, validate_number
from mgeo.algorithms import adaptive
from mgeo.algorithms.constructors import arguments, keywords, named
from mgeo.algorithms.display import ArchiveOutput
from mgeo.algorithms.refusals import INSTEAD, refuse_dynamic, refuse_used
from mgeo.algorithms.representation import call
from mgeo.algorithms.starts import given_starts
from mgeo.algorithms.walkers import Walkers
from mgeo.evaluation.evaluator import TolerantEvaluator
from mgeo.evaluation.individuals import individuals, values_of
from mgeo.pareto.archive import ParetoArchive

EXECUTIONS = 5000  # generations of all walkers together, unless a termination is given
MOST_RUNS = 100_000  # each has its own random stream, of some kilobytes
RESTARTS = ("never", "random", "archive")


_OPTIONS = named(Algorithm)
_OF_A_RUN = _OPTIONS | {"pf"}  # which pymoo's examples pass on, and pymoo itself does not read


class ExtremalOptimization(Walkers, Algorithm):
    """Generalized extremal optimization with any number of objectives.

    `n_walkers` walkers go side by side. In a generation each one proposes candidates, every one of
    which differs from it in a single coordinate. All candidates are evaluated in one batch and
    put to the Pareto test. Then each walker draws an objective, ranks its candidates by it and
    accepts one with a probability proportional to k^-tau (one of each group, if the leaf has
    several groups), be it better or not.

    Unless it restarts, a walker never looks at the archive or at other walkers, and it owns a
    random stream (child i of the seed), so running side by side is the same as running one after
    the other. Starting points are not evaluated, unless the leaf evaluates walkers. The loop
    itself, and what a leaf supplies to it, is in `mgeo.algorithms.walkers`. A leaf keeps each
    parameter of its constructor under the parameter's name, and all that it carries from one
    generation to the next in its `mgeo.algorithms.run_state.RunState`.

    Parameters
    ----------
    tau : greediness of the acceptance, >= 0; or a rule of `mgeo.algorithms.adaptive`.
    n_walkers : number of walkers.
    restart : where a walker without progress begins anew, one of `RESTARTS`. Progress is a
        candidate that enters the archive, or betters the walker's own best in some objective.
    patience : generations without progress before a restart.
    sampling : starting points of the first walkers; the leaf draws those of the others.
    archive_size : largest number of points in the front, None for all of them.
    options : options of every pymoo algorithm: `termination`, `callback`, `verbose`, ...

    Attributes
    ----------
    front : the `ParetoArchive`; `opt`, and so `res.X` and `res.F`, are its points.
    state, walkers, streams : those of `Walkers`.
    n_generations : how many generations are complete.
    """

    takes_nan = True  # for `TolerantEvaluator`: a failed candidate is ranked last, not archived

    def __init__(
        self,
        *,
        tau: float | str,
        n_walkers: int,
        restart: str = "never",
        patience: int = 50,
        sampling: Sampling | ArrayLike | None = None,
        archive_size: int | None,
        options: dict[str, Any],
    ) -> None:
        known = keywords(type(self), ExtremalOptimization)
        refuse_unknown(options, _OPTIONS, type(self).__name__, known, INSTEAD)
        options.setdefault("output", ArchiveOutput())
        options.setdefault("evaluator", TolerantEvaluator())
        super().__init__(**options)
        self.tau: float | str = (
            validate_choice("tau", tau, adaptive.RULES)
            if isinstance(tau, str)
            else validate_number("tau", tau, low=0)
        )
        self.n_walkers = validate_integer("n_walkers", n_walkers, low=1, high=MOST_RUNS)
        self.restart = validate_choice("restart", restart, RESTARTS)
        self.patience = validate_integer("patience", patience, low=1)
        self.sampling = sampling
        self.archive_size = (
            None if archive_size is None else validate_integer("archive_size", archive_size, low=1)
        )
        self._asked: Any = None

    def __repr__(self) -> str:
        return call(self, ExtremalOptimization)

    @property
    def n_generations(self) -> int:
        """How many generations are complete."""
        return 0 if self.problem is None else self.state.n_generations

    @property
    def n_runs(self) -> int:
        """`n_walkers`, which the papers call n_i re-initializations."""
        return self.n_walkers

    def setup(
        self, problem: Problem, verbose: bool = False, progress: bool = False, **options: Any
    ) -> "ExtremalOptimization":
        """Bind the algorithm to a problem and place the walkers.

        Parameters
        ----------
        problem : a pymoo problem with finite bounds, of variables that the leaf can treat,
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
        own = (keywords(type(self), ExtremalOptimization) | {"n_runs"}) - _OPTIONS
        if misplaced := sorted(own & options.keys()):
            raise TypeError(f"{misplaced[0]} is a parameter of {name}(...), not of a run")
        refuse_unknown(options, _OF_A_RUN, f"setup (or minimize) of {name}", instead=INSTEAD)
        refuse_used(self)
        refuse_dynamic(problem, name)
        self.variables = self._variables(problem)
        if options.get("termination", self.termination) is None:
            options["termination"] = default_termination(self.n_walkers)
        super().setup(problem, verbose=verbose or self.verbose, progress=progress, **options)
        self._begin(problem)
        return self

    @property
    def _parameters(self) -> dict[str, Any]:
        """Arguments with which the class makes such an algorithm; TypeError if there are none."""
        return arguments(self, ExtremalOptimization, _OPTIONS)

    def _begin(self, problem: Problem) -> None:
        """What `_setup` is for, out of the way of pymoo's wrappers, which put theirs over it."""
        seeds = self.random_state.bit_generator.seed_seq.spawn(self.n_walkers)
        streams = [np.random.default_rng(seed) for seed in seeds]
        try:
            front = ParetoArchive(problem.n_obj, self.archive_size)
        except ValueError as error:
            raise ValueError(f"archive_size = {self.archive_size}: {error}") from error
        starts = None
        if self.sampling is not None:
            starts = given_starts(
                self.sampling, problem, self.variables, self.n_walkers, self.random_state
            )
        self._place(streams, front, starts)

    def _initialize_infill(self) -> Population:
        return self._infill()

    def _initialize_advance(self, infills: Any = None, **kwargs: Any) -> None:
        self._advance(infills, **kwargs)

    def _infill(self) -> Population:
        self._asked = self.variables.designs(self._candidates())
        return individuals(self._asked)

    def _advance(self, infills: Any = None, **kwargs: Any) -> None:
        F, violation, tolerated = self._told(infills)
        entered = self.front.add(F, infills, violation)
        progress = self._accept(F, tolerated)
        if self.restart != "never":
            progress |= entered.reshape(self.n_walkers, -1).any(axis=1)
            if len(stuck := self._stuck(progress)):
                self._begin_anew(stuck, self._restarts_of(stuck))
        self.pop = infills
        self._asked = None
        del self._values
        self.state.n_generations = self.n_iter

    def _restarts_of(self, walkers: IntArray) -> FloatArray | None:
        """(n, n_var) a point of the archive for each; None if they do not begin there."""
        if self.restart != "archive" or not len(self.front):
            return None
        rows = [self.streams[walker].integers(len(self.front)) for walker in walkers]
        return self.variables.values(self.front.individuals[rows].get("X"))

    def _told(self, infills: Any) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Objectives (n, n_obj) and constraint violations (n,), 0 where feasible.

        The violations come twice: as pymoo judges them, for the archive, and as the individuals'
        configuration does, in which a constraint handling may tolerate more for a while.
        """
        if self._asked is None or infills is None:
            raise ValueError(
                f"tell(infills={'...' if infills is not None else None}): expected the "
                "candidates of the ask() before, once"
            )
        X, F = values_of(infills, "X"), values_of(infills, "F")
        if not np.array_equal(X, self._asked):
            raise ValueError(
                f"tell: expected the {len(self._asked)} candidates asked for, unchanged and in "
                f"their order, got {len(infills)} other ones"
            )
        if F.shape != (len(X), self.problem.n_obj):
            raise ValueError(
                f"tell: F of shape {F.shape}: expected ({len(X)}, {self.problem.n_obj}), "
                "every candidate evaluated"
            )
        if not self.problem.has_constraints():
            return F, np.zeros(len(F)), np.zeros(len(F))
        CV, tolerated = (values[:, 0] for values in infills.get("CV", "FEAS"))
        feasible = Individual.default_config()["cv_eps"] >= CV
        return F, np.where(feasible, 0.0, CV), np.where(tolerated, 0.0, CV)

    def _set_optimum(self) -> None:
        self.opt = self.front.individuals


def default_termination(n_walkers: int) -> Termination:
    """`EXECUTIONS` generations, shared among the walkers: a fixed number of evaluations.

    It is counted in generations, which is the same and also ends a run whose candidates are
    evaluated without pymoo's evaluator.
    """
    return MaximumGenerationTermination(max(1, EXECUTIONS // n_walkers))
