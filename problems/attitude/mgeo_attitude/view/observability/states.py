"""The error state by its single states: what each is called and the unit it is shown in."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from mgeo_attitude._typing import Floats
from mgeo_attitude.sensors.suite import Suite, block_units


class States(NamedTuple):
    """Names of the n states of a suite, in the order of the filter.

    Attributes
    ----------
    names : list of str
        ``attitude x``, ``sun misalignment z``...
    units : list of str
        Unit in which each is shown; that of `describe.block_units`.
    factors : array, shape (n,)
        From the filter's unit to that.
    """

    names: list[str]
    units: list[str]
    factors: Floats

    @classmethod
    def of(cls, suite: Suite) -> States:
        """States of a suite."""
        each = [(block, axis) for block in block_units(suite) for axis in "xyz"]
        return cls(
            names=[f"{block.label} {axis}" for block, axis in each],
            units=[block.unit for block, _ in each],
            factors=np.array([block.factor for block, _ in each]),
        )
