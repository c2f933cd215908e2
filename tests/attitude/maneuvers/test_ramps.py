"""Ramps between body rates with limited acceleration or torque, in filter steps."""

import numpy as np
import pytest
from mgeo_attitude.maneuvers.actuation import SlewLimits
from mgeo_attitude.maneuvers.motion import compute_attitudes
from mgeo_attitude.maneuvers.schedule import build_rate_intervals, build_schedule
from scipy.spatial.transform import Rotation

STEP = 1.0
SLOW = SlewLimits(np.radians(0.02), np.inf, np.eye(3))
DESIGN = [0.4, 0.0, -0.2, 100.0, -0.1, 0.0, 0.0, 60.0]


def expand_rates(plan, n_steps, row=0):
    """Return the body rate in every step [deg/s], shape (n_steps, 3), from the intervals."""
    rates = np.zeros((n_steps, 3))
    selected = plan.has_duration()[row]
    for rate, start in zip(plan.rates[row, selected], plan.starts[row, selected], strict=True):
        rates[start:] = np.degrees(rate)
    return rates


def compute_rate_vertices(design, acceleration, step):
    """Return times [s] and rates [deg/s] of the vertices of the piecewise linear body rate."""
    maneuvers = np.reshape(design, (-1, 4))
    edges = np.ceil(np.append(0.0, np.cumsum(maneuvers[:, 3])) / step) * step
    edges[-1] = np.inf
    times, rates = [0.0], [np.zeros(3)]
    for start, end, target in zip(edges, edges[1:], maneuvers[:, :3], strict=False):
        change = target - rates[-1]
        ramp = np.abs(change).max() / acceleration
        if end > start and ramp > 0.0:
            duration = min(ramp, end - start)
            times += [start, start + duration]
            rates += [rates[-1], rates[-1] + change * duration / ramp]
    return np.array(times), np.array(rates)


def integrate_rates(design, acceleration, step, n_steps):
    """Return the integral of the body rate [deg] until each step, and the rate [deg/s]."""
    times, rates = compute_rate_vertices(design, acceleration, step)
    steps = step * np.arange(n_steps + 1)
    grid = np.union1d(times, steps)
    curve = np.column_stack([np.interp(grid, times, axis) for axis in rates.T])
    areas = np.diff(grid)[:, None] * (curve[1:] + curve[:-1]) / 2.0
    at = np.searchsorted(grid, steps)
    return np.vstack([np.zeros(3), np.cumsum(areas, axis=0)])[at], curve[at]


#: Design, acceleration and step: ramps shorter than a step, ramps that end within a step, ramps
#: that are cut short, and skipped maneuvers.
SHORT_RAMPS = [
    ([1.0, 0.0, 0.0, 100.0], 2.0, 1.0),
    ([1.0, 0.0, 0.0, 100.0], 0.2, 10.0),
    ([1.0, -0.5, 0.2, 30.0, -1.0, 0.3, 0.0, 25.0, 0.0, 0.0, 0.0, 9.0], 0.13, 1.0),
    ([1.0, -0.5, 0.2, 30.0, -1.0, 0.3, 0.0, 25.0, 0.0, 0.0, 0.0, 9.0], 0.13, 10.0),
    ([1.0, 0.0, 0.0, 3.0, -1.0, 0.0, 0.0, 3.0, 0.0, 1.0, 0.0, 0.0], 0.4, 1.0),
    ([1.0, 0.0, 0.0, 0.2, -1.0, 0.0, 0.0, 0.2, 0.0, 1.0, 0.0, 0.2], 3.0, 1.0),
    ([1.0, 0.0, 0.0, 1.0, -1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0], 1.6, 1.0),
]


