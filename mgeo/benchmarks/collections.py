"""Which test problem a name with a prefix means: ``pymoo:zdt1``, ``shifted:zdt1``, ``coco:...``."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pymoo.core.problem import Problem

#: Test problems by their prefixes, and how they are named.
PREFIXES: Mapping[str, str] = {
    "pymoo": "pymoo:zdt1",
    "shifted": "shifted:zdt1",
    "coco": "coco:bbob-biobj/f1/d10/i1",
}
COCO = "coco-experiment"  # the distribution of the extra


def is_benchmark(name: str) -> bool:
    """Return whether a problem's name has the prefix of a collection."""
    prefix, colon, _ = name.partition(":")
    return bool(colon) and prefix in PREFIXES


def build_benchmark(name: str, options: Mapping[str, Any]) -> Problem:
    """Build the problem of a name with a prefix.

    Raises
    ------
    ValueError
        If the collection has no such problem, it refuses an option, or an extra is missing.
    """
    prefix, _, rest = name.partition(":")
    return _COLLECTIONS[prefix](rest, options)


def expanded(name: str) -> list[str]:
    """Expand a name with ranges, ``coco:bbob-biobj/f1-55/d5,10/i1``; others stay as they are.

    Raises
    ------
    ValueError
        For ranges that cannot be read.
    """
    prefix, _, rest = name.partition(":")
    if prefix != "coco":
        return [name]
    from mgeo.benchmarks.coco import names

    return [f"coco:{each}" for each in names(rest)]


def distributions(name: str) -> list[str]:
    """Return the distributions besides pymoo that compute a problem's values."""
    return [COCO] if name.startswith("coco:") else []


def short_name(name: str) -> str:
    """Return the name of a problem in tables: in words, without the prefix of pymoo."""
    prefix, _, rest = name.partition(":")
    if not is_benchmark(name):
        return name
    if prefix == "coco":
        return rest.replace("-", "_").replace("/", " ")
    return rest if prefix == "pymoo" else f"{prefix} {rest}"


def _pymoo(name: str, options: Mapping[str, Any]) -> Problem:
    from pymoo.problems import get_problem
    from pymoo.problems.multi.zdt import ZDT5

    from mgeo.validation.constructors import refuse_unknown_options

    try:
        problem: Problem = get_problem(name, **options)
    except Exception as error:  # pymoo raises bare ones for names it does not know
        raise ValueError(f"pymoo has no problem {name!r} with {dict(options)}: {error}") from error
    refuse_unknown_options(f"pymoo:{name}", type(problem), options)
    if isinstance(problem, ZDT5):
        problem.vtype = bool  # Zitzler, Deb & Thiele 2000: strings of bits; pymoo says float
    return problem


def _shifted(name: str, options: Mapping[str, Any]) -> Problem:
    from mgeo.benchmarks.shifted import Shifted

    return Shifted(_pymoo(name, options))


def _coco(name: str, options: Mapping[str, Any]) -> Problem:
    from mgeo.benchmarks.coco import problem

    for key in options:
        raise ValueError(f"problem 'coco:{name}' has no option {key!r}: all is in its name")
    return problem(name)


_COLLECTIONS: Mapping[str, Callable[[str, Mapping[str, Any]], Problem]] = {
    "pymoo": _pymoo,
    "shifted": _shifted,
    "coco": _coco,
}
