"""Construction of test problems from names with a prefix, such as ``pymoo:zdt1``."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pymoo.core.problem import Problem

#: Example of a test problem for each prefix, with its description.
EXAMPLES: Mapping[str, str] = {
    "pymoo:zdt1": "problem of pymoo, by its name",
    "shifted:zdt1": "zdt1 with wider bounds; no optimum lies on a bound",
    "coco:bbob-biobj/f1/d10/i1": "COCO: suite, function, dimension, instance",
}
#: Python distribution that the extra ``coco`` installs.
COCO_DISTRIBUTION = "coco-experiment"


def is_benchmark(name: str) -> bool:
    """Return True if a name denotes a test problem by a prefix such as ``pymoo:``."""
    prefix, colon, _ = name.partition(":")
    return bool(colon) and prefix in _BUILDERS


def build_benchmark(name: str, options: Mapping[str, Any]) -> Problem:
    """Build a test problem from its name and constructor options.

    Parameters
    ----------
    name : str
        Name with the prefix of one of the `EXAMPLES`.
    options : mapping
        Keywords of the constructor, such as ``n_var``. COCO functions have no options.

    Raises
    ------
    ValueError
        If there is no such problem, an option is unknown or invalid, or the extra is missing.
    """
    prefix, _, rest = name.partition(":")
    return _BUILDERS[prefix](rest, options)


def expand_name(name: str) -> list[str]:
    """Expand a test problem name with ranges to a list of problem names.

    Only names of COCO problems can have ranges, such as ``coco:bbob-biobj/f1-55/d5,10/i1``. Any
    other name is returned as the only entry.

    Raises
    ------
    ValueError
        If a COCO name or range has the wrong form.
    """
    prefix, _, rest = name.partition(":")
    if prefix != "coco":
        return [name]
    from mgeo.benchmarks.coco import expand_ranges

    return [f"coco:{each}" for each in expand_ranges(rest)]


def list_distributions(name: str) -> list[str]:
    """List the Python packages besides pymoo that provide a test problem.

    Results of a study depend on the versions of these packages.
    """
    return [COCO_DISTRIBUTION] if name.startswith("coco:") else []


def format_short_name(name: str) -> str:
    """Return a short problem name for tables, such as ``zdt1`` for ``pymoo:zdt1``."""
    prefix, _, rest = name.partition(":")
    if not is_benchmark(name):
        return name
    if prefix == "coco":
        return rest.replace("-", "_").replace("/", " ")
    return rest if prefix == "pymoo" else f"{prefix} {rest}"


def _build_pymoo(name: str, options: Mapping[str, Any]) -> Problem:
    from pymoo.problems import get_problem
    from pymoo.problems.multi.zdt import ZDT5

    from mgeo.validation.constructors import reject_unknown_options

    try:
        problem: Problem = get_problem(name, **options)
    except Exception as error:  # pymoo raises Exception itself for unknown names.
        if type(error) is Exception:
            raise ValueError(
                f"pymoo has no problem {name!r}: expected a name such as zdt1, dtlz2 or wfg4"
            ) from error
        raise ValueError(f"problem 'pymoo:{name}' with {dict(options)}: {error}") from error
    reject_unknown_options(f"pymoo:{name}", type(problem), options)
    if isinstance(problem, ZDT5):
        # ZDT5 is defined on bit strings (Zitzler, Deb & Thiele 2000); pymoo declares floats.
        problem.vtype = bool
    return problem


def _build_shifted(name: str, options: Mapping[str, Any]) -> Problem:
    from mgeo.benchmarks.shifted import ShiftedProblem

    return ShiftedProblem(_build_pymoo(name, options))


def _build_coco(name: str, options: Mapping[str, Any]) -> Problem:
    from mgeo.benchmarks.coco import build_coco_problem

    for key in options:
        raise ValueError(
            f"problem 'coco:{name}' has no option {key!r}: its name specifies all parameters"
        )
    return build_coco_problem(name)


_BUILDERS: Mapping[str, Callable[[str, Mapping[str, Any]], Problem]] = {
    "pymoo": _build_pymoo,
    "shifted": _build_shifted,
    "coco": _build_coco,
}
