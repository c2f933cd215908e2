"""All that is flown of a design: what the filter runs along and, if asked for, the slew back."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple, Self

from mgeo_attitude._typing import Floats
from mgeo_attitude.flight import Motion
from mgeo_attitude.maneuvers.phases import Phase, phases
from mgeo_attitude.maneuvers.schedule import Flown, flown
from mgeo_attitude.maneuvers.slew_back import slew_back

if TYPE_CHECKING:
    from mgeo_attitude.protocol import ManeuverProblem


class Whole(NamedTuple):
    """A plan until its end, ``flight.times[-1]``.

    Attributes
    ----------
    flight : Flown
    phases : tuple of Phase
    attitude : array, shape (n + 1, 3, 3)
        GCRS to body at every step.
    """

    flight: Flown
    phases: tuple[Phase, ...]
    attitude: Floats

    @classmethod
    def of(cls, problem: ManeuverProblem, x: Floats, t_end: float) -> Self:
        """Of a design, shape (n_var,), whose run ends at `t_end`."""
        model, design, end = problem.model, x, t_end
        step, limits = model.step, model.slew_limits
        found = phases(x, t_end, step, limits)
        back = slew_back(problem.scenario, x, t_end, limits, model.initial_attitude)
        if back is not None:
            design, end, found = back.design, back.end, found + back.phases(step, limits)
        attitude = Motion.of(model, design, round(end / step)).attitude
        return cls(flown(design, end, step, limits), found, attitude)
