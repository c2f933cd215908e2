"""Complete trajectory of a design: the motion during the filter run and after the filter run.

After the run, the last rate is held for Monte Carlo runs that converge later, and the satellite
slews back to its initial attitude law, such as nadir pointing. The slew back consists of a maneuver
with a constant rate, which a root search finds, and of a change to the rate of the law. Both have
the ramps of all maneuvers, so that the extended design can be used like any other design.
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

#: Labels of the two maneuvers of a slew back.
SLEW_BACK_LABELS = ("slew back", "starting attitude")

#: Largest error of the attitude at the end of the slew back [rad].
_TOLERANCE = 1e-10
#: Factor on limits, to tolerate rounding of the solver.
_ROUNDING_FACTOR = 1.0 + 1e-9
#: Rate that is treated as zero [deg/s], since its rotation in a day is below the attitude
#: tolerance.
_ZERO_RATE_DEG_S = 1e-14
#: Largest number of evaluations in the search for a rate. A feasible search takes about twenty.
_MAX_EVALUATIONS = 60


@dataclass(frozen=True)
class SlewBack:
    """Final slew that returns the satellite to its initial attitude law, such as nadir pointing.

    The slew is stored as the design of the complete plan, slew included.

    Attributes
    ----------
    design : array, shape (4 k,)
        Maneuvers of the plan until `start`, the slew back, and the change to the rate of the law.
    start, end : float
        Start and end of the slew back [s] after the epoch, both on a filter step.
    """

    design: Floats
    start: float
    end: float

    def list_phases(self, step: float, limits: RotationDynamics) -> tuple[Phase, ...]:
        """List the motion phases of the slew back in chronological order.

        A phase is a ramp or a constant rate.
        """
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
    """Find the shortest slew that returns the satellite to its initial attitude law.

    The slew starts at the end of a filter run. An attitude law is, for example, nadir pointing. The
    body rotates the shorter way, at rates within the limits of maneuvers and wheel momenta, and
    reaches attitude and rate of the law at the same time. The rate is found by Powell's hybrid
    method, and the duration in filter steps by bisection.

    Parameters
    ----------
    scenario : Scenario
    design : array_like, shape (4 m,)
        Rates [deg/s] and duration [s] of each maneuver in turn.
    t_end : float
        End of the filter run [s].
    limits : SlewLimits or MagnetorquerDrive, optional
        Limits on rate changes of the design.
    initial_attitude : array, shape (3, 3)
        GCRS-to-body matrix at the epoch.

    Returns
    -------
    SlewBack or None
        None if the scenario requests no slew back or has magnetorquer control.

    Raises
    ------
    InvalidValue
        If the slew back would take longer than the longest run.
    """
    if not scenario.maneuvers.slew_back or isinstance(limits, MagnetorquerDrive):
        return None
    step = scenario.step
    truncated = _truncate_design(np.asarray(design, dtype=float), t_end, step, limits)
    last = round(t_end / step)
    plan = build_schedule(truncated, step, limits, last)
    search = SlewSearch(
        scenario, t_end, limits, *_compute_attitude_and_rate(plan, last, step, initial_attitude)
    )
    infeasible_steps, feasible_steps = 0, 1
    while (maneuvers := search.find_maneuvers(feasible_steps)) is None:
        if feasible_steps >= scenario.n_steps:
            raise InvalidValue(
                "maneuvers.slew_back",
                True,
                f"no slew back fits into duration = {scenario.duration:g} s at "
                f"maneuvers.max_rate_deg_s = {scenario.maneuvers.max_rate_deg_s:g}; increase one "
                "of them",
            )
        infeasible_steps, feasible_steps = feasible_steps, min(2 * feasible_steps, scenario.n_steps)
    while feasible_steps - infeasible_steps > 1:
        middle = (infeasible_steps + feasible_steps) // 2
        shorter = search.find_maneuvers(middle)
        infeasible_steps, feasible_steps, maneuvers = (
            (middle, feasible_steps, maneuvers)
            if shorter is None
            else (infeasible_steps, middle, shorter)
        )
    return SlewBack(np.concatenate([truncated, maneuvers]), t_end, (last + feasible_steps) * step)


def _truncate_design(
    design: Floats, t_end: float, step: float, limits: SlewLimits | None
) -> Floats:
    """Return the design without the maneuvers after `t_end`.

    The last maneuver ends half a step before `t_end`. With this margin, the next maneuver starts at
    the next step regardless of rounding.
    """
    last_number = int(build_rate_intervals(design, t_end, step, limits).maneuver_numbers[-1])
    table = design.reshape(-1, VARIABLES_PER_MANEUVER)[: last_number + 1].copy()
    table[-1, 3] = t_end - 0.5 * step - table[:-1, 3].sum()
    return table.ravel()


def _compute_attitude_and_rate(
    plan: Schedule, end_step: int, step: float, attitude: Floats
) -> tuple[Floats, Floats]:
    """Return the attitude and the body rate [rad/s] at a given step of a schedule.

    The attitude is a GCRS-to-body matrix. The schedule has one design and starts from the given
    attitude.
    """
    n_steps = plan.count_steps(end_step)[0]
    is_executed = n_steps > 0
    rotation_vectors = -plan.rates[0, is_executed] * (n_steps[is_executed] * step)[:, None]
    matrices = Rotation.from_rotvec(rotation_vectors).as_matrix()
    while len(matrices) > 1:  # Pairwise products of neighbors can be vectorized.
        unpaired = matrices[len(matrices) // 2 * 2 :]
        matrices = np.concatenate(
            [matrices[1::2] @ matrices[: len(matrices) // 2 * 2 : 2], unpaired]
        )
    final_attitude: Floats = matrices[0] @ attitude
    return final_attitude, plan.end_rates[0, is_executed][-1]


@dataclass
class SlewSearch:
    """Search for a slew from a given attitude and body rate to the attitude law of a scenario.

    The slew starts at the time `start` [s].
    """

    scenario: Scenario
    start: float
    limits: SlewLimits | None
    attitude: Floats
    rate: Floats

    def find_maneuvers(self, n_steps: int) -> Floats | None:
        """Find a slew back that takes `n_steps` filter steps, or return None if there is none.

        The result is a design of two maneuvers, shape (8,). The second maneuver changes to the rate
        of the law.
        """
        step, initial = self.scenario.step, self.scenario.initial
        target, final_rate = initial.evaluate_law(self.scenario, self.start + n_steps * step)
        rotation_vector = -Rotation.from_matrix(target @ self.attitude.T).as_rotvec()
        rate = rotation_vector / (n_steps * step)
        if np.linalg.norm(rate) > math.sqrt(3.0) * self._max_rate:  # No rate is high enough.
            return None
        n_ramp_steps = self._count_steps(rate - final_rate)
        while self._count_steps(rate - self.rate) + n_ramp_steps <= n_steps:
            new_rate = self._find_rate(n_steps, n_ramp_steps, target, final_rate, rate)
            if new_rate is None:
                return None
            rate = new_rate
            n_needed = self._count_steps(final_rate - rate)
            if n_needed <= n_ramp_steps:
                is_feasible = self._count_steps(
                    rate - self.rate
                ) + n_ramp_steps <= n_steps and self._is_within_limits(rate)
                return (
                    self._build_design(n_steps, n_ramp_steps, rate, final_rate)
                    if is_feasible
                    else None
                )
            n_ramp_steps = n_needed
        return None

    def _find_rate(
        self,
        n_steps: int,
        n_ramp_steps: int,
        target_attitude: Floats,
        final_rate: Floats,
        guess: Floats,
    ) -> Floats | None:
        """Find the constant body rate at which a slew reaches the target attitude after `n_steps`
        steps.

        The last `n_ramp_steps` of the `n_steps` steps change the rate to `final_rate`. The result
        is None if the search does not converge.
        """
        from scipy.optimize import root  # This import takes long.

        step, time = self.scenario.step, n_steps * self.scenario.step
        limits = self.limits
        if limits is not None:
            limits = dataclasses.replace(limits, initial_rate=self.rate)

        def compute_attitude_error(angle: Floats) -> Floats:
            design = self._build_design(n_steps, n_ramp_steps, angle / time, final_rate)
            reached, _ = _compute_attitude_and_rate(
                build_schedule(design, step, limits, n_steps), n_steps, step, self.attitude
            )
            error: Floats = Rotation.from_matrix(target_attitude @ reached.T).as_rotvec()
            return error

        solution = root(
            compute_attitude_error, guess * time, tol=1e-12, options={"maxfev": _MAX_EVALUATIONS}
        )
        rate: Floats = solution.x / time
        return rate if np.abs(compute_attitude_error(solution.x)).max() < _TOLERANCE else None

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
    """Complete motion of the satellite: filter run, constant-rate hold and slew back.

    Attributes
    ----------
    scenario : Scenario
    body : Body
        Initial attitude, limits on rate changes and step, such as a `FilterModel`.
    design : array, shape (n_var,)
        Rates [deg/s] and duration [s] of each maneuver in turn.
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
        """End time of the design [s], including the constant-rate hold."""
        return max(self.t_end, self.hold_until)

    @cached_property
    def slew_back(self) -> SlewBack | None:
        """Slew back after the end of the design, or None if the plan has no slew back."""
        limits, initial = self.body.slew_limits, self.body.initial_attitude
        return find_slew_back(self.scenario, self.design, self.design_end, limits, initial)

    @property
    def commanded_design(self) -> Floats:
        """Design that the satellite executes, including the maneuvers of the slew back."""
        return self.design if self.slew_back is None else self.slew_back.design

    @property
    def end(self) -> float:
        """End time of the plan [s], including the slew back."""
        return self.design_end if self.slew_back is None else self.slew_back.end

    @cached_property
    def phases(self) -> tuple[Phase, ...]:
        """Motion phases of the plan in chronological order, including the slew back.

        The time for which the last rate is held after `t_end` is a separate phase.
        """
        step, limits = self.body.step, self.body.slew_limits
        phases = split_phases(list_phases(self.design, self.design_end, step, limits), self.t_end)
        return (
            phases if self.slew_back is None else phases + self.slew_back.list_phases(step, limits)
        )

    @cached_property
    def intervals(self) -> RateIntervals:
        """Intervals of constant body rate from the start to the end of the plan."""
        return build_rate_intervals(
            self.commanded_design, self.end, self.body.step, self.body.slew_limits
        )

    @cached_property
    def motion(self) -> Motion:
        """Body rate and attitude at each filter step from the start to the end of the plan."""
        return Motion.from_design(
            self.body, self.commanded_design, round(self.end / self.body.step)
        )

    @property
    def attitude(self) -> Floats:
        """GCRS-to-body matrices at all filter steps of the plan, shape (n + 1, 3, 3)."""
        return self.motion.attitude
