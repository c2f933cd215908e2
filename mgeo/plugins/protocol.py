"""Optional methods of a problem: their defaults, and functions that call them.

The rest of the package calls problems through these functions, which accept any pymoo problem.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar, Concatenate, NamedTuple, ParamSpec, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from mgeo._typing import FloatArray
from mgeo.evaluation.individuals import get_variable_names
from mgeo.plugins.discovery import PluginError, convert_plugin_errors

if TYPE_CHECKING:
    from pymoo.core.problem import Problem

    from mgeo.documents import ProblemSize
    from mgeo.plugins.view import View

P = ParamSpec("P")
T = TypeVar("T")


class ProblemMixin:
    """Mixin for pymoo problems that adds defaults for all optional methods used by mgeo.

    mgeo accepts any pymoo `Problem` and uses the optional methods that the problem defines. A
    problem need not derive from this class, which only adds the defaults. All designs are rows of
    float arrays; the value of a choice variable is the index of its option.

    Attributes
    ----------
    var_names, obj_names, constraint_names : sequence of str, optional
        Names, with units, of variables, objectives and inequality constraints. The defaults are
        ``x1``, ``f1`` and ``g1``, and so on.
    obj_labels : sequence of str, optional
        Short names of the objectives, for labels of solutions such as ``min-mass``. The defaults
        are the names of the objectives without units.
    preset_descriptions : mapping of str to str
        Description of each preset in a few words, for ``mgeo problems``.
    function_name : str
        Name of the test function, if the problem is one of several instances or sizes of a
        function. Studies average over the instances of a function before they compare algorithms.

    Examples
    --------
    >>> import numpy as np
    >>> from pymoo.problems.multi import ZDT1
    >>> from mgeo import ProblemMixin
    >>> class ZDT1WithInitialDesigns(ProblemMixin, ZDT1):
    ...     def suggest_initial_designs(self, n, random_state):
    ...         return np.zeros((n, self.n_var))
    >>> problem = ZDT1WithInitialDesigns(n_var=3)
    >>> problem.suggest_initial_designs(2, np.random.default_rng(1)).shape
    (2, 3)
    """

    var_names: Sequence[str] | None = None
    obj_names: Sequence[str] | None = None
    obj_labels: Sequence[str] | None = None
    constraint_names: Sequence[str] | None = None
    preset_descriptions: ClassVar[Mapping[str, str]] = MappingProxyType({})
    function_name: str = ""

    def view(self, X: ArrayLike) -> View:
        """Return a `View` that presents designs of this problem as tables, figures and text.

        Parameters
        ----------
        X : array_like, shape (n, n_var)
            Designs; n may be 0.
        """
        from mgeo.plugins.view import View

        return View(self, X)

    def to_options(self) -> dict[str, Any] | None:
        """Return a dict of options from which `from_options` can rebuild this problem.

        The values must be JSON values. None, the default, means that the constructor of the class
        needs no arguments.
        """
        return None

    @classmethod
    def from_options(cls, options: Mapping[str, Any]) -> Any:
        """Build a problem from a dict of options. By default, pass them to the constructor."""
        return cls(**options)

    @classmethod
    def read_files(cls, options: Mapping[str, Any], folder: Path) -> dict[str, Any]:
        """Read the files that a scenario refers to, and return options without file paths.

        Parameters
        ----------
        options : mapping
            Content of the scenario file.
        folder : Path
            Folder of the scenario file, to which paths in `options` are relative.

        Returns
        -------
        dict of str to value
            New options with file contents in place of paths. By default, the options unchanged.
        """
        return dict(options)

    def to_robust(self) -> Problem | None:
        """Return a version of this problem that minimizes quantiles over random errors, or None.

        The option ``--robust`` of the command line solves the returned problem, which must define
        `to_options`. The default is None.
        """
        return None

    def suggest_initial_designs(
        self, n: int, random_state: np.random.Generator
    ) -> FloatArray | None:
        """Return n initial designs for a search, or None by default.

        The option ``--initial-designs`` of the command line calls this method.

        Parameters
        ----------
        n : int
            Number of designs.
        random_state : numpy.random.Generator

        Returns
        -------
        array, shape (n, n_var), or None
            None, the default, if the problem suggests no initial designs.
        """
        return None

    def refine(self, X: FloatArray) -> Iterator[FloatArray] | None:
        """Return an iterator over the designs after each step of a local search.

        Parameters
        ----------
        X : array, shape (n, n_var)
            Designs of the front.

        Returns
        -------
        iterator of arrays, shape (m, n_var), or None
            Designs after each step. The first n rows are candidates to replace the rows of `X`;
            further rows are new designs, and m never decreases. mgeo ignores designs that are
            infeasible or worse. The iterator must be deterministic. ``--dry-run`` uses its length
            hint, if any. None, the default, if the problem has no local refinement.
        """
        return None

    def recommend_settings(self) -> dict[str, Any]:
        """Return a dict of the ``mgeo solve`` settings that suit this problem.

        Returns
        -------
        dict of str to value
            Any of the keys ``initial_designs``, the number of suggested initial designs;
            ``refine``, True to refine the front at the end; and ``evaluations``, the number of
            evaluations of a run that ends with a refinement.
        """
        return {}

    def at_fidelity(self, fidelity: int) -> Problem:
        """Return this problem at a fidelity level; lower levels are cheaper and less accurate.

        Parameters
        ----------
        fidelity : int
            Fidelity level of `mgeo.MGEOStaged`, 0 for the cheapest and least accurate one.

        Returns
        -------
        Problem
            By default, the problem itself.
        """
        return self

    def map_to_indicator_space(self, F: ArrayLike) -> FloatArray | None:
        """Transform objectives for quality indicators such as the hypervolume.

        Parameters
        ----------
        F : array_like, shape (n, n_obj)
            Objectives.

        Returns
        -------
        array, shape (n, n_obj), or None
            Transformed objectives. The transformation must preserve Pareto dominance; the reference
            point of the hypervolume is (1, ..., 1). With None, the default, objectives are scaled
            by the extent of the combined front of all runs of a study.
        """
        return None

    @classmethod
    def parse_document(cls, document: Mapping[str, Any]) -> tuple[Mapping[str, Any], Any] | None:
        """Read the problem options and a design from a JSON document.

        Parameters
        ----------
        document : mapping
            Content of a JSON file.

        Returns
        -------
        options, design : mapping and array_like, or None
            None, the default, if the document does not have the format of this problem.
        """
        return None

    def build_document(self, x: FloatArray) -> dict[str, Any] | None:
        """Return a JSON-serializable dict of a design in the format of `parse_document`.

        Parameters
        ----------
        x : array, shape (n_var,)
            Design.

        Returns
        -------
        dict or None
            None, the default, selects the format of mgeo, which includes the name of the problem.
        """
        return None


def call_optional(
    owner: Any, method: Callable[Concatenate[Any, P], T], *args: P.args, **kwargs: P.kwargs
) -> T:
    """Call an optional method, or its default implementation if the owner lacks the method.

    Parameters
    ----------
    owner : Problem or View
        Object that may define the method.
    method : function
        Default implementation: a method of `ProblemMixin` or `View`.
    *args, **kwargs
        Arguments of the method.

    Raises
    ------
    PluginError
        If the method raises.
    """
    name = method.__name__
    problem = getattr(owner, "problem", owner)
    with convert_plugin_errors(f"{name} of problem {type(problem).__name__} raised"):
        implementation: Callable[..., T] = getattr(owner, name, None) or partial(method, owner)
        return implementation(*args, **kwargs)


def has_override(owner: Any, method: Callable[..., Any]) -> bool:
    """Return True if a problem or view overrides the default of an optional method.

    Parameters
    ----------
    owner : Problem or View
    method : function
        Default implementation, for example ``View.describe``.
    """
    implementation = getattr(owner, method.__name__, None)
    return implementation is not None and _unwrap(implementation) is not _unwrap(method)


def _unwrap(method: Any) -> Any:
    return getattr(method, "__func__", method)


def get_column_names(problem: Problem) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return the names of the variables and the names of the objectives.

    Variables are named by ``var_names`` of the problem, else by the keys of its ``vars``, else x1,
    x2, ...; objectives by ``obj_names``, else f1, f2, ....

    Raises
    ------
    PluginError
        If the number of names is wrong, or a name occurs twice.
    """
    variables = _read_names(problem, "var_names", "x", problem.n_var, get_variable_names(problem))
    objectives = _read_names(problem, "obj_names", "f", problem.n_obj)
    both = set(variables) & set(objectives)
    if both:
        raise PluginError(f"{min(both)!r} names both a variable and an objective")
    return variables, objectives


