"""Presets with three maneuvers, for tests whose designs have twelve variables."""

from mgeo_attitude import Scenario

TRACE = {"rule": "trace"}


def three(preset):
    """Return a preset with three maneuvers and the convergence rule "trace"."""
    table = {"preset": preset, "maneuvers": {"count": 3}, "convergence": TRACE}
    return Scenario.from_dict(table)
