"""Validation of the algorithms, seeds and evaluation counts of a comparison."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from pymoo.core.algorithm import Algorithm

from mgeo.validation.arguments import validate_integer

DEFAULT_GRID_SIZE = 50


def label_algorithms(
    algorithms: Mapping[str, Algorithm] | Iterable[Algorithm],
) -> dict[str, Algorithm]:
    """Return a dict that maps labels to algorithms. The default label is the class name.

    Raises
    ------
    TypeError
        If an element is not a pymoo algorithm.
    ValueError
        If there are no algorithms, two labels are equal, or an algorithm is already set up.
    """
    if isinstance(algorithms, Mapping):
        pairs = [(str(name), algorithm) for name, algorithm in algorithms.items()]
    else:
        pairs = [(type(algorithm).__name__, algorithm) for algorithm in algorithms]
    labeled = dict(pairs)
    if len(labeled) < len(pairs):
        raise ValueError(
            f"two algorithms have the same name, among {', '.join(labeled)}: expected labels, "
            "{'label': algorithm, ...}"
        )
    if not labeled:
        raise ValueError("algorithms is empty: expected at least one")
    for name, algorithm in labeled.items():
        if isinstance(algorithm, str) or not hasattr(algorithm, "setup"):
            raise TypeError(f"algorithms[{name!r}] = {algorithm!r}: expected a pymoo Algorithm")
        if algorithm.problem is not None or algorithm.is_initialized:
            raise ValueError(
                f"algorithms[{name!r}] is set up or has run, and would continue its run: "
                f"expected a new {type(algorithm).__name__}"
            )
    return labeled


def expand_seeds(seeds: int | Iterable[int]) -> tuple[int, ...]:
    """Return the seeds as a tuple. An integer n stands for the seeds 1 to n.

    Raises
    ------
    TypeError, ValueError
        If a seed is not a nonnegative integer, the list is empty, or two seeds are equal.
    """
    if not isinstance(seeds, Iterable):
        return tuple(range(1, validate_integer("seeds", seeds, low=1) + 1))
    listed = [validate_integer(f"seeds[{i}]", seed, low=0) for i, seed in enumerate(seeds)]
    if not listed or len(set(listed)) < len(listed):
        raise ValueError(f"seeds = {listed}: expected one or more different seeds")
    return tuple(listed)


def expand_grid(grid: int | Sequence[int], n_eval: int) -> list[int]:
    """Return the ascending evaluation counts at which to evaluate fronts, ending with `n_eval`.

    Parameters
    ----------
    grid : int or sequence of int
        Number of equal steps up to `n_eval`, or evaluation counts.
    n_eval : int
        Number of evaluations of a run.

    Raises
    ------
    TypeError, ValueError
        If a count is not a positive integer, or exceeds `n_eval`.
    """
    if not isinstance(grid, Iterable):
        steps = validate_integer("grid", grid, low=1)
        return sorted({max(1, round(n_eval * i / steps)) for i in range(1, steps + 1)})
    listed = {validate_integer(f"grid[{i}]", step, low=1) for i, step in enumerate(grid)} | {n_eval}
    if max(listed) > n_eval:
        raise ValueError(f"grid contains {max(listed)}: expected at most n_eval = {n_eval}")
    return sorted(listed)