def get_constraint_names(problem: Problem) -> tuple[str, ...]:
    """Return the names of all constraints, inequalities first.

    Inequalities are named by ``constraint_names`` of the problem, else g1, g2, ...; equalities are
    h1, h2, ....

    Raises
    ------
    PluginError
        If the number of names is wrong, or a name occurs twice.
    """
    equalities = tuple(f"h{j + 1}" for j in range(problem.n_eq_constr))
    return (*_read_names(problem, "constraint_names", "g", problem.n_ieq_constr), *equalities)


def _read_names(
    problem: Problem, attribute: str, letter: str, count: int, declared: Sequence[str] | None = None
) -> tuple[str, ...]:
    names = getattr(problem, attribute, None)
    if names is None:
        names = declared or [f"{letter}{i + 1}" for i in range(count)]
    names = tuple(names)
    if len(set(names)) != count or len(names) != count:
        raise PluginError(
            f"{attribute} of {type(problem).__name__} = {list(names)}: expected {count} different "
            "names"
        )
    return names


def describe_size(problem: Problem) -> ProblemSize:
    """Return variable names, objective names and the number of constraints as a dict."""
    variables, objectives = get_column_names(problem)
    return {
        "variables": list(variables),
        "objectives": list(objectives),
        "constraints": int(problem.n_ieq_constr + problem.n_eq_constr),
    }


