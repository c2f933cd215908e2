"""Rates that change as fast as the satellite can, in steps of the filter."""

import numpy as np
import pytest
from mgeo_attitude.maneuvers.actuation import SlewLimits
from mgeo_attitude.maneuvers.motion import compute_attitudes
from mgeo_attitude.maneuvers.schedule import build_rate_intervals, build_schedule
from scipy.spatial.transform import Rotation

STEP = 1.0
SLOW = SlewLimits(np.radians(0.02), np.inf, np.eye(3))
TURN = [0.4, 0.0, -0.2, 100.0, -0.1, 0.0, 0.0, 60.0]


def rates_deg_s(plan, n_steps, row=0):
    """Rate about each axis at every step [deg/s], from the stretches."""
    rates = np.zeros((n_steps, 3))
    flying = plan.has_duration()[row]
    for rate, start in zip(plan.rates[row, flying], plan.starts[row, flying], strict=True):
        rates[start:] = np.degrees(rate)
    return rates


def knots(design, acceleration, step):
    """Corners of the rates as straight lines in time, maneuver by maneuver: [s] and [deg/s]."""
    maneuvers = np.reshape(design, (-1, 4))
    edges = np.ceil(np.append(0.0, np.cumsum(maneuvers[:, 3])) / step) * step
    edges[-1] = np.inf
    times, rates = [0.0], [np.zeros(3)]
    for start, end, target in zip(edges, edges[1:], maneuvers[:, :3], strict=False):
        change = target - rates[-1]
        ramp = np.abs(change).max() / acceleration
        if end > start and ramp > 0.0:
            flying = min(ramp, end - start)
            times += [start, start + flying]
            rates += [rates[-1], rates[-1] + change * flying / ramp]
    return np.array(times), np.array(rates)


def exact(design, acceleration, step, n_steps):
    """The integral of the rates until each step [deg] and the rates then [deg/s]."""
    times, rates = knots(design, acceleration, step)
    steps = step * np.arange(n_steps + 1)
    grid = np.union1d(times, steps)
    curve = np.column_stack([np.interp(grid, times, axis) for axis in rates.T])
    areas = np.diff(grid)[:, None] * (curve[1:] + curve[:-1]) / 2.0
    at = np.searchsorted(grid, steps)
    return np.vstack([np.zeros(3), np.cumsum(areas, axis=0)])[at], curve[at]


#: Ramps shorter than a step, as long as some steps and a part, cut short, of maneuvers not flown.
SHORT = [
    ([1.0, 0.0, 0.0, 100.0], 2.0, 1.0),
    ([1.0, 0.0, 0.0, 100.0], 0.2, 10.0),
    ([1.0, -0.5, 0.2, 30.0, -1.0, 0.3, 0.0, 25.0, 0.0, 0.0, 0.0, 9.0], 0.13, 1.0),
    ([1.0, -0.5, 0.2, 30.0, -1.0, 0.3, 0.0, 25.0, 0.0, 0.0, 0.0, 9.0], 0.13, 10.0),
    ([1.0, 0.0, 0.0, 3.0, -1.0, 0.0, 0.0, 3.0, 0.0, 1.0, 0.0, 0.0], 0.4, 1.0),
    ([1.0, 0.0, 0.0, 0.2, -1.0, 0.0, 0.0, 0.2, 0.0, 1.0, 0.0, 0.2], 3.0, 1.0),
    ([1.0, 0.0, 0.0, 1.0, -1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0], 1.6, 1.0),
]


@pytest.mark.parametrize(("design", "acceleration", "step"), SHORT)
def test_each_step_of_a_ramp_has_its_exact_mean_rate(design, acceleration, step):
    n_steps = 40
    plan = build_schedule([design], step, SlewLimits(np.radians(acceleration), np.inf, np.eye(3)))
    turned, ends = exact(design, acceleration, step, n_steps)
    rates = rates_deg_s(plan, n_steps)
    np.testing.assert_allclose(rates, np.diff(turned, axis=0) / step, rtol=0, atol=1e-14)
    changes = np.diff(rates, axis=0, prepend=np.zeros((1, 3)))
    assert np.abs(changes).max() <= acceleration * step * (1.0 + 1e-12)
    starts = plan.starts[0, plan.has_duration()[0]]
    end_rates = np.degrees(plan.end_rates[0, plan.has_duration()[0]])
    for end, rate in zip(starts[1:], end_rates, strict=False):
        if end <= n_steps:
            np.testing.assert_allclose(rate, ends[end], rtol=0, atol=1e-14)
    np.testing.assert_allclose(end_rates[-1], design[-4:-1], rtol=0, atol=1e-14)  # held


