"""How the simulated estimator treats what equation (2) leaves out: terms of second order."""

from __future__ import annotations

from dataclasses import dataclass

from mgeo_attitude.fields import Validated, quantity


@dataclass(frozen=True, kw_only=True)
class Estimator(Validated):
    """A closed-loop error-state filter: multiplicative in rotations, errors fed back each update.

    The default is what `docs/consistency.md` finds to pay; the other settings are there to be
    compared with it.
    """

    jacobians: str = quantity(
        "estimate",
        choices=("estimate", "aligned"),
        doc="derivatives of a measurement at the estimated or at no misalignment",
    )
    second_order: bool = quantity(
        True, doc="mean and covariance of the measurement's second-order terms (Jazwinski)"
    )
    reset: bool = quantity(
        True, doc="turn the covariance with the estimate when a rotation is fed back (Markley)"
    )
    iterations: int = quantity(
        1, low=1, doc="evaluations of a measurement per update, each at the estimate before"
    )

    @staticmethod
    def plain() -> Estimator:
        """The textbook's filter, with the H of equation (2)."""
        return Estimator(jacobians="aligned", second_order=False, reset=False)
