"""Optional parts of a problem: a base class with a default for each, and how mgeo calls them."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Concatenate, NamedTuple, ParamSpec, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from mgeo._typing import FloatArray
from mgeo.evaluation.individuals import variable_names
from mgeo.plugins.discovery import PluginError, code_of_others

if TYPE_CHECKING:
    from pymoo.core.problem import Problem

    from mgeo.plugins.view import View

P = ParamSpec("P")
T = TypeVar("T")


class ProblemMixin:
    """Optional parts of a problem, each with a default.

    mgeo accepts any pymoo `Problem` and uses the parts that the problem defines. A problem need not
    inherit this class; a problem that does has the defaults as methods of its own. All designs are
    numbers: a choice is the index of its option.

    Attributes
    ----------
    var_names, obj_names, constraint_names : sequence of str, optional
        Names, with units, of variables, objectives and inequality constraints. Default: ``x1``...,
        ``f1``... and ``g1``....
    instance_of : str
        Function of which the problem is one instance or size. Studies average over the instances
        of a function before they compare algorithms.

    Examples
    --------
    >>> import numpy as np
    >>> from pymoo.problems.multi import ZDT1
    >>> from mgeo import ProblemMixin
    >>> class Started(ProblemMixin, ZDT1):
    ...     def starts(self, n, random_state):
    ...         return np.zeros((n, self.n_var))
    >>> problem = Started(n_var=3)
    >>> problem.starts(2, np.random.default_rng(1)).shape, problem.recommended()
    ((2, 3), {})
    """

    var_names: Sequence[str] | None = None
    obj_names: Sequence[str] | None = None
    constraint_names: Sequence[str] | None = None
    instance_of: str = ""

    def view(self, X: ArrayLike) -> View:
        """Return the view that people are shown of designs, shape (n, n_var), n >= 0."""
        from mgeo.plugins.view import View

        return View(self, X)

    def options(self) -> dict[str, Any] | None:
        """Return the options that build this problem again, as JSON values.

        None, the default, stands for a problem that is built without arguments.
        """
        return None

    @classmethod
    def from_options(cls, options: Mapping[str, Any]) -> Any:
        """Build the problem from options; by default they are the constructor's keywords."""
        return cls(**options)

    @classmethod
    def read_files(cls, options: Mapping[str, Any], folder: Path) -> dict[str, Any]:
        """Return the options of a scenario file in `folder` with all files that they name read."""
        return dict(options)

    def robust(self) -> Problem | None:
        """Return the problem whose objectives are robust quantiles, for ``--robust``, or None.

        The robust problem has `options`.
        """
        return None

    def starts(self, n: int, random_state: np.random.Generator) -> FloatArray | None:
        """Return n good initial designs, shape (n, n_var), for ``--starts``, or None."""
        return None

    def refine(self, X: FloatArray) -> Iterator[FloatArray] | None:
        """Return an iterator over better designs in place of those of a front, or None.

        Each step gives all designs, shape (m, n_var): first those in place of the n rows of `X`,
        then further ones, never fewer than in the step before. Worse and infeasible designs are
        not taken. The same `X` gives the same steps. A length hint serves ``--dry-run``.
        """
        return None

    def recommended(self) -> dict[str, Any]:
        """Return the defaults of ``mgeo solve``: keys ``starts``, ``polish`` and ``evaluations``.

        They are the number of initial designs, whether the front is refined, and the evaluations
        of a run that ends with a refinement.
        """
        return {}

    def at_stage(self, stage: int) -> Problem:
        """Return the problem at a fidelity level of a search, from 0, lowest; see `MGEOStaged`."""
        return self

    def indicator_space(self, F: ArrayLike) -> FloatArray | None:
        """Return objectives as indicators see them, shape (n, n_obj), or None.

        The map keeps dominance, and the reference point of the hypervolume is (1, ..., 1). With
        None, the default, indicators scale objectives by the fronts that were found.
        """
        return None

    @classmethod
    def solution_of(cls, document: Mapping[str, Any]) -> tuple[Mapping[str, Any], Any] | None:
        """Return options and design of a JSON document of this problem; None for another one."""
        return None

    def document_of(self, x: FloatArray) -> dict[str, Any] | None:
        """Return a design, shape (n_var,), as the JSON document that `solution_of` reads.

        None, the default, stands for mgeo's own format, which names the problem.
        """
        return None


def ask(
    owner: Any, method: Callable[Concatenate[Any, P], T], *args: P.args, **kwargs: P.kwargs
) -> T:
    """Call an optional method of a problem, or a method of its view.

    Parameters
    ----------
    owner : Problem or View
    method : function
        Method of `ProblemMixin` or `View`; the method itself where the owner does not define one.

    Raises
    ------
    PluginError
        If the method raises.
    """
    name = method.__name__
    problem = getattr(owner, "problem", owner)
    with code_of_others(f"{name} of problem {type(problem).__name__} raised"):
        own: Callable[..., T] = getattr(owner, name, None) or partial(method, owner)
        return own(*args, **kwargs)


