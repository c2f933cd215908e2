"""Complete trajectory of a design: the filter run and all motion after it.

After the run, the last rate is held for runs that converge late, and the satellite slews back to
its initial attitude law. The slew back is one more maneuver with a constant rate from a root
search, followed by a change to the rate of the law. Both use the ramps of all maneuvers, so that
the extended design is handled as any other design.
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
from mgeo_attitude.maneuvers.actuation import MagnetorquerDrive, SlewLimits
from mgeo_attitude.maneuvers.motion import Body, Motion, Phase, list_phases, split_phases
from mgeo_attitude.maneuvers.schedule import (
    VARIABLES_PER_MANEUVER,
    RateIntervals,
    RotationDynamics,
    Schedule,
    build_rate_intervals,
    build_schedule,
)
from mgeo_attitude.scenario.scenario import Scenario
from mgeo_attitude.settings.errors import InvalidValue

#: Labels of the two maneuvers after the maneuvers of the design.
SLEW_BACK_LABELS = ("slew back", "starting attitude")

#: Largest error of the attitude at the end of the slew back [rad].
_TOLERANCE = 1e-10
#: Factor on limits that allows for rounding of the solver.
_ROUNDING_FACTOR = 1.0 + 1e-9
#: Rate that counts as zero [deg/s]: in a day it rotates by less than the attitude tolerance.
_ZERO_RATE_DEG_S = 1e-14
#: Largest number of evaluations in the search for a rate; a feasible search takes about twenty.
_MAX_EVALUATIONS = 60


@dataclass(frozen=True)
class SlewBack:
    """Design extended by a slew back to the initial attitude law.

    Attributes
    ----------
    design : array, shape (4 k,)
        The maneuvers of the plan until `start`, the slew back, and the rate of the law.
    start, end : float
        Start and end of the slew back [s] after the epoch, both on a filter step.
    """

    design: Floats
    start: float
    end: float

    def list_phases(self, step: float, limits: RotationDynamics) -> tuple[Phase, ...]:
        """Return the phases of the slew back, for display."""
        first = len(self.design) // VARIABLES_PER_MANEUVER - len(SLEW_BACK_LABELS)
        names = dict(enumerate(SLEW_BACK_LABELS, first))
        all_phases = list_phases(self.design, self.end, step, limits, names)
        return tuple(phase for phase in all_phases if phase.start > self.start - 0.5 * step)


def find_slew_back(
    scenario: Scenario,
    design: ArrayLike,
    t_end: float,
    limits: RotationDynamics,
    initial_attitude: Floats,
) -> SlewBack | None:
    """Return the shortest slew back to the initial attitude law.

    The body takes the shorter way, at rates within the limits of maneuvers and wheel momenta, and
    reaches attitude and rate of the law at the same time. Powell's hybrid method finds the rate,
    and bisection the duration in filter steps.

    Parameters
    ----------
    scenario : Scenario
    design : array_like, shape (4 m,)
    t_end : float
        End of the filter run [s].
    limits : SlewLimits, optional
        Limits on rate changes for the design.
    initial_attitude : array, shape (3, 3)
        GCRS-to-body matrix at the epoch.

    Returns
    -------
    SlewBack or None
        None if the scenario requests no slew back.

    Raises
    ------
    InvalidValue
        If the slew back would take longer than the longest run.
    """
    if not scenario.maneuvers.slew_back or isinstance(limits, MagnetorquerDrive):
        return None
    step = scenario.step
    before = _truncate_design(np.asarray(design, dtype=float), t_end, step, limits)
    last = round(t_end / step)
    plan = build_schedule(before, step, limits, last)
    search = SlewSearch(
        scenario, t_end, limits, *_compute_attitude_and_rate(plan, last, step, initial_attitude)
    )
    least, most = 0, 1
    while (maneuvers := search.find_maneuvers(most)) is None:
        if most >= scenario.n_steps:
            raise InvalidValue(
                "maneuvers.slew_back",
                True,
                f"no slew back fits into duration = {scenario.duration:g} s at "
                f"maneuvers.max_rate_deg_s = {scenario.maneuvers.max_rate_deg_s:g}; increase one "
                "of them",
            )
        least, most = most, min(2 * most, scenario.n_steps)
    while most - least > 1:
        middle = (least + most) // 2
        shorter = search.find_maneuvers(middle)
        least, most, maneuvers = (
            (middle, most, maneuvers) if shorter is None else (least, middle, shorter)
        )
    return SlewBack(np.concatenate([before, maneuvers]), t_end, (last + most) * step)


def _truncate_design(
    design: Floats, t_end: float, step: float, limits: SlewLimits | None
) -> Floats:
    """Return the maneuvers of a run, the last of which ends half a step before `t_end`.

    The margin makes the following maneuver start at the next step regardless of rounding.
    """
    last_number = int(build_rate_intervals(design, t_end, step, limits).maneuver_numbers[-1])
    table = design.reshape(-1, VARIABLES_PER_MANEUVER)[: last_number + 1].copy()
    table[-1, 3] = t_end - 0.5 * step - table[:-1, 3].sum()
    return table.ravel()


def _compute_attitude_and_rate(
    plan: Schedule, end_step: int, step: float, attitude: Floats
) -> tuple[Floats, Floats]:
    """Return attitude (GCRS to body) and body rate [rad/s] at a step of a one-design schedule."""
    n_steps = plan.count_steps(end_step)[0]
    is_flown = n_steps > 0
    turns = -plan.rates[0, is_flown] * (n_steps[is_flown] * step)[:, None]
    matrices = Rotation.from_rotvec(turns).as_matrix()
    while len(matrices) > 1:  # Multiply neighbors pairwise, which vectorizes the product.
        alone = matrices[len(matrices) // 2 * 2 :]
        matrices = np.concatenate([matrices[1::2] @ matrices[: len(matrices) // 2 * 2 : 2], alone])
    reached: Floats = matrices[0] @ attitude
    return reached, plan.end_rates[0, is_flown][-1]


@dataclass
class SlewSearch:
    """Search for slews of a given number of steps from the attitude and rate at `start` [s]."""

    scenario: Scenario
    start: float
    limits: SlewLimits | None
    attitude: Floats
    rate: Floats

    def find_maneuvers(self, n_steps: int) -> Floats | None:
        """Return a slew back in n steps as a design of two maneuvers, shape (8,).

        The second maneuver changes to the rate of the law. None if n steps are too few.
        """
        step, initial = self.scenario.step, self.scenario.initial
        target, final = initial.evaluate_law(self.scenario, self.start + n_steps * step)
        turn = -Rotation.from_matrix(target @ self.attitude.T).as_rotvec()
        rate = turn / (n_steps * step)
        if np.linalg.norm(rate) > math.sqrt(3.0) * self._max_rate:  # No rates are high enough.
            return None
        leaving = self._count_steps(rate - final)
        while self._count_steps(rate - self.rate) + leaving <= n_steps:
            new_rate = self._find_rate(n_steps, leaving, target, final, rate)
            if new_rate is None:
                return None
            rate = new_rate
            n_needed = self._count_steps(final - rate)
            if n_needed <= leaving:
                is_feasible = self._count_steps(
                    rate - self.rate
                ) + leaving <= n_steps and self._is_within_limits(rate)
                return self._build_design(n_steps, leaving, rate, final) if is_feasible else None
            leaving = n_needed
        return None

    def _find_rate(
        self,
        n_steps: int,
        n_ramp_steps: int,
        target_attitude: Floats,
        final_rate: Floats,
        guess: Floats,
    ) -> Floats | None:
        """Find the rate of a slew to the target attitude, or None.

        The last `n_ramp_steps` of the n steps change the rate to `final_rate`.
        """
        from scipy.optimize import root  # This import takes long.

        step, time = self.scenario.step, n_steps * self.scenario.step
        limits = self.limits
        if limits is not None:
            limits = dataclasses.replace(limits, initial_rate=self.rate)

        def off(angle: Floats) -> Floats:
            design = self._build_design(n_steps, n_ramp_steps, angle / time, final_rate)
            reached, _ = _compute_attitude_and_rate(
                build_schedule(design, step, limits, n_steps), n_steps, step, self.attitude
            )
            error: Floats = Rotation.from_matrix(target_attitude @ reached.T).as_rotvec()
            return error

        solution = root(off, guess * time, tol=1e-12, options={"maxfev": _MAX_EVALUATIONS})
        rate: Floats = solution.x / time
        return rate if np.abs(off(solution.x)).max() < _TOLERANCE else None

    @property
    def _max_rate(self) -> float:
        return math.radians(self.scenario.maneuvers.max_rate_deg_s)

    def _count_steps(self, change: Floats) -> int:
        if self.limits is None:
            return 0
        return math.ceil(float(self.limits.compute_ramp_time(change)) / self.scenario.step - 1e-9)

    def _is_within_limits(self, rate: Floats) -> bool:
        wheels = self.scenario.wheels
        within = np.abs(rate).max() <= self._max_rate * _ROUNDING_FACTOR
        if wheels is not None and wheels.max_momentum is not None:
            momentum = wheels.compute_largest_load(rate @ wheels.inertia_matrix())
            within &= momentum <= wheels.max_momentum * _ROUNDING_FACTOR
        return bool(within)

    def _build_design(
        self, n_steps: int, n_ramp_steps: int, rate: Floats, final_rate: Floats
    ) -> Floats:
        step = self.scenario.step
        rates = np.degrees([rate, final_rate])
        rates[np.abs(rates) < _ZERO_RATE_DEG_S] = 0.0
        return np.array(
            [*rates[0], (n_steps - n_ramp_steps) * step, *rates[1], n_ramp_steps * step]
        )


@dataclass(frozen=True, eq=False)
class Trajectory:
    """Trajectory of a design, shape (n_var,), to the end of the plan.

    Attributes
    ----------
    scenario : Scenario
    body : Body
    design : array, shape (n_var,)
    t_end : float
        End of the filter run [s].
    hold_until : float
        Time until which the last rate is held before a slew back [s], if later than `t_end`.
    """

    scenario: Scenario
    body: Body
    design: Floats
    t_end: float
    hold_until: float = 0.0

    @property
    def design_end(self) -> float:
        """End of the design [s], including the rate held for runs that converge late."""
        return max(self.t_end, self.hold_until)

    @cached_property
    def slew_back(self) -> SlewBack | None:
        """Slew back after the design, if the scenario requests one."""
        limits, initial = self.body.slew_limits, self.body.initial_attitude
        return find_slew_back(self.scenario, self.design, self.design_end, limits, initial)

    @property
    def commanded_design(self) -> Floats:
        """Commanded design, including the slew back."""
        return self.design if self.slew_back is None else self.slew_back.design

    @property
    def end(self) -> float:
        """End of the plan [s]."""
        return self.design_end if self.slew_back is None else self.slew_back.end

    @cached_property
    def phases(self) -> tuple[Phase, ...]:
        """Phases of the plan: maneuvers, held rate, and slew back.

        The time that is added for runs that converge late is a separate phase.
        """
        step, limits = self.body.step, self.body.slew_limits
        found = split_phases(list_phases(self.design, self.design_end, step, limits), self.t_end)
        return found if self.slew_back is None else found + self.slew_back.list_phases(step, limits)

    @cached_property
    def intervals(self) -> RateIntervals:
        """Intervals of constant rate until the end."""
        return build_rate_intervals(
            self.commanded_design, self.end, self.body.step, self.body.slew_limits
        )

    @cached_property
    def motion(self) -> Motion:
        """Rates and attitudes at every step until the end."""
        return Motion.from_design(
            self.body, self.commanded_design, round(self.end / self.body.step)
        )

    @property
    def attitude(self) -> Floats:
        """GCRS-to-body matrices at every step until the end, shape (n + 1, 3, 3)."""
        return self.motion.attitude
