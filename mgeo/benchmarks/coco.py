"""COCO's functions as pymoo problems: ``bbob-biobj/f12/d10/i3``.

Of the platform for comparing optimizers (Hansen et al. 2021; https://coco-platform.org), the extra
``coco`` installs what evaluates them: distribution ``coco-experiment``, module ``cocoex``.

Its own observer writes data of a run that its post-processing, `cocopp`, reads.
"""

from __future__ import annotations

import re
import secrets
import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import lru_cache
from itertools import product
from pathlib import Path
from threading import Lock
from typing import Any

import numpy as np
from pymoo.core.population import Population
from pymoo.core.problem import Problem

from mgeo._typing import FloatArray

_NAME = re.compile(r"([a-z-]+)/f([\d,-]+)/d([\d,-]+)/i([\d,-]+)")
_SUITES = ("bbob", "bbob-biobj", "bbob-biobj-ext", "bbob-boxed", "bbob-largescale")
_BIOBJECTIVE_INSTANCES = 15  # others are not COCO's own: it searches for them, for minutes
_EXPECTED = "expected SUITE/fFUNCTION/dDIMENSION/iINSTANCE, as bbob-biobj/f12/d10/i3"
_MOST = 100_000  # a number, and how many names ranges may stand for
_KEPT = 16  # problems of COCO, per process

# COCO's functions compute in memory of their own, and its suites in common one.
_LOCK = Lock()


class CocoProblem(Problem):
    """One function of one suite, in so many dimensions, of one instance.

    Bounds are COCO's region of interest. What COCO keeps of a function in memory is not part of
    the problem: every process makes its own when it first evaluates, and threads take turns.

    Parameters
    ----------
    suite : as COCO names it: "bbob-biobj", "bbob", ...
    function, dimension, instance : as COCO counts them, from 1.

    Raises
    ------
    ValueError : if the extra is not installed, or COCO has no such function, or none of real
        variables without constraints and noise.
    """

    def __init__(self, suite: str, function: int, dimension: int, instance: int) -> None:
        self.suite, self.function, self.instance = suite, function, instance
        coco = _coco(suite, function, dimension, instance)
        super().__init__(
            n_var=dimension,
            n_obj=coco.number_of_objectives,
            xl=np.array(coco.lower_bounds),
            xu=np.array(coco.upper_bounds),
            vtype=float,
        )

    @property
    def instance_of(self) -> str:
        """The function, of which instances and dimensions are not independent of each other."""
        return f"{self.suite} f{self.function}"

    def name(self) -> str:
        """As COCO's own, without its index."""
        return f"{self.suite} f{self.function} d{self.n_var} i{self.instance}"

    def _evaluate(self, X: FloatArray, out: dict[str, Any], *args: Any, **kwargs: Any) -> None:
        coco = _coco(self.suite, self.function, self.n_var, self.instance)
        with _LOCK:
            out["F"] = np.array([np.atleast_1d(coco(x)) for x in X])


def problem(name: str) -> CocoProblem:
    """The problem of a name without ranges; raises as `CocoProblem`."""
    suite, *numbers = _parts(name)
    if not all(number.isdigit() for number in numbers):
        raise ValueError(f"coco:{name}: expected one function, one dimension and one instance")
    function, dimension, instance = (_numbers(name, number)[0] for number in numbers)
    return CocoProblem(suite, function, dimension, instance)


def names(name: str) -> Iterator[str]:
    """Names without ranges that a name stands for, ``bbob-biobj/f1-55/d5,10/i1-5``.

    Raises
    ------
    ValueError : if it is no such name.
    """
    suite, *ranges = _parts(name)
    functions, dimensions, instances = (_numbers(name, text) for text in ranges)
    if len(functions) * len(dimensions) * len(instances) > _MOST:
        raise ValueError(f"coco:{name:.80} stands for more than {_MOST:,} problems")
    for dimension, function, instance in product(dimensions, functions, instances):
        yield f"{suite}/f{function}/d{dimension}/i{instance}"


@contextmanager
def observed(
    problem: CocoProblem, folder: Path, algorithm: str
) -> Iterator[Callable[[FloatArray], Any]]:
    """COCO's function, whose evaluations its observer logs into a new folder; see ``cocopp``.

    Neither points nor the front are logged, only when which quality was reached.

    Raises
    ------
    ValueError : for a name or a folder that COCO's options cannot hold.
    """
    import cocoex

    for text in (str(folder), algorithm):
        if '"' in text or "\n" in text:
            raise ValueError(f"COCO's observer: {text!r:.200}: expected no quotation mark")
    folder.parent.mkdir(parents=True, exist_ok=True)
    options = (
        f'outer_folder: "{folder.parent}" result_folder: "{folder.name}" '
        f'algorithm_name: "{algorithm}" log_nondominated: none log_decision_variables: none'
    )
    suite = _suite(problem.suite, problem.instance)
    which = problem.function, problem.n_var, problem.instance
    kind = "bbob-biobj" if problem.suite.startswith("bbob-biobj") else "bbob"
    with _LOCK:
        level = cocoex.log_level("error")
        try:
            observer = cocoex.Observer(kind, options)
            function = suite.get_problem_by_function_dimension_instance(*which, observer)
        finally:
            cocoex.log_level(level)

    def evaluate(x: FloatArray) -> Any:
        with _LOCK:
            return function(x)

    try:
        yield evaluate
    finally:
        with _LOCK:
            function.free()  # writes what is left


