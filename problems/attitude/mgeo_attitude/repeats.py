"""Designs of the batch before are not run again."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass
class Repeats:
    """Looks designs up among those of the batch before.

    A step that is clipped to a bound, or leaves a variable at it, gives a design that the optimizer
    has just seen: in Table 3 of the paper up to one in seven is.
    """

    _values: dict[bytes, Floats] = field(default_factory=dict)

    def __reduce__(self) -> tuple[type[Repeats], tuple[()]]:
        return Repeats, ()  # a copy, in another process or a history, knows nothing yet

    def complete(self, designs: Floats, run: Callable[[Floats], Floats]) -> Floats:
        """Values of designs, shape (n, n_values).

        Parameters
        ----------
        designs : array, shape (n, n_var)
        run : function
            Gives the values, shape (k, n_values), of the k designs that are not known, which may be
            none. They may depend on nothing else.
        """
        keys = [design.tobytes() for design in designs]
        new = np.array([key not in self._values for key in keys], dtype=bool)
        found = run(designs[new])
        values = np.empty((len(designs), found.shape[1]))
        values[new] = found
        for i in np.flatnonzero(~new):
            values[i] = self._values[keys[i]]
        self._values = dict(zip(keys, values, strict=True))
        return values
