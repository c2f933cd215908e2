"""What a run carries from one generation to the next, in one place."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from mgeo._typing import FloatArray, IntArray
from mgeo.pareto.archive import ParetoArchive


@dataclass(kw_only=True, eq=False, slots=True)
class RunState:
    """All that a run of the family carries from one generation to the next.

    A checkpoint takes every field (`mgeo.algorithms.state`), and what is not declared here cannot
    be set here. A leaf that carries more declares it in a subclass of the same kind, and makes
    that in `Walkers._new_state`. Fields are arrays of numbers whose shape stays, random streams,
    lists of them, archives, numbers or text. Besides, there is only what pymoo's `Algorithm`
    carries itself: candidates, counters, evaluator, its own random stream.

    Attributes
    ----------
    streams : one `numpy.random.Generator` per walker.
    front : the archive.
    n_generations : how many generations are complete.
    walkers : (n_walkers, n_coordinates) where the walkers stand.
    taus, chances : (n_walkers, n_obj) of an adaptive tau: its value and last chance of improvement.
    standing, best : (n_walkers, 1 + n_obj) merits (`adaptive.merits`) where the walkers stand, and
        the best they have seen; kept if tau is adaptive or walkers restart.
    idle : (n_walkers,) generations since a walker's last progress; kept if walkers restart.
    """

    streams: list[np.random.Generator]
    front: ParetoArchive
    n_generations: int
    walkers: FloatArray
    taus: FloatArray
    chances: FloatArray
    standing: FloatArray
    best: FloatArray
    idle: IntArray

    @classmethod
    def begin(
        cls,
        streams: list[np.random.Generator],
        front: ParetoArchive,
        walkers: FloatArray,
        **more: Any,
    ) -> Self:
        """A state before the first generation; what is known of walkers is not filled in yet.

        Parameters
        ----------
        streams, front, walkers : see above.
        more : fields of a subclass.
        """
        n, n_obj = len(walkers), front.F.shape[1]
        return cls(
            streams=streams,
            front=front,
            n_generations=0,
            walkers=walkers,
            taus=np.empty((n, n_obj)),
            chances=np.empty((n, n_obj)),
            standing=np.empty((n, 1 + n_obj)),
            best=np.empty((n, 1 + n_obj)),
            idle=np.empty(n, dtype=np.intp),
            **more,
        )
