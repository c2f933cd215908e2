"""What a plan teaches the filter, what it leaves unknown, and what simpler plans would do."""

from mgeo_attitude.view.observability.baselines import baselines, compare, without_optimizer
from mgeo_attitude.view.observability.budget import budget, reasons, sensor_use
from mgeo_attitude.view.observability.contributions import contributions
from mgeo_attitude.view.observability.covariance import correlations, least_observable, normalized
from mgeo_attitude.view.observability.remedies import remedies
from mgeo_attitude.view.observability.states import States

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
