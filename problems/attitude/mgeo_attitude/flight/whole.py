"""All that is flown of a design: what the filter runs along and, if asked for, the slew back."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from mgeo_attitude._typing import Floats
from mgeo_attitude.filter.model import FilterModel
from mgeo_attitude.flight.flight import Motion
from mgeo_attitude.maneuvers.phases import Phase, phases
from mgeo_attitude.maneuvers.schedule import Flown, flown
from mgeo_attitude.maneuvers.slew_back import SlewBack, slew_back
from mgeo_attitude.scenario import Scenario


@dataclass(frozen=True, eq=False)
class Whole:
    """A design, shape (n_var,), whose run ends at `t_end` [s], until the plan's end."""

    scenario: Scenario
    model: FilterModel
    design: Floats
    t_end: float

    @cached_property
    def back(self) -> SlewBack | None:
        """How it goes on after `t_end`, if the scenario asks for it."""
        limits, initial = self.model.slew_limits, self.model.initial_attitude
        return slew_back(self.scenario, self.design, self.t_end, limits, initial)

    @property
    def commanded(self) -> Floats:
        """The design that is flown: with the slew back after it."""
        return self.design if self.back is None else self.back.design

    @property
    def end(self) -> float:
        """When the plan ends [s]."""
        return self.t_end if self.back is None else self.back.end

    @cached_property
    def phases(self) -> tuple[Phase, ...]:
        """Maneuvers flown, the time for which the last rate is held, and the slew back."""
        step, limits = self.model.step, self.model.slew_limits
        found = phases(self.design, self.t_end, step, limits)
        return found if self.back is None else found + self.back.phases(step, limits)

    @cached_property
    def flight(self) -> Flown:
        """Stretches of constant rate until the end."""
        return flown(self.commanded, self.end, self.model.step, self.model.slew_limits)

    @cached_property
    def attitude(self) -> Floats:
        """GCRS to body at every step until the end, shape (n + 1, 3, 3)."""
        n_steps = round(self.end / self.model.step)
        return Motion.of(self.model, self.commanded, n_steps).attitude
