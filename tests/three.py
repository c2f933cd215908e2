"""Presets with three maneuvers and the rule "trace": many tests have designs of twelve numbers."""

from mgeo_attitude import Scenario

TRACE = {"rule": "trace"}


def three(preset):
    """A preset with both."""
    table = {"preset": preset, "maneuvers": {"count": 3}, "convergence": TRACE}
    return Scenario.from_dict(table)