@pytest.mark.parametrize(("acceleration", "step"), [(2.0, 1.0), (0.2, 10.0), (0.07, 1.0)])
def test_the_attitude_after_ramps_about_one_axis_is_the_integral_of_the_rate(acceleration, step):
    axis = np.array([2.0, -1.0, 2.0]) / 3.0
    design = np.concatenate([[*(0.9 * axis), 33.0], [*(-0.6 * axis), 27.0], [*(0.3 * axis), 90.0]])
    plan = build_schedule([design], step, SlewLimits(np.radians(acceleration), np.inf, np.eye(3)))
    C = compute_attitudes(plan.rates[0], plan.starts[0], 30, step)
    turned, _ = exact(design, acceleration, step, 30)
    expected = Rotation.from_rotvec(-turned, degrees=True).as_matrix()
    np.testing.assert_allclose(C, expected, rtol=0, atol=1e-13)
    flight = build_rate_intervals(
        design, 30 * step, step, SlewLimits(np.radians(acceleration), np.inf, np.eye(3))
    )
    turns = np.degrees(np.diff(flight.times) @ flight.rates)
    np.testing.assert_allclose(turns, turned[-1], rtol=0, atol=1e-12)


@pytest.mark.parametrize("acceleration", [1e-9, 1e-300])
def test_a_ramp_that_takes_for_ever_is_flown_until_the_end(acceleration):
    """And no longer: the steps of the rest would fill the memory."""
    limits = SlewLimits(np.radians(acceleration), np.inf, np.eye(3))
    plan = build_schedule([TURN, TURN], STEP, limits, n_steps=130)
    assert plan.rates.shape == (2, 132, 3)
    assert plan.has_duration().sum(axis=1).tolist() == [130, 130]
    # of the change of 0.5 deg/s about x the first 100 s make as much as the limit allows
    change = rates_deg_s(plan, 130)[99, 0]
    assert change == pytest.approx(99.5 * acceleration, rel=1e-12)
    assert build_rate_intervals(TURN, 130.0, STEP, limits).times.tolist() == [*range(131)]


def test_torque_limits_the_ramp_of_a_heavy_axis():
    """0.01 N m turn 2 kg m² at 0.005 rad/s²: 0.1 rad/s take 20 s."""
    weak = SlewLimits(np.inf, 0.01, np.diag([1.0, 2.0, 1.0]))
    assert weak.compute_ramp_time(np.array([0.0, 0.1, 0.0])) == pytest.approx(20.0)
    assert weak.compute_ramp_time(np.array([0.1, 0.0, 0.0])) == pytest.approx(10.0)
    tilted = SlewLimits(np.inf, 0.01, np.array([[1.0, 0.5, 0.0], [0.5, 2.0, 0.0], [0.0, 0.0, 1.0]]))
    assert tilted.compute_ramp_time(np.array([0.1, 0.1, 0.0])) == pytest.approx(25.0)


def test_designs_of_a_batch_do_not_depend_on_each_other():
    rng = np.random.default_rng(0)
    X = rng.uniform(-1.0, 1.0, (20, 12))
    X[:, 3::4] = rng.uniform(0.0, 150.0, (20, 3)) * (rng.random((20, 3)) > 0.2)
    together = build_schedule(X, STEP, SLOW)
    for row, x in enumerate(X):
        alone = build_schedule([x], STEP, SLOW)
        np.testing.assert_array_equal(rates_deg_s(together, 900, row), rates_deg_s(alone, 900))
        assert together.maneuver_end_steps[row] == alone.maneuver_end_steps[0]
        assert np.all(np.diff(together.starts[row]) >= 0)
