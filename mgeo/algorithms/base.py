"""The loop that all algorithms of the family share, as a pymoo `Algorithm`."""

import inspect
from abc import ABC, abstractmethod
from typing import Any

import numpy as np
from pymoo.core.algorithm import Algorithm
from pymoo.core.population import Population
from pymoo.core.problem import Problem
from pymoo.core.termination import Termination
from pymoo.termination.max_gen import MaximumGenerationTermination

from mgeo.algorithms.acceptance import IntArray, pick, rank
from mgeo.algorithms.parameters import integer, number, refuse_unknown
from mgeo.archive import ParetoArchive
from mgeo.display import ArchiveOutput
from mgeo.dominance import FloatArray
from mgeo.evaluation import TolerantEvaluator

EXECUTIONS = 5000  # generations of all walkers together, unless a termination is given


def _keywords(cls: type) -> frozenset[str]:
    parameters = inspect.signature(cls).parameters.values()
    return frozenset(p.name for p in parameters if p.kind is not p.VAR_KEYWORD)


_OPTIONS = _keywords(Algorithm)


class ExtremalOptimization(Algorithm, ABC):
    """Generalized extremal optimization with any number of objectives.

    `n_runs` walkers go side by side. In a generation each one proposes candidates, every one of
    which differs from it in a single coordinate. All candidates are evaluated in one batch and
    put to the Pareto test. Then each walker draws an objective, ranks its candidates by it and
    accepts one with a probability proportional to k^-tau (one of each group, if the leaf has
    several groups), be it better or not.

    A walker never looks at the archive or at other walkers, and owns a random stream (child i of
    the seed), so running side by side is the same as running one after the other. Its stream
    gives, in this order: what the leaf draws to start; then for each generation what the leaf
    draws to propose, one uniform for the objective, one per candidate to break ties and one per
    group to pick a rank. Starting points are not evaluated.

    A leaf supplies `_start`, `_layout`, `_propose` and `_decode`, and nothing else of the loop.
    It keeps each parameter of its constructor under the parameter's name, and names in
    `_state_arrays` every array that it carries from one generation to the next.

    Parameters
    ----------
    tau : greediness of the acceptance, >= 0.
    n_runs : number of walkers.
    archive_size : largest number of points in the front, None for all of them.
    options : options of every pymoo algorithm: `termination`, `callback`, `verbose`, ...

    Attributes
    ----------
    front : the `ParetoArchive`; `opt`, and so `res.X` and `res.F`, are its points.
    walkers : (n_runs, n_coordinates) where the walkers stand.
    streams : one `numpy.random.Generator` per walker.
    n_generations : how many generations are complete.
    """

    _state_arrays: tuple[str, ...] = ("walkers",)
    takes_nan = True  # for `TolerantEvaluator`: a failed candidate is ranked last, not archived

    def __init__(
        self,
        *,
        tau: float,
        n_runs: int,
        archive_size: int | None,
        options: dict[str, Any],
    ) -> None:
        refuse_unknown(options, _keywords(type(self)) | _OPTIONS, type(self).__name__)
        options.setdefault("output", ArchiveOutput())
        options.setdefault("evaluator", TolerantEvaluator())
        super().__init__(**options)
        self.tau = number("tau", tau, low=0)
        self.n_runs = integer("n_runs", n_runs, low=1)
        self.archive_size = (
            None if archive_size is None else integer("archive_size", archive_size, low=1)
        )
        self.n_generations = 0
        self.front: ParetoArchive
        self.walkers: FloatArray
        self.streams: list[np.random.Generator]
        self._coordinates: IntArray
        self._values: FloatArray
        self._asked: FloatArray | None = None

    def setup(
        self, problem: Problem, verbose: bool = False, progress: bool = False, **options: Any
    ) -> "ExtremalOptimization":
        """Bind the algorithm to a problem and place the walkers.

        Parameters
        ----------
        problem : a pymoo problem of real variables with finite bounds.
        verbose, progress, options : as for every pymoo algorithm.

        Raises
        ------
        TypeError : for an option that pymoo's algorithms do not have; parameters of the
            algorithm itself belong into its constructor.
        ValueError : if the problem has other variables or no finite bounds.
        """
        name = type(self).__name__
        if misplaced := sorted(_keywords(type(self)) & options.keys()):
            raise TypeError(f"{misplaced[0]} is a parameter of {name}(...), not of a run")
        refuse_unknown(options, _OPTIONS, f"setup (or minimize) of {name}")
        _check_problem(problem)
        self._parameters = {key: getattr(self, key) for key in _keywords(type(self))}
        if options.get("termination", self.termination) is None:
            options["termination"] = default_termination(self.n_runs)
        super().setup(problem, verbose=verbose or self.verbose, progress=progress, **options)
        return self

    # ---- what a leaf supplies -------------------------------------------------------------

    @abstractmethod
    def _start(self) -> FloatArray:
        """(n_runs, n_coordinates) where the walkers begin."""

    @abstractmethod
    def _layout(self) -> IntArray:
        """(n_groups, group_size) coordinate each candidate changes; one a group is accepted."""

    @abstractmethod
    def _propose(self) -> FloatArray:
        """(n_runs, n_groups, group_size) new values of the coordinates of `_layout`."""

    @abstractmethod
    def _decode(self, points: FloatArray) -> FloatArray:
        """(..., n_var) design vectors of points given by their (..., n_coordinates)."""

    # ---- the loop, through pymoo's hooks --------------------------------------------------

    def _setup(self, problem: Problem, **options: Any) -> None:
        seeds = self.random_state.bit_generator.seed_seq.spawn(self.n_runs)
        self.streams = [np.random.default_rng(seed) for seed in seeds]
        try:
            self.front = ParetoArchive(problem.n_obj, self.archive_size)
        except ValueError as error:
            raise ValueError(f"archive_size = {self.archive_size}: {error}") from error
        self.n_generations = 0
        self._coordinates = self._layout()
        self.walkers = self._start()

    def _initialize_infill(self) -> Population:
        return self._infill()

    def _initialize_advance(self, infills: Any = None, **kwargs: Any) -> None:
        self._advance(infills, **kwargs)

    def _infill(self) -> Population:
        self._values = self._propose()
        n_candidates = self._coordinates.size
        points = np.repeat(self.walkers[:, None, :], n_candidates, axis=1)
        changed = self._coordinates.ravel()
        points[:, np.arange(n_candidates), changed] = self._values.reshape(self.n_runs, -1)
        self._asked = self._decode(points).reshape(self.n_runs * n_candidates, -1)
        return Population.new("X", self._asked)

    def _advance(self, infills: Any = None, **kwargs: Any) -> None:
        F, violation = self._told(infills)
        self.front.add(F, infills, violation)
        self._accept(F, violation)
        self.pop = infills
        self._asked = None
        self.n_generations = self.n_iter

    def _accept(self, F: FloatArray, violation: FloatArray) -> None:
        groups, size = self._coordinates.shape
        draws = np.stack([stream.random(1 + groups * (size + 1)) for stream in self.streams])
        walker, group = np.ogrid[: self.n_runs, :groups]
        objective = (draws[:, 0] * F.shape[1]).astype(np.intp)
        by_walker = F.reshape(self.n_runs, groups * size, F.shape[1])
        f = np.take_along_axis(by_walker, objective[:, None, None], axis=2)
        f[~np.isfinite(by_walker).all(axis=2)] = np.nan
        shape = (self.n_runs, groups, size)
        ties = draws[:, 1 : 1 + groups * size].reshape(shape)
        ranking = rank(f.reshape(shape), violation.reshape(shape), ties)
        place = pick(draws[:, 1 + groups * size :], size, self.tau)
        accepted = ranking[walker, group, place]
        changed = self._coordinates[group, accepted]
        self.walkers[walker, changed] = self._values[walker, group, accepted]

    def _told(self, infills: Any) -> tuple[FloatArray, FloatArray]:
        """Objectives (n, n_obj) and constraint violations (n,), 0 where feasible."""
        if self._asked is None or infills is None:
            raise ValueError(
                f"tell(infills={'...' if infills is not None else None}): expected the "
                "candidates of the ask() before, once"
            )
        X, F = infills.get("X", "F")
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
            return F, np.zeros(len(F))
        CV, feasible = infills.get("CV", "FEAS")
        return F, np.where(feasible[:, 0], 0.0, CV[:, 0])

    def _set_optimum(self) -> None:
        self.opt = self.front.individuals


def default_termination(n_runs: int) -> Termination:
    """`EXECUTIONS` generations, shared among the walkers: a fixed number of evaluations.

    It is counted in generations, which is the same and also ends a run whose candidates are
    evaluated without pymoo's evaluator.
    """
    return MaximumGenerationTermination(max(1, EXECUTIONS // n_runs))


def _check_problem(problem: Problem) -> None:
    name = type(problem).__name__
    vtype = problem.vtype
    if getattr(problem, "vars", None) is not None or not (
        vtype is None or (isinstance(vtype, type) and issubclass(vtype, float))
    ):
        raise ValueError(f"{name} has vtype = {vtype!r} or typed variables: expected real ones")
    for key, bound in (("xl", problem.xl), ("xu", problem.xu)):
        if bound is None or not np.isfinite(bound).all():
            raise ValueError(f"{name}.{key} = {bound}: expected a finite bound for every variable")
    if np.any(problem.xl > problem.xu):
        raise ValueError(f"{name}: expected xl <= xu, got xl = {problem.xl}, xu = {problem.xu}")