def is_own(owner: Any, method: Callable[..., Any]) -> bool:
    """Return whether a problem or view defines a method itself, such as ``View.describe``."""
    own = getattr(owner, method.__name__, None)
    return own is not None and _function(own) is not _function(method)


def _function(method: Any) -> Any:
    return getattr(method, "__func__", method)


def column_names(problem: Problem) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return the names of the variables and of the objectives.

    They are the problem's ``var_names`` and ``obj_names``, the keys of its ``vars``, or x1, x2, ...
    and f1, f2, ....

    Raises
    ------
    PluginError
        If a name is missing or occurs twice.
    """
    variables = _names(problem, "var_names", "x", problem.n_var, variable_names(problem))
    objectives = _names(problem, "obj_names", "f", problem.n_obj)
    both = set(variables) & set(objectives)
    if both:
        raise PluginError(f"{min(both)!r} names both a variable and an objective")
    return variables, objectives


def constraint_names(problem: Problem) -> tuple[str, ...]:
    """Return ``constraint_names``, or g1, g2, ..., of inequalities, and h1, ... of equalities.

    Raises
    ------
    PluginError
        If a name is missing or occurs twice.
    """
    equalities = tuple(f"h{j + 1}" for j in range(problem.n_eq_constr))
    return (*_names(problem, "constraint_names", "g", problem.n_ieq_constr), *equalities)


def _names(
    problem: Problem, attribute: str, letter: str, count: int, declared: Sequence[str] | None = None
) -> tuple[str, ...]:
    given = getattr(problem, attribute, None)
    if given is None:
        given = declared or [f"{letter}{i + 1}" for i in range(count)]
    names = tuple(given)
    if len(set(names)) != count or len(names) != count:
        raise PluginError(
            f"{attribute} of {type(problem).__name__} = {list(names)}: expected {count} different "
            "names"
        )
    return names


def problem_size(problem: Problem) -> dict[str, Any]:
    """Return names of variables and objectives, and the number of constraints, as JSON values."""
    variables, objectives = column_names(problem)
    return {
        "variables": list(variables),
        "objectives": list(objectives),
        "constraints": int(problem.n_ieq_constr + problem.n_eq_constr),
    }


def indicator_space(problem: Problem) -> Callable[[ArrayLike], FloatArray] | None:
    """Return the problem's ``indicator_space`` as a function; None if it defines none."""
    if not is_own(problem, ProblemMixin.indicator_space):
        return None
    return lambda F: np.asarray(ask(problem, ProblemMixin.indicator_space, F), dtype=float)


def options(problem: Problem) -> dict[str, Any] | None:
    """Return the problem's ``options()``, None if it has none."""
    return ask(problem, ProblemMixin.options)


def robust(problem: Problem) -> Problem:
    """Return the problem's ``robust()``.

    Raises
    ------
    ValueError
        If it has none.
    """
    found = ask(problem, ProblemMixin.robust)
    if found is None:
        raise ValueError(f"{type(problem).__name__} has no robust(): expected a run without it")
    return found


def refinement(problem: Problem, X: FloatArray) -> Generator[FloatArray]:
    """Yield the designs of each step of the problem's ``refine(X)``, shape (m, n_var).

    Raises
    ------
    PluginError
        If the problem has no refinement, or the refinement raises or loses designs: the front that
        it refines has taken a whole run.
    """
    steps = ask(problem, ProblemMixin.refine, X.copy())
    name = type(problem).__name__
    if steps is None:
        raise PluginError(f"problem {name} has no refine(): expected a run without --polish")
    iterator, least = iter(steps), len(X)
    while True:
        with code_of_others(f"refine of problem {name} raised"):
            table = next(iterator, None)
        if table is None:
            return
        designs = np.array(table, dtype=float)
        expected = least, X.shape[1]
        if designs.ndim != 2 or designs.shape[1] != expected[1] or len(designs) < least:
            raise PluginError(
                f"refine(X) of problem {name} gives shape {designs.shape}: expected {expected}, or "
                "more rows"
            )
        least = len(designs)
        yield designs


class Recommended(NamedTuple):
    """Defaults that a problem recommends for a run.

    Attributes
    ----------
    starts : number of initial designs that the problem suggests.
    polish : whether the front is refined at the end.
    evaluations : evaluations of a run that ends with a refinement.
    """

    starts: int = 0
    polish: bool = False
    evaluations: int | None = None


def recommended(problem: Problem) -> Recommended:
    """Return what the problem's ``recommended()`` gives."""
    return Recommended(**ask(problem, ProblemMixin.recommended))


def instance_of(problem: Problem) -> str:
    """Return the function of which the problem is one instance or size; empty for none."""
    return str(getattr(problem, "instance_of", ""))
