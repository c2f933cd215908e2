"""The error state by its single states: what each is called and the unit it is shown in."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mgeo_attitude._typing import Floats

from ..describe import block_units
from ..filter.suite import Suite


@dataclass(frozen=True, eq=False)
class States:
    """Names of the n states of a suite, in the order of the filter.

    Attributes
    ----------
    names : tuple of str
        ``attitude x``, ``sun misalignment z``...
    units : tuple of str
        Unit in which each is shown.
    factors : array, shape (n,)
        From the filter's unit to that.
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    factors: Floats

    @classmethod
    def of(cls, suite: Suite) -> States:
        """States of a suite; units are those of `describe.block_units`."""
        blocks = block_units(suite)
        return cls(
            names=tuple(f"{block.label} {axis}" for block in blocks for axis in "xyz"),
            units=tuple(block.unit for block in blocks for _ in "xyz"),
            factors=np.repeat([block.factor for block in blocks], 3).astype(np.float64),
        )

    @property
    def columns(self) -> list[str]:
        """Names with units, as columns of a table: ``attitude x [deg]``."""
        return [f"{name} [{unit}]" for name, unit in zip(self.names, self.units, strict=True)]