@pytest.mark.parametrize(("design", "acceleration", "step"), SHORT_RAMPS)
def test_rate_in_each_step_of_ramp_is_exact_mean(design, acceleration, step):
    n_steps = 40
    plan = build_schedule([design], step, SlewLimits(np.radians(acceleration), np.inf, np.eye(3)))
    angles, ends = integrate_rates(design, acceleration, step, n_steps)
    rates = expand_rates(plan, n_steps)
    np.testing.assert_allclose(rates, np.diff(angles, axis=0) / step, rtol=0, atol=1e-14)
    changes = np.diff(rates, axis=0, prepend=np.zeros((1, 3)))
    assert np.abs(changes).max() <= acceleration * step * (1.0 + 1e-12)
    starts = plan.starts[0, plan.has_duration()[0]]
    end_rates = np.degrees(plan.end_rates[0, plan.has_duration()[0]])
    for end, rate in zip(starts[1:], end_rates, strict=False):
        if end <= n_steps:
            np.testing.assert_allclose(rate, ends[end], rtol=0, atol=1e-14)
    np.testing.assert_allclose(end_rates[-1], design[-4:-1], rtol=0, atol=1e-14)


@pytest.mark.parametrize(("acceleration", "step"), [(2.0, 1.0), (0.2, 10.0), (0.07, 1.0)])
def test_attitude_after_ramps_about_one_axis_is_integral_of_rate(acceleration, step):
    axis = np.array([2.0, -1.0, 2.0]) / 3.0
    design = np.concatenate([[*(0.9 * axis), 33.0], [*(-0.6 * axis), 27.0], [*(0.3 * axis), 90.0]])
    plan = build_schedule([design], step, SlewLimits(np.radians(acceleration), np.inf, np.eye(3)))
    C = compute_attitudes(plan.rates[0], plan.starts[0], 30, step)
    angles, _ = integrate_rates(design, acceleration, step, 30)
    expected = Rotation.from_rotvec(-angles, degrees=True).as_matrix()
    np.testing.assert_allclose(C, expected, rtol=0, atol=1e-13)
    intervals = build_rate_intervals(
        design, 30 * step, step, SlewLimits(np.radians(acceleration), np.inf, np.eye(3))
    )
    total = np.degrees(np.diff(intervals.times) @ intervals.rates)
    np.testing.assert_allclose(total, angles[-1], rtol=0, atol=1e-12)


@pytest.mark.parametrize("acceleration", [1e-9, 1e-300])
def test_very_long_ramp_is_cut_off_at_end_of_run(acceleration):
    """All steps of the ramp would fill the memory."""
    limits = SlewLimits(np.radians(acceleration), np.inf, np.eye(3))
    plan = build_schedule([DESIGN, DESIGN], STEP, limits, n_steps=130)
    assert plan.rates.shape == (2, 132, 3)
    assert plan.has_duration().sum(axis=1).tolist() == [130, 130]
    # In the first 100 s, the rate changes as much as the acceleration limit allows.
    change = expand_rates(plan, 130)[99, 0]
    assert change == pytest.approx(99.5 * acceleration, rel=1e-12)
    assert build_rate_intervals(DESIGN, 130.0, STEP, limits).times.tolist() == [*range(131)]


def test_ramp_time_is_limited_by_torque_and_inertia():
    """A torque of 0.01 N m accelerates 2 kg m² at 0.005 rad/s²: 0.1 rad/s take 20 s."""
    weak = SlewLimits(np.inf, 0.01, np.diag([1.0, 2.0, 1.0]))
    assert weak.compute_ramp_time(np.array([0.0, 0.1, 0.0])) == pytest.approx(20.0)
    assert weak.compute_ramp_time(np.array([0.1, 0.0, 0.0])) == pytest.approx(10.0)
    tilted = SlewLimits(np.inf, 0.01, np.array([[1.0, 0.5, 0.0], [0.5, 2.0, 0.0], [0.0, 0.0, 1.0]]))
    assert tilted.compute_ramp_time(np.array([0.1, 0.1, 0.0])) == pytest.approx(25.0)


def test_designs_of_batch_are_independent():
    rng = np.random.default_rng(0)
    X = rng.uniform(-1.0, 1.0, (20, 12))
    X[:, 3::4] = rng.uniform(0.0, 150.0, (20, 3)) * (rng.random((20, 3)) > 0.2)
    together = build_schedule(X, STEP, SLOW)
    for row, x in enumerate(X):
        alone = build_schedule([x], STEP, SLOW)
        np.testing.assert_array_equal(expand_rates(together, 900, row), expand_rates(alone, 900))
        assert together.maneuver_end_steps[row] == alone.maneuver_end_steps[0]
        assert np.all(np.diff(together.starts[row]) >= 0)