def get_objective_labels(problem: Problem) -> tuple[str, ...]:
    """Return short objective names for solution labels such as ``min-mass``."""
    labels = getattr(problem, "obj_labels", None)
    if labels is not None:
        return tuple(labels)
    names = get_column_names(problem)[1]
    return tuple(re.sub(r" *\[.*\]$", "", name).replace(" ", "-") for name in names)


def get_indicator_map(problem: Problem) -> Callable[[ArrayLike], FloatArray] | None:
    """Return the function that maps objectives to the problem's indicator space.

    None if the problem does not define `ProblemMixin.map_to_indicator_space`.
    """
    if not has_override(problem, ProblemMixin.map_to_indicator_space):
        return None
    return lambda F: np.asarray(
        call_optional(problem, ProblemMixin.map_to_indicator_space, F), dtype=float
    )


def get_options(problem: Problem) -> dict[str, Any] | None:
    """Return a dict of options from which the problem can be rebuilt, or None.

    See `ProblemMixin.to_options`.
    """
    return call_optional(problem, ProblemMixin.to_options)


def get_robust_problem(problem: Problem) -> Problem:
    """Return the version of a problem that minimizes quantiles over random errors.

    See `ProblemMixin.to_robust`.

    Raises
    ------
    ValueError
        If the problem does not define a robust version.
    """
    robust_problem = call_optional(problem, ProblemMixin.to_robust)
    if robust_problem is None:
        raise ValueError(f"{type(problem).__name__} has no to_robust(): solve it without --robust")
    return robust_problem


def iterate_refinement(problem: Problem, X: FloatArray) -> Generator[FloatArray]:
    """Run the local search of a problem, and yield all designs after each step.

    See `ProblemMixin.refine`.

    Parameters
    ----------
    problem : Problem
    X : array, shape (n, n_var)
        Designs of the front.

    Yields
    ------
    array, shape (m, n_var)
        Refined designs; m never decreases.

    Raises
    ------
    PluginError
        If the problem has no local refinement, or if the refinement raises, returns arrays of
        another width or returns fewer designs than in the step before. Callers catch this error to
        keep the unrefined front.
    """
    steps = call_optional(problem, ProblemMixin.refine, X.copy())
    name = type(problem).__name__
    if steps is None:
        raise PluginError(f"problem {name} has no refine(): solve it without --refine")
    iterator, n_rows = iter(steps), len(X)
    while True:
        with convert_plugin_errors(f"refine of problem {name} raised"):
            table = next(iterator, None)
        if table is None:
            return
        designs = np.array(table, dtype=float)
        expected = n_rows, X.shape[1]
        if designs.ndim != 2 or designs.shape[1] != expected[1] or len(designs) < n_rows:
            raise PluginError(
                f"refine(X) of problem {name} returns shape {designs.shape}: expected {expected}, "
                "or more rows"
            )
        n_rows = len(designs)
        yield designs


class RecommendedSettings(NamedTuple):
    """Settings of ``mgeo solve`` that a problem recommends.

    Attributes
    ----------
    initial_designs : int
        Number of initial designs that the problem suggests.
    refine : bool
        True to refine the front at the end.
    evaluations : int or None
        Number of evaluations of a run that ends with a refinement.
    """

    initial_designs: int = 0
    refine: bool = False
    evaluations: int | None = None


def get_recommended_settings(problem: Problem) -> RecommendedSettings:
    """Return the ``mgeo solve`` settings recommended by a problem, or the defaults."""
    return RecommendedSettings(**call_optional(problem, ProblemMixin.recommend_settings))


def get_function_name(problem: Problem) -> str:
    """Return the name of the test function that a problem implements, or an empty string."""
    return str(getattr(problem, "function_name", ""))
