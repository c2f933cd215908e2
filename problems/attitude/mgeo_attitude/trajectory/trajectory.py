"""All that is flown of a design: what the filter runs along, and what follows until it ends.

That is the last rate, as long as flights may take that converge late, and the slew back to the
attitude law that the satellite started with. It is one more maneuver, at a constant rate that is
found for it, and the change to the rate of the law, with the ramps of all maneuvers. So a design
that has both is flown as any other.
"""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from mgeo_attitude._typing import Floats
from mgeo_attitude.maneuvers.drives import CoilDrive, SlewLimits
from mgeo_attitude.maneuvers.motion import Body, Motion, Phase, divided, phases
from mgeo_attitude.maneuvers.schedule import (
    VARIABLES_PER_MANEUVER,
    Flown,
    Schedule,
    Turning,
    flown,
    schedule,
)
from mgeo_attitude.scenario.scenario import Scenario
from mgeo_attitude.settings.errors import InvalidValue

#: What the two maneuvers after those of the design are called.
LABELS = ("slew back", "starting attitude")

#: By how much the attitude that is reached may be off the law [rad].
_TOLERANCE = 1e-10
#: A rate at its limit may be above it by what the solver rounds.
_ROUNDING = 1.0 + 1e-9
#: A rate below this is rounding: in a day it turns by less than the attitude may be off.
_ZERO_DEG_S = 1e-14
#: A rate that so many tries do not find has no ramps that fit; others take some twenty.
_EVALUATIONS = 60


@dataclass(frozen=True)
class SlewBack:
    """A design that goes on after `start`, when the filter has converged, until it is back.

    Attributes
    ----------
    design : array, shape (4 k,)
        Flown as the plan's own until `start`; then the slew back, and the law's rate held.
    start, end : float
        [s] after the epoch, both on a step of the filter.
    """

    design: Floats
    start: float
    end: float

    def phases(self, step: float, limits: Turning) -> tuple[Phase, ...]:
        """Phases from `start` to `end`."""
        first = len(self.design) // VARIABLES_PER_MANEUVER - len(LABELS)
        names = dict(enumerate(LABELS, first))
        found = phases(self.design, self.end, step, limits, names)
        return tuple(phase for phase in found if phase.start > self.start - 0.5 * step)


def slew_back(
    scenario: Scenario,
    design: ArrayLike,
    t_end: float,
    limits: Turning,
    initial_attitude: Floats,
) -> SlewBack | None:
    """The soonest slew back, in steps of the filter, of a design whose run ends at `t_end`.

    None if the scenario asks for none. The body turns the shorter way, no faster than maneuvers
    may about any axis and with no more momentum than wheels can hold, and arrives with attitude and
    rate of the law at that time; those are found by Powell's hybrid method, the time by bisection.

    Parameters
    ----------
    design : array_like, shape (4 m,)
    limits : SlewLimits, optional
        Of the design, with its initial rate.
    initial_attitude : array, shape (3, 3)
        GCRS to body at the epoch.

    Raises
    ------
    InvalidValue
        If it would take longer than the longest run.
    """
    if not scenario.maneuvers.slew_back or isinstance(limits, CoilDrive):  # which it refuses
        return None
    step = scenario.step
    before = _until(np.asarray(design, dtype=float), t_end, step, limits)
    last = round(t_end / step)
    plan = schedule(before, step, limits, last)
    search = Search(scenario, t_end, limits, *_end(plan, last, step, initial_attitude))
    least, most = 0, 1
    while (found := search.maneuvers(most)) is None:
        if most >= scenario.n_steps:
            raise InvalidValue(
                "maneuvers.slew_back",
                True,
                f"no way back within duration = {scenario.duration:g} s at "
                f"maneuvers.max_rate_deg_s = {scenario.maneuvers.max_rate_deg_s:g}",
            )
        least, most = most, min(2 * most, scenario.n_steps)
    while most - least > 1:
        middle = (least + most) // 2
        sooner = search.maneuvers(middle)
        least, most, found = (middle, most, found) if sooner is None else (least, middle, sooner)
    return SlewBack(np.concatenate([before, found]), t_end, (last + most) * step)


