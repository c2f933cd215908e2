"""Designs that have just been run are not run again."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from mgeo_attitude._typing import Floats


class EvaluationCache:
    """Values of the designs of the previous batch, by design.

    A step that is clipped to a bound, or leaves a variable at it, repeats a design of the previous
    batch: in Table 3 of the paper up to one in seven.

    Parameters
    ----------
    forget : bool
        Whether all earlier batches are forgotten.
    """

    def __init__(self, forget: bool = True) -> None:
        self._known: dict[bytes, Floats] = {}
        self._forget = forget

    def complete(self, designs: Floats, run: Callable[[Floats], Floats]) -> Floats:
        """Return the values of designs (n, n_var), shape (n, n_values).

        `run` evaluates the k designs that are not known, shape (k, n_values), whose values depend
        on the design alone. An empty batch is passed to `run` as it is.
        """
        known = dict(self._known)
        keys = [design.tobytes() for design in designs]
        new = [i for i, key in enumerate(keys) if key not in known]
        if new:
            known.update(zip([keys[i] for i in new], run(designs[new]), strict=True))
        self._known = {key: known[key] for key in keys} if self._forget else known
        return np.array([known[key] for key in keys]) if keys else run(designs)
