"""COCO functions as pymoo problems, with names such as ``bbob-biobj/f12/d10/i3``.

COCO (Hansen et al. 2021; https://coco-platform.org) is a platform for comparing optimizers. The
extra ``coco`` installs the distribution ``coco-experiment`` with the module ``cocoex``.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import lru_cache
from itertools import product
from threading import Lock
from typing import Any

import numpy as np
from pymoo.core.problem import Problem

from mgeo._typing import FloatArray

_NAME = re.compile(r"([a-z-]+)/f([\d,-]+)/d([\d,-]+)/i([\d,-]+)")
_SUITES = ("bbob", "bbob-biobj", "bbob-biobj-ext", "bbob-boxed", "bbob-largescale")
#: Largest instance of a biobjective function. COCO takes minutes to construct other instances.
_MAX_BIOBJECTIVE_INSTANCE = 15
_EXPECTED = "expected SUITE/fFUNCTION/dDIMENSION/iINSTANCE, as bbob-biobj/f12/d10/i3"
#: Number of COCO functions, and of COCO suites, that each process keeps in memory.
_CACHE_SIZE = 16
#: Lock for all calls of COCO, because functions of a suite share memory.
_LOCK = Lock()


class CocoProblem(Problem):
    """Test function of the COCO platform as a pymoo problem.

    The bounds are COCO's region of interest. The problem can be pickled, because each process
    creates its COCO objects at the first evaluation.

    Parameters
    ----------
    suite : str
        Name of the suite, such as "bbob-biobj" or "bbob".
    function, dimension, instance : int
        Function index, number of variables and instance, from 1.

    Raises
    ------
    ValueError
        If the extra ``coco`` is not installed, or the suite has no such function.
    """

    def __init__(self, suite: str, function: int, dimension: int, instance: int) -> None:
        self.suite, self.function, self.instance = suite, function, instance
        coco = _load_function(suite, function, dimension, instance)
        super().__init__(
            n_var=dimension,
            n_obj=coco.number_of_objectives,
            xl=np.array(coco.lower_bounds),
            xu=np.array(coco.upper_bounds),
            vtype=float,
        )

    @property
    def function_name(self) -> str:
        """Name of the COCO function, without instance and dimension."""
        return f"{self.suite} f{self.function}"

    def name(self) -> str:
        return f"{self.suite} f{self.function} d{self.n_var} i{self.instance}"

    def _evaluate(self, X: FloatArray, out: dict[str, Any], *args: Any, **kwargs: Any) -> None:
        coco = _load_function(self.suite, self.function, self.n_var, self.instance)
        with _LOCK:
            out["F"] = np.array([np.atleast_1d(coco(x)) for x in X])


def build_coco_problem(name: str) -> CocoProblem:
    """Build a COCO problem from a name such as ``bbob-biobj/f12/d10/i3``.

    Raises
    ------
    ValueError
        If the name has another form or contains ranges, and as for `CocoProblem`.
    """
    suite, *numbers = _split_name(name)
    if not all(number.isdigit() for number in numbers):
        raise ValueError(f"coco:{name}: expected one function, one dimension and one instance")
    function, dimension, instance = map(int, numbers)
    return CocoProblem(suite, function, dimension, instance)


def expand_ranges(name: str) -> Iterator[str]:
    """Yield all problem names in a COCO name with ranges, such as ``bbob/f1-24/d5,10/i1``.

    Raises
    ------
    ValueError
        If the name has another form.
    """
    suite, *ranges = _split_name(name)
    functions, dimensions, instances = (_parse_ranges(name, text) for text in ranges)
    for dimension, function, instance in product(dimensions, functions, instances):
        yield f"{suite}/f{function}/d{dimension}/i{instance}"


def _split_name(name: str) -> tuple[str, ...]:
    match = _NAME.fullmatch(name)
    if match is None:
        raise ValueError(f"coco:{name:.80}: {_EXPECTED}")
    return match.groups()


def _parse_ranges(name: str, text: str) -> list[int]:
    """Convert a text with integers and ranges, such as "1-3,7", to a list of integers."""
    numbers: list[int] = []
    for part in text.split(","):
        ends = re.fullmatch(r"(\d{1,4})(?:-(\d{1,4}))?", part)
        if ends is None or not 1 <= int(ends[1]) <= int(ends[2] or ends[1]):
            raise ValueError(f"coco:{name:.80}: {part!r:.20} is not a number or range; {_EXPECTED}")
        numbers += range(int(ends[1]), int(ends[2] or ends[1]) + 1)
    return numbers


@lru_cache(maxsize=_CACHE_SIZE)
def _load_function(suite: str, function: int, dimension: int, instance: int) -> Any:
    cocoex_suite = _load_suite(suite, instance)
    try:
        with _LOCK:
            return cocoex_suite.get_problem_by_function_dimension_instance(
                function, dimension, instance
            )
    except Exception as error:  # cocoex raises errors of several types.
        raise ValueError(
            f"COCO's suite {suite!r} has no function {function} in {dimension} dimensions, "
            f"instance {instance}"
        ) from error


@lru_cache(maxsize=_CACHE_SIZE)
def _load_suite(suite: str, instance: int) -> Any:
    if suite not in _SUITES:
        raise ValueError(f"COCO's suite {suite!r}: expected one of {', '.join(_SUITES)}")
    if "biobj" in suite and instance > _MAX_BIOBJECTIVE_INSTANCE:
        raise ValueError(
            f"instance {instance} of COCO's {suite}: expected 1 to {_MAX_BIOBJECTIVE_INSTANCE}"
        )
    try:
        import cocoex
    except ImportError as error:
        raise ValueError(
            "COCO's functions need the extra 'coco': pip install 'mgeo[coco]'"
        ) from error
    with _LOCK:
        # A suite with a single instance loads faster.
        return cocoex.Suite(suite, f"instances: {instance}", "")
