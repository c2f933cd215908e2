"""What a plan teaches the filter, what it leaves unknown, and what simpler plans would do."""

from mgeo_attitude.view.observability.alternatives import (
    baselines,
    compare,
    remedies,
    without_optimizer,
)
from mgeo_attitude.view.observability.budget import budget, contributions, reasons, sensor_use
from mgeo_attitude.view.observability.covariance import (
    States,
    correlations,
    least_observable,
    normalized,
)

__all__ = [
    "States",
    "baselines",
    "budget",
    "compare",
    "contributions",
    "correlations",
    "least_observable",
    "normalized",
    "reasons",
    "remedies",
    "sensor_use",
    "without_optimizer",
]
