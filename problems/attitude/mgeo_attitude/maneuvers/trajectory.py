"""All that is flown of a design: what the filter runs along, and what follows until it ends.

That is the last rate, as long as flights may take that converge late, and the slew back.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

from mgeo_attitude._typing import Floats
from mgeo_attitude.maneuvers.motion import Body, Motion
from mgeo_attitude.maneuvers.phases import Phase, divided, phases
from mgeo_attitude.maneuvers.schedule import Flown, flown
from mgeo_attitude.maneuvers.slew_back import SlewBack, slew_back

if TYPE_CHECKING:
    from mgeo_attitude.scenario import Scenario


@dataclass(frozen=True, eq=False)
class Trajectory:
    """A design, shape (n_var,), whose run ends at `t_end` [s], until the plan's end.

    Attributes
    ----------
    held : float
        Until when it is flown before a slew back [s], if that is later than `t_end`.
    """

    scenario: Scenario
    body: Body
    design: Floats
    t_end: float
    held: float = 0.0

    @property
    def held_until(self) -> float:
        """When the design ends [s], with what is held for late flights."""
        return max(self.t_end, self.held)

    @cached_property
    def back(self) -> SlewBack | None:
        """How it goes on after that, if the scenario asks for it."""
        limits, initial = self.body.slew_limits, self.body.initial_attitude
        return slew_back(self.scenario, self.design, self.held_until, limits, initial)

    @property
    def commanded(self) -> Floats:
        """The design that is flown: with the slew back after it."""
        return self.design if self.back is None else self.back.design

    @property
    def end(self) -> float:
        """When the plan ends [s]."""
        return self.held_until if self.back is None else self.back.end

    @cached_property
    def phases(self) -> tuple[Phase, ...]:
        """Maneuvers flown, the time for which the last rate is held, and the slew back.

        What is flown for late flights is a phase of its own.
        """
        step, limits = self.body.step, self.body.slew_limits
        found = divided(phases(self.design, self.held_until, step, limits), self.t_end)
        return found if self.back is None else found + self.back.phases(step, limits)

    @cached_property
    def flown(self) -> Flown:
        """Stretches of constant rate until the end."""
        return flown(self.commanded, self.end, self.body.step, self.body.slew_limits)

    @cached_property
    def motion(self) -> Motion:
        """Rates and attitudes until the end."""
        return Motion.of(self.body, self.commanded, round(self.end / self.body.step))

    @property
    def attitude(self) -> Floats:
        """GCRS to body at every step until the end, shape (n + 1, 3, 3)."""
        return self.motion.attitude