def _until(design: Floats, t_end: float, step: float, limits: SlewLimits | None) -> Floats:
    """Maneuvers flown in a run; the last one ends with it, half a step of the filter too soon.

    What follows begins at the next step whatever the rounding of sums.
    """
    number = int(flown(design, t_end, step, limits).numbers[-1])
    table = design.reshape(-1, VARIABLES_PER_MANEUVER)[: number + 1].copy()
    table[-1, 3] = t_end - 0.5 * step - table[:-1, 3].sum()
    return table.ravel()


def _end(plan: Schedule, last: int, step: float, attitude: Floats) -> tuple[Floats, Floats]:
    """Attitude, GCRS to body, and body rate [rad/s] at a step of the only design of a schedule."""
    lasting = plan.lasting(last)[0]
    flying = lasting > 0
    turns = -plan.rates[0, flying] * (lasting[flying] * step)[:, None]
    matrices = Rotation.from_rotvec(turns).as_matrix()
    while len(matrices) > 1:  # each turn and the one before it
        alone = matrices[len(matrices) // 2 * 2 :]
        matrices = np.concatenate([matrices[1::2] @ matrices[: len(matrices) // 2 * 2 : 2], alone])
    reached: Floats = matrices[0] @ attitude
    return reached, plan.end_rates[0, flying][-1]


@dataclass
class Search:
    """Looks for slews of a number of steps from an attitude and a rate at `start` [s]."""

    scenario: Scenario
    start: float
    limits: SlewLimits | None
    attitude: Floats
    rate: Floats

    def maneuvers(self, n: int) -> Floats | None:
        """Slew and change to the law's rate in n steps as a design, shape (8,), if there are."""
        step, initial = self.scenario.step, self.scenario.initial
        target, final = initial.law(self.scenario, self.start + n * step)
        turn = -Rotation.from_matrix(target @ self.attitude.T).as_rotvec()
        rate = turn / (n * step)
        if np.linalg.norm(rate) > math.sqrt(3.0) * self._most_rate:  # too far, at any rates
            return None
        leaving = self._steps(rate - final)
        while self._steps(rate - self.rate) + leaving <= n:
            found = self._rate(n, leaving, target, final, rate)
            if found is None:
                return None
            rate = found
            needed = self._steps(final - rate)
            if needed <= leaving:
                sound = self._steps(rate - self.rate) + leaving <= n and self._slow(rate)
                return self._design(n, leaving, rate, final) if sound else None
            leaving = needed
        return None

    def _rate(
        self, n: int, leaving: int, target: Floats, final: Floats, guess: Floats
    ) -> Floats | None:
        """Rate of a slew that arrives, the last so many steps being for the law's rate."""
        from scipy.optimize import root  # which takes long to import

        step, time = self.scenario.step, n * self.scenario.step
        limits = self.limits
        if limits is not None:
            limits = dataclasses.replace(limits, initial_rate=self.rate)

        def off(angle: Floats) -> Floats:
            design = self._design(n, leaving, angle / time, final)
            reached, _ = _end(schedule(design, step, limits, n), n, step, self.attitude)
            left: Floats = Rotation.from_matrix(target @ reached.T).as_rotvec()
            return left

        solution = root(off, guess * time, tol=1e-12, options={"maxfev": _EVALUATIONS})
        rate: Floats = solution.x / time
        return rate if np.abs(off(solution.x)).max() < _TOLERANCE else None

    @property
    def _most_rate(self) -> float:
        return math.radians(self.scenario.maneuvers.max_rate_deg_s)

    def _steps(self, change: Floats) -> int:
        """Steps that a change of the rate takes."""
        if self.limits is None:
            return 0
        return math.ceil(float(self.limits.ramp_time(change)) / self.scenario.step - 1e-9)

    def _slow(self, rate: Floats) -> bool:
        """Whether a rate is within the limits of maneuvers and wheels."""
        wheels = self.scenario.wheels
        within = np.abs(rate).max() <= self._most_rate * _ROUNDING
        if wheels is not None and wheels.max_momentum is not None:
            momentum = wheels.greatest_share(rate @ wheels.matrix())
            within &= momentum <= wheels.max_momentum * _ROUNDING
        return bool(within)

    def _design(self, n: int, leaving: int, rate: Floats, final: Floats) -> Floats:
        step = self.scenario.step
        rates = np.degrees([rate, final])
        rates[np.abs(rates) < _ZERO_DEG_S] = 0.0
        return np.array([*rates[0], (n - leaving) * step, *rates[1], leaving * step])


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
