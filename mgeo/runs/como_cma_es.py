"""COMO-CMA-ES, by the package of its authors, as a pymoo algorithm."""

from __future__ import annotations

from typing import Any

import numpy as np
from pymoo.core.individual import Individual
from pymoo.core.population import Population

from mgeo.runs.pymoo_algorithms import UnitBox
from mgeo.validation.arguments import validate_integer, validate_number

_TOLERANCE = 1e-6  # of the bounds' width, where a kernel stops; theirs is 1e-4 of variables near 1


class COMOCMAES(UnitBox):
    """A CMA-ES for each point of the front, by uncrowded hypervolume improvement.

    Of Touré, Hansen, Auger & Brockhoff (2019), for two objectives, as coded in their ``comocma``,
    which the extra ``coco`` installs. A step evaluates the mean that was last changed, and a
    sample of one kernel, drawn at random. Variables are scaled to their bounds, which CMA-ES
    itself keeps. The archive of ``comocma``, which takes no part in the search, is off: in long
    runs it takes gigabytes.

    What the authors leave to the user: kernels begin at uniform points of the box; the reference
    point is the worst value of each objective at these; and a kernel that stops is joined by a new
    one from another such point.

    Parameters
    ----------
    pop_size : number of kernels at the beginning.
    sigma : initial step size, as a fraction of the width of the bounds.
    options : those of every pymoo algorithm.

    Raises
    ------
    ValueError : if ``comocma`` is not installed, or a parameter is out of range; when it is set
        up, if the problem has not two objectives, or one variable, or as of `UnitBox`.
    """

    title = "COMO-CMA-ES"

    def __init__(self, pop_size: int = 10, sigma: float = 0.2, **options: Any) -> None:
        try:
            import comocma  # noqa: F401
        except ImportError as error:
            raise ValueError(
                "COMO-CMA-ES needs the extra 'coco': pip install 'mgeo[coco]'"
            ) from error
        super().__init__(**options)
        self.pop_size = validate_integer("pop_size", pop_size, low=2)
        self.sigma = validate_number("sigma", sigma, above=0)

    def _setup(self, problem: Any, **options: Any) -> None:
        super()._setup(problem, **options)
        if problem.n_obj != 2:
            raise ValueError(f"COMO-CMA-ES: {problem.n_obj} objective(s), expected 2")
        if problem.n_var < 2:  # a limit of CMA-ES as coded
            raise ValueError("COMO-CMA-ES: 1 variable, expected 2 or more")

    def _initialize_infill(self) -> Population:
        from comocma import Sofomore

        options = {
            "archive": False,
            "restart": lambda _: self._kernels(1),
            "update_order": lambda _: self.random_state.random(),
            "verb_log": 0,  # which would be into files
        }
        self._search = Sofomore(self._kernels(self.pop_size), None, options)
        self._means: dict[int, Individual] = {}
        return self._infill()

    def _initialize_advance(self, infills: Any = None, **options: Any) -> None:
        self._search.reference_point = infills[: self.pop_size].get("F").max(axis=0).tolist()
        self._advance(infills, **options)

    def _infill(self) -> Population:
        self._asked = list(self._search._told_indices)  # kernels whose means come first
        self._points = self._search.ask()
        return self.scaled(self._points)

    def _advance(self, infills: Any = None, **options: Any) -> None:
        self._search.tell(self._points, infills.get("F").tolist())
        self._means |= dict(zip(self._asked, infills, strict=False))
        self.pop = Population.merge(Population.create(*self._means.values()), infills)

    def _kernels(self, n: int) -> list[Any]:
        from comocma import get_cmas

        options = {
            "bounds": [0.0, 1.0],
            "randn": lambda *shape: self.random_state.standard_normal(shape),
            "seed": np.nan,  # it would be that of NumPy's global generator
            "tolx": _TOLERANCE,
            "verbose": -9,
            "verb_log": 0,
        }
        kernels: list[Any] = get_cmas(self.drawn(n).tolist(), self.sigma, options)
        return kernels
