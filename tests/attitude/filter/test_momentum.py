"""Loads of reaction wheels along plans, compared with closed forms and NumPy."""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude import AttitudeManeuverProblem, FilterModel, Scenario, evaluate
from mgeo_attitude.criteria.constraints import list_constraints
from mgeo_attitude.environment.constants import EARTH_MU
from mgeo_attitude.filter.wheel_load import compute_gravity_gradient, compute_wheel_loads
from mgeo_attitude.maneuvers.motion import compute_attitudes
from mgeo_attitude.maneuvers.schedule import build_schedule
from mgeo_attitude.scenario import (
    Convergence,
    InitialConditions,
    Magnetorquers,
    ManeuverBounds,
    Wheels,
)
from mgeo_attitude.scenario.actuators import ALLOCATIONS
from scipy.spatial.transform import Rotation

from .agreement import designs

INERTIA = (0.13, 0.10, 0.05)
PYRAMID = ((1.0, 0.0, 1.0), (-1.0, 0.0, 1.0), (0.0, 1.0, 1.0), (0.0, -1.0, 1.0))
FULL = {
    "inertia": INERTIA,
    "products_of_inertia": (0.01, -0.004, 0.002),
    "axes": PYRAMID,
    "initial_momentum": (1e-3, -5e-4, 3e-4, 8e-4),
    "residual_dipole": (0.01, -0.02, 0.005),
    "gravity_gradient": True,
    "max_torque": 1e-4,
    "max_momentum": 4e-3,
    "ramp_share": 0.6,
}


SPINNING = InitialConditions(pointing="velocity", axis=(0.6, 0.0, 0.8), rate_deg_s=(0.3, -0.2, 0.1))


UNLOADING = Magnetorquers(max_dipole=(0.05, 0.1, 0.02), unloads_wheels=True, time_constant=20.0)


def scenario(maneuvers=None, initial=None, magnetorquers=None, **wheels):
    return dataclasses.replace(
        Scenario.cubesat_6u(),
        duration=1500.0,
        convergence=Convergence(window=60.0),
        maneuvers=maneuvers or ManeuverBounds(),
        initial=initial or InitialConditions(),
        wheels=Wheels(**(FULL | wheels)),
        magnetorquers=magnetorquers,
    )


def compute_torque(inertia, position):
    out = np.empty(3)
    compute_gravity_gradient(
        np.asarray(inertia, dtype=float), np.asarray(position, dtype=float), out
    )
    return out


@pytest.mark.slow
def test_gravity_gradient_equals_torque_on_point_masses():
    """The expected torque is that of eight point masses in the field of a point mass."""
    rng = np.random.default_rng(2)
    masses, places = rng.uniform(1.0, 2.0, 8), rng.uniform(-1.0, 1.0, (8, 3))
    places -= masses @ places / masses.sum()
    squares = (places**2).sum(axis=1)
    inertia = (masses * squares).sum() * np.eye(3) - np.einsum(
        "m,mi,mj->ij", masses, places, places
    )
    position = np.array([4.0e6, -3.0e6, 5.0e6])
    # The pull at the center of mass has no torque. It is subtracted so that only small differences
    # are added.
    away = position + places
    pull = -EARTH_MU * away / np.linalg.norm(away, axis=1)[:, None] ** 3
    pull -= -EARTH_MU * position / np.linalg.norm(position) ** 3
    moment = np.cross(places, masses[:, None] * pull).sum(axis=0)
    np.testing.assert_allclose(
        compute_torque(inertia, position), moment, rtol=0, atol=1e-6 * np.abs(moment).max()
    )


def simulate_unloading(magnetorquers, C, B, momentum, step):
    """Yield the unloaded momentum (GCRS) and the torques before and after each step (body axes)."""
    max_dipole = magnetorquers.duty_cycle * np.array(magnetorquers.max_dipole)
    total, dipole = np.zeros(3), np.zeros(3)
    for attitude, b, loaded_momentum in zip(C, B, momentum, strict=True):
        before = np.cross(dipole, b)
        total = total + 0.5 * step * attitude.T @ before
        tau = -attitude @ (loaded_momentum + total) / magnetorquers.time_constant
        dipole = np.cross(b, tau) / (b @ b)
        dipole = dipole / max(1.0, np.abs(dipole / max_dipole).max())
        after = np.cross(dipole, b)
        yield total, before, after
        total = total + 0.5 * step * attitude.T @ after


