"""What a plan teaches the filter, what it leaves unknown, and what simpler plans would do."""

from .baselines import baselines, compare
from .contributions import contributions
from .covariance import correlations, least_observable, normalized
from .states import States

__all__ = [
    "States",
    "baselines",
    "compare",
    "contributions",
    "correlations",
    "least_observable",
    "normalized",
]