def _parts(name: str) -> tuple[str, ...]:
    found = _NAME.fullmatch(name)
    if found is None:
        raise ValueError(f"coco:{name:.80}: {_EXPECTED}")
    return found.groups()


def _numbers(name: str, text: str) -> list[int]:
    """Those of "1-3,7": 1, 2, 3 and 7."""
    found: list[int] = []
    for part in text.split(","):
        ends = re.fullmatch(r"(\d{1,6})(?:-(\d{1,6}))?", part, re.ASCII)
        low, high = (int(end) for end in (ends[1], ends[2] or ends[1])) if ends else (0, 0)
        if not 1 <= low <= high <= _MOST:
            raise ValueError(f"coco:{name:.80}: {part!r:.20} is no number or range; {_EXPECTED}")
        found += range(low, high + 1)
    if len(set(found)) < len(found):
        raise ValueError(f"coco:{name:.80}: {text!r:.80} has a number twice")
    return found


@lru_cache(maxsize=_KEPT)
def _coco(suite: str, function: int, dimension: int, instance: int) -> Any:
    """COCO's own problem."""
    found = _suite(suite, instance)
    try:
        with _LOCK:
            return found.get_problem_by_function_dimension_instance(function, dimension, instance)
    except Exception as error:  # COCO's are of several kinds
        raise ValueError(
            f"COCO's suite {suite!r} has no function {function} in {dimension} dimensions, "
            f"instance {instance}"
        ) from error


@lru_cache(maxsize=_KEPT)
def _suite(suite: str, instance: int) -> Any:
    """COCO's own suite of one instance."""
    if suite not in _SUITES:
        raise ValueError(f"COCO's suite {suite!r}: expected one of {', '.join(_SUITES)}")
    if "biobj" in suite and instance > _BIOBJECTIVE_INSTANCES:
        raise ValueError(
            f"instance {instance} of COCO's {suite}: expected 1 to {_BIOBJECTIVE_INSTANCES}"
        )
    try:
        import cocoex
    except ImportError as error:
        raise ValueError(
            "COCO's functions need the extra 'coco': pip install 'mgeo[coco]'"
        ) from error
    with _LOCK:
        level = cocoex.log_level("error")  # what is wrong is said in our words
        try:
            return cocoex.Suite(suite, f"instances: {instance}", "")
        except Exception as error:
            raise ValueError(f"COCO's suite {suite!r} has no instance {instance}") from error
        finally:
            cocoex.log_level(level)


Watch = Callable[[Population, Any], object]


def run_folder(folder: Path, problem: Problem, seed: int) -> Path:
    """Where the data of a run go, below those of its algorithm.

    Raises
    ------
    ValueError : if the problem is none of COCO's.
    """
    if not isinstance(problem, CocoProblem):
        raise ValueError(
            f"data for COCO of {problem.name()}: expected one of COCO's functions, "
            "coco:SUITE/fN/dN/iN"
        )
    return folder / f"{problem.name().replace(' ', '-')}-seed{seed}"


@contextmanager
def coco_data(problem: CocoProblem, place: Path, algorithm: str, n_eval: int) -> Iterator[Watch]:
    """Shows COCO's observer the first `n_eval` evaluations of a run.

    It evaluates them once more, by itself: its functions take microseconds. The folder is there
    when the run is over, whole, in place of an earlier one, or not at all.

    Parameters
    ----------
    place : folder of the run's data.
    algorithm : its name there.

    Yields
    ------
    What takes each batch that has been evaluated.
    """
    # not within the algorithm's folder: what a killed process leaves there would be read
    part = place.parent.with_name(f".{place.parent.name}-{place.name}-{secrets.token_hex(8)}")
    left = n_eval
    with observed(problem, part, algorithm) as function:

        def watch(population: Population, _: Any = None) -> None:
            nonlocal left
            for x in population.get("X")[: max(left, 0)].astype(float):
                function(x)
            left -= len(population)

        try:
            yield watch
        except BaseException:
            shutil.rmtree(part, ignore_errors=True)
            raise
    shutil.rmtree(place, ignore_errors=True)
    place.parent.mkdir(parents=True, exist_ok=True)
    try:
        part.rename(place)
    except OSError:
        if not place.is_dir():
            raise
        shutil.rmtree(part)  # another process has just made the same run