def iterate_wheel_loads(scenario, x, end_steps):
    """Yield momentum and torque of the body along a plan, at both ends of each step."""
    problem = AttitudeManeuverProblem(scenario)
    model, wheels = problem.model, scenario.wheels
    plan = build_schedule(x[None], model.step, model.slew_limits, model.n_steps)
    interval = np.searchsorted(plan.starts[0], np.arange(end_steps), side="right") - 1
    C0, w0 = model.initial_attitude, model.initial_rate
    C = compute_attitudes(plan.rates[0], plan.starts[0], model.n_steps, model.step, C0)[
        : end_steps + 1
    ]
    J, A = wheels.inertia_matrix(), wheels.normalized_axes().T
    h0 = np.array(wheels.initial_momentum or np.zeros(A.shape[1]))
    r = np.einsum("kij,kj->ki", C, problem.environment.position[: end_steps + 1])
    B = np.einsum("kij,kj->ki", C, 1e-9 * problem.environment.field[: end_steps + 1])
    radius = np.linalg.norm(r, axis=1)[:, None]
    T = np.cross(wheels.residual_dipole, B)
    if wheels.gravity_gradient:
        T = T + 3.0 * EARTH_MU / radius**5 * np.cross(r, r @ J)
    inertial = np.einsum("kji,kj->ki", C, T)
    steps = 0.5 * model.step * (inertial[1:] + inertial[:-1])
    impulse = np.vstack([np.zeros(3), np.cumsum(steps, axis=0)])
    H0 = C0.T @ (A @ h0 + J @ w0) if wheels.initial_momentum else np.zeros(3)
    body_momentum = np.einsum("kij,kj->ki", C, np.broadcast_to(H0, impulse.shape))
    disturbance_momentum = np.einsum("kij,kj->ki", C, impulse)
    signed_torques = np.zeros((2, *T.shape))  # torque with its sign
    if scenario.magnetorquers is not None:
        unloading = zip(
            *simulate_unloading(scenario.magnetorquers, C, B, H0 + impulse, model.step), strict=True
        )
        unloaded, *torques = map(np.array, unloading)
        body_momentum = np.einsum("kij,kj->ki", C, H0 + impulse + unloaded)
        signed_torques = T + np.array(torques)
    end_rates = plan.end_rates[0][interval]
    start_rates = np.vstack([w0, end_rates[:-1]])
    ramps = (plan.rates[0] != plan.end_rates[0]).any(axis=1)[interval]
    start_rates = np.where(ramps[:, None], start_rates, plan.rates[0][interval])
    # The last ramp step ends before the filter step. Its end follows from the mean rate.
    change = end_rates - start_rates
    squared_change = (change**2).sum(axis=1)
    mean_share = np.ones(end_steps)
    mean_share[ramps] = (change * (plan.rates[0][interval] - start_rates)).sum(axis=1)[
        ramps
    ] / squared_change[ramps]
    with np.errstate(divide="ignore", invalid="ignore"):
        acceleration = np.where(
            ramps[:, None], change / (2.0 * (1.0 - mean_share) * model.step)[:, None], 0.0
        )
    sides = (
        (signed_torques[1], start_rates, slice(0, end_steps)),
        (signed_torques[0], end_rates, slice(1, end_steps + 1)),
    )
    for signed_torque, rate, samples in sides:
        momentum = body_momentum[samples] - rate @ J, disturbance_momentum[samples]
        effort = (
            acceleration @ J + np.cross(rate, body_momentum[samples]) - signed_torque[samples],
            T[samples] - np.cross(rate, disturbance_momentum[samples]),
        )
        for quantity, (undisturbed, disturbance) in enumerate((momentum, effort)):
            yield quantity, undisturbed, disturbance


def compute_max_loads(scenario, x, end_steps):
    """Return the largest momentum and torque of a wheel, with the pseudo-inverse allocation."""
    wheels = scenario.wheels
    A = wheels.normalized_axes().T
    h0 = np.array(wheels.initial_momentum or np.zeros(A.shape[1]))
    W = np.linalg.pinv(A)
    null_space_momentum = h0 - W @ A @ h0
    maxima = [0.0, 0.0]
    for quantity, undisturbed, disturbance in iterate_wheel_loads(scenario, x, end_steps):
        load = np.abs(undisturbed @ W.T + (0.0 if quantity else null_space_momentum))
        margin = wheels.disturbance_margin - (scenario.magnetorquers is not None)
        load = load + margin * np.abs(disturbance @ W.T)
        maxima[quantity] = max(maxima[quantity], load.max())
    return maxima


@pytest.mark.slow
@pytest.mark.parametrize(
    ("maneuvers", "initial", "wheels"),
    [
        (ManeuverBounds(max_acceleration_deg_s2=0.03), None, {"disturbance_margin": 1.0}),
        (None, SPINNING, {"max_torque": None, "ramp_share": 1.0}),
        (None, SPINNING, {"magnetorquers": UNLOADING}),
    ],
    ids=["slow ramps", "spinning, at once", "spinning, unloaded"],
)
def test_compiled_loads_equal_numpy_sums(maneuvers, initial, wheels):
    given = scenario(maneuvers, initial, **wheels)
    model = FilterModel.from_scenario(given)
    X = designs(np.random.default_rng(3), 6, max_duration=300.0)
    X[:, np.arange(12) % 4 != 3] *= 0.5
    result = evaluate(model, X)
    ends = np.rint(result.t_end / model.step).astype(int)
    expected = [compute_max_loads(given, x, end) for x, end in zip(X, ends, strict=True)]
    np.testing.assert_allclose(result.wheel_load, expected, rtol=1e-9)
    for threads in (1, 5):
        again = compute_wheel_loads(
            model.momentum_budget, model.build_schedule(X), ends, model.step, threads
        )
        np.testing.assert_array_equal(again, result.wheel_load)


