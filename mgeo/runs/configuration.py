"""Everything that determines a run, as plain data."""

from __future__ import annotations

from typing import Any

from pydantic import Field

from mgeo.store.models import Table


class RunConfiguration(Table):
    """A run to be made, or made again: the same configuration gives the same front.

    Attributes
    ----------
    problem, algorithm
        Names, see `mgeo.plugins.discovery` and `mgeo.runs.algorithms`.
    options, parameters
        What they are built from, JSON values.
    evaluations
        The budget.
    seed
        Of all randomness.
    """

    problem: str
    options: dict[str, Any]
    algorithm: str
    parameters: dict[str, Any]
    evaluations: int = Field(ge=1)
    seed: int = Field(ge=0)
