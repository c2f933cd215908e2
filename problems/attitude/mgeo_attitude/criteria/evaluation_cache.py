"""Designs that have just been run are not run again."""

from __future__ import annotations

import threading
from collections.abc import Callable

import numpy as np

from mgeo_attitude._typing import Floats


class EvaluationCache:
    """Looks designs up among those of the batch before, of the same thread.

    A step that is clipped to a bound, or leaves a variable at it, gives a design that the optimizer
    has just seen: in Table 3 of the paper up to one in seven is. Each thread has a batch of its
    own, so that runs in several threads neither disturb one another nor lose what they know.

    Parameters
    ----------
    forget : bool
        Whether the batches before that are forgotten.
    """

    def __init__(self, forget: bool = True) -> None:
        self._before = threading.local()
        self._forget = forget

    def __reduce__(self) -> tuple[type[EvaluationCache], tuple[bool]]:
        # a copy, in another process or a history, knows nothing yet
        return EvaluationCache, (self._forget,)

    def complete(self, designs: Floats, run: Callable[[Floats], Floats]) -> Floats:
        """Values of designs (n, n_var), shape (n, n_values).

        `run` gives those of the k designs that are not known, shape (k, n_values). They may depend
        on nothing else. It is asked for none only where there are no designs.
        """
        before: dict[bytes, Floats] = getattr(self._before, "values", {})
        keys = [design.tobytes() for design in designs]
        new = [i for i, key in enumerate(keys) if key not in before]
        known = dict(before)
        if new:
            known.update(zip([keys[i] for i in new], run(designs[new]), strict=True))
        self._before.values = {key: known[key] for key in keys} if self._forget else known
        return np.array([known[key] for key in keys]) if keys else run(designs)