@pytest.mark.slow
def test_momentum_at_rest_is_integral_of_constant_torque():
    """In constant field and gravity, the momentum is h0 + margin |T| t."""
    given = scenario(axes=((1, 0, 0), (0, 1, 0), (0, 0, 1)), initial_momentum=(1e-3, 2e-3, -3e-3))
    model = FilterModel.from_scenario(given)
    n = model.n_steps + 1
    position, field = np.array([4e6, -3e6, 5e6]), np.array([2e-5, -1e-5, 3e-5])
    budget = dataclasses.replace(
        model.momentum_budget, position=np.tile(position, (n, 1)), field=np.tile(field, (n, 1))
    )
    T = compute_torque(given.wheels.inertia_matrix(), position) + np.cross(
        [0.01, -0.02, 0.005], field
    )
    load = compute_wheel_loads(
        budget, model.build_schedule(np.zeros((1, 12))), np.array([900]), 1.0, 1
    )[0]
    assert load[0] == pytest.approx(np.max([1e-3, 2e-3, 3e-3] + 2.0 * np.abs(T) * 900.0), rel=1e-12)
    assert load[1] == pytest.approx(2.0 * np.abs(T).max(), rel=1e-12)


def test_magnetorquers_unload_momentum_perpendicular_to_field():
    """At rest in a constant field, each step unloads the fraction step / time constant."""
    undisturbed = {"residual_dipole": (0.0,) * 3, "gravity_gradient": False}
    axes = {"axes": ((1, 0, 0), (0, 1, 0), (0, 0, 1))}
    strong = dataclasses.replace(UNLOADING, max_dipole=(50.0, 50.0, 50.0))
    given = scenario(None, None, strong, **undisturbed, **axes, initial_momentum=(1e-3, 2e-3, 0.0))
    model = FilterModel.from_scenario(given)
    field = np.tile([0.0, 4e-5, 0.0], (model.n_steps + 1, 1))
    budget = dataclasses.replace(model.momentum_budget, field=field @ model.initial_attitude)
    schedule = model.build_schedule(np.zeros((1, 12)))
    for first_step in (0, 10, 50):
        load = compute_wheel_loads(budget, schedule, np.array([900]), 1.0, 1, first_step)[0]
        assert load[0] == pytest.approx(2e-3, rel=1e-12)  # The momentum about y is along the field.
        assert load[1] == pytest.approx(1e-3 / 20.0 * 0.95**first_step, rel=1e-9)  # torque of x
    weak = dataclasses.replace(budget, magnetorquer_dipole=np.full(3, 0.01))
    load = compute_wheel_loads(weak, schedule, np.array([900]), 1.0, 1)[0]
    assert load[1] == pytest.approx(0.01 * 4e-5, rel=1e-12)  # saturated dipole


def build_model_with_momentum_about_x():
    """Return the model of a body without disturbances, with all momentum in the wheel about x."""
    return FilterModel.from_scenario(
        scenario(
            axes=((1, 0, 0), (0, 1, 0), (0, 0, 1)),
            initial_momentum=(2e-3, 0.0, 0.0),
            max_torque=None,
            ramp_share=1.0,
            residual_dipole=(0.0,) * 3,
            gravity_gradient=False,
            products_of_inertia=(0.0,) * 3,
        )
    )


def test_rotation_perpendicular_to_momentum_needs_gyroscopic_torque():
    """With H along x and rotation about z at the rate w, the wheel torque is w H."""
    model, w = build_model_with_momentum_about_x(), np.radians(1.0)
    budget, plan = model.momentum_budget, model.build_schedule([[0.0, 0.0, 1.0, 2000.0]])
    load = compute_wheel_loads(budget, plan, np.array([90]), 1.0, 1)[0]
    assert load[0] == pytest.approx(2e-3, rel=1e-12)
    assert load[1] == pytest.approx(2e-3 * w, rel=1e-9)
    turned = Rotation.from_rotvec([0.0, 0.0, -w * 30.0]).apply([2e-3, 0.0, 0.0])
    part = compute_wheel_loads(budget, plan, np.array([30]), 1.0, 1)[0]
    assert part[0] == pytest.approx(max(2e-3, np.abs(turned).max(), 0.05 * w), rel=1e-12)


