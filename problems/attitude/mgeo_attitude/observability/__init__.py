"""What a plan teaches the filter, what it leaves unknown, and what simpler plans would do."""

from .baselines import baselines, compare
from .covariance import correlations, least_observable, normalized
from .gains import gains
from .states import States

__all__ = [
    "States",
    "baselines",
    "compare",
    "correlations",
    "gains",
    "least_observable",
    "normalized",
]
