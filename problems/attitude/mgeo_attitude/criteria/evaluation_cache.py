"""Cache of the values of evaluated designs, which avoids repeated filter runs."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from mgeo_attitude._typing import Floats


class EvaluationCache:
    """Cache of function values by design, which avoids repeated evaluations of equal designs.

    A move that is clipped to a bound, or that leaves a variable at a bound, repeats a design of the
    previous batch. In Table 3 of the paper, up to one in seven designs is repeated.

    Parameters
    ----------
    last_batch_only : bool
        Whether only the designs of the last batch are stored.
    """

    def __init__(self, last_batch_only: bool = True) -> None:
        self._values: dict[bytes, Floats] = {}
        self._last_batch_only = last_batch_only

    def evaluate(self, designs: Floats, function: Callable[[Floats], Floats]) -> Floats:
        """Return the function values of designs, and evaluate only designs that are not in the
        cache.

        Parameters
        ----------
        designs : array, shape (n, n_var)
        function : function of array
            Function that returns the values, shape (k, n_values), of designs, shape (k, n_var). The
            values of a design must not depend on other designs. An empty batch is passed unchanged.

        Returns
        -------
        array, shape (n, n_values)
        """
        values = dict(self._values)
        keys = [design.tobytes() for design in designs]
        new = [i for i, key in enumerate(keys) if key not in values]
        if new:
            values.update(zip([keys[i] for i in new], function(designs[new]), strict=True))
        self._values = {key: values[key] for key in keys} if self._last_batch_only else values
        return np.array([values[key] for key in keys]) if keys else function(designs)