def test_load_maximum_splits_at_any_step():
    """The maximum of the loads before and after a step is the maximum of all loads."""
    model = FilterModel.from_scenario(scenario(None, SPINNING))
    X = designs(np.random.default_rng(8), 5, max_duration=300.0)
    plan, ends = model.build_schedule(X), np.full(5, 900)
    complete = compute_wheel_loads(model.momentum_budget, plan, ends, 1.0, 1)
    for k in (1, 137, 500, 899):
        before = compute_wheel_loads(model.momentum_budget, plan, np.full(5, k), 1.0, 1)
        after = compute_wheel_loads(model.momentum_budget, plan, ends, 1.0, 1, k)
        np.testing.assert_array_equal(np.maximum(before, after), complete)
        assert (after < complete).any() or k < 500


def test_momentum_and_torque_are_constraints():
    given = scenario(max_momentum=2.5e-3)
    entries = {entry.label: entry for entry in list_constraints(given)}
    assert [*entries] == ["wheel momentum", "wheel torque"]
    model = FilterModel.from_scenario(given)
    X = designs(np.random.default_rng(5), 6, max_duration=200.0)
    result = evaluate(model, X)
    for column, (label, bound) in enumerate((("wheel momentum", 2.5e-3), ("wheel torque", 1e-4))):
        actual = entries[label].compute_violations(result).max(axis=0)
        np.testing.assert_allclose(actual, result.wheel_load[:, column] / bound - 1.0, rtol=1e-12)
        violated = actual > 0.0
        assert violated.any() == (column == 0)  # Ramps use 60 % of the torque.
        assert not violated.all()


@pytest.mark.parametrize("allocation", ALLOCATIONS)
def test_four_wheels_share_momentum_by_allocation_without_budget(allocation):
    given = scenario(
        initial_momentum=(),
        residual_dipole=(0.0,) * 3,
        gravity_gradient=False,
        ramp_share=1.0,
        allocation=allocation,
    )
    model = FilterModel.from_scenario(given)
    assert model.momentum_budget is None
    X = designs(np.random.default_rng(5), 4, max_duration=300.0)
    (entry,) = list_constraints(given)
    W = ALLOCATIONS[allocation](given.wheels.normalized_axes())
    result = evaluate(model, X)
    for actual, x in zip(entry.compute_violations(result).max(axis=0), X, strict=True):
        plan = build_schedule(x[None], model.step, model.slew_limits, model.n_steps)
        ends = plan.end_rates[0][plan.has_duration()[0]]
        expected = np.abs(ends @ given.wheels.inertia_matrix() @ W.T).max()
        assert actual == pytest.approx(expected / 4e-3 - 1.0, rel=1e-9)


def test_spin_about_momentum_needs_no_torque():
    """With H along x and rotation about x, h = H - J ω without gyroscopic torque."""
    model = build_model_with_momentum_about_x()
    x = np.array([[0.5, 0.0, 0.0, 200.0, -0.5, 0.0, 0.0, 200.0, 0.0, 0.0, 0.0, 10.0]])
    load = evaluate(model, x).wheel_load[0]
    assert load[0] == pytest.approx(2e-3 + 0.13 * np.radians(0.5), rel=1e-12)
    assert load[1] == pytest.approx(0.0, abs=1e-18)


def test_continued_spin_does_not_load_wheels():
    """A stopped spin about a principal axis loads the wheels by J ω, with or without a ramp."""
    undisturbed = {
        "residual_dipole": (0.0,) * 3,
        "gravity_gradient": False,
        "products_of_inertia": (0.0,) * 3,
        "axes": ((1, 0, 0), (0, 1, 0), (0, 0, 1)),
        "initial_momentum": (0.0, 0.0, 1e-4),
        "max_torque": None,
        "ramp_share": 1.0,
    }
    initial = InitialConditions(pointing="sun", rate_deg_s=(0.0, 0.0, 0.5))
    model = FilterModel.from_scenario(scenario(None, initial, **undisturbed))
    spin = 0.05 * np.radians(0.5)
    continued, stopped = ([0.0, 0.0, rate, 900.0] for rate in (0.5, 0.0))
    load = evaluate(model, [continued * 3, stopped * 3]).wheel_load
    np.testing.assert_allclose(load[:, 0], [1e-4, 1e-4 + spin], rtol=1e-12)
    np.testing.assert_allclose(load[:, 1], 0.0, atol=1e-18)
    ramped = scenario(ManeuverBounds(max_acceleration_deg_s2=0.02), initial, **undisturbed)
    load = evaluate(FilterModel.from_scenario(ramped), [stopped * 3]).wheel_load[0]
    np.testing.assert_allclose(load, [1e-4 + spin, 0.05 * np.radians(0.02)], rtol=1e-9)
