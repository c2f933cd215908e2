"""What a plan teaches the filter, what it leaves unknown, and what simpler plans would do."""

from .baselines import baselines, compare
from .covariance import correlations, least_observable, normalized
from .contributions import contributions
from .states import States

__all__ = [
    "States",
    "baselines",
    "compare",
    "correlations",
    "contributions",
    "least_observable",
    "normalized",
]
