"""Loads of wheels along plans: torques in closed form, momentum by quadrature of another kind."""

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


def torque(inertia, position):
    out = np.empty(3)
    compute_gravity_gradient(
        np.asarray(inertia, dtype=float), np.asarray(position, dtype=float), out
    )
    return out


@pytest.mark.slow
def test_gravity_gradient_is_that_of_the_masses():
    """Of eight point masses in Newton's field, but for the next order of their size over r."""
    rng = np.random.default_rng(2)
    masses, places = rng.uniform(1.0, 2.0, 8), rng.uniform(-1.0, 1.0, (8, 3))
    places -= masses @ places / masses.sum()
    squares = (places**2).sum(axis=1)
    inertia = (masses * squares).sum() * np.eye(3) - np.einsum(
        "m,mi,mj->ij", masses, places, places
    )
    position = np.array([4.0e6, -3.0e6, 5.0e6])
    # the pull at the center of mass has no moment, so that only small differences are added
    away = position + places
    pull = -EARTH_MU * away / np.linalg.norm(away, axis=1)[:, None] ** 3
    pull -= -EARTH_MU * position / np.linalg.norm(position) ** 3
    moment = np.cross(places, masses[:, None] * pull).sum(axis=0)
    np.testing.assert_allclose(
        torque(inertia, position), moment, rtol=0, atol=1e-6 * np.abs(moment).max()
    )


def unloaded(coils, C, B, momentum, step):
    """What coils have given at each step, GCRS, and their torque before and after it, body axes."""
    most = coils.duty_cycle * np.array(coils.max_dipole)
    total, held = np.zeros(3), np.zeros(3)
    for attitude, b, without in zip(C, B, momentum, strict=True):
        before = np.cross(held, b)
        total = total + 0.5 * step * attitude.T @ before
        tau = -attitude @ (without + total) / coils.time_constant
        held = np.cross(b, tau) / (b @ b)
        held = held / max(1.0, np.abs(held / most).max())
        after = np.cross(held, b)
        yield total, before, after
        total = total + 0.5 * step * attitude.T @ after


def by_hand(given, x, end_steps):
    """Momentum and torque of each wheel along a plan, by scipy's rotations and NumPy's sums."""
    problem = AttitudeManeuverProblem(given)
    model, wheels = problem.model, given.wheels
    plan = build_schedule(x[None], model.step, model.slew_limits, model.n_steps)
    stretch = np.searchsorted(plan.starts[0], np.arange(end_steps), side="right") - 1
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
    added = np.vstack([np.zeros(3), np.cumsum(steps, axis=0)])
    H0 = C0.T @ (A @ h0 + J @ w0) if wheels.initial_momentum else np.zeros(3)
    own = np.einsum("kij,kj->ki", C, np.broadcast_to(H0, added.shape))
    extra = np.einsum("kij,kj->ki", C, added)
    known = np.zeros((2, *T.shape))  # torque that counts with its sign
    if given.magnetorquers is not None:
        made = zip(*unloaded(given.magnetorquers, C, B, H0 + added, model.step), strict=True)
        taken, *torques = map(np.array, made)
        own = np.einsum("kij,kj->ki", C, H0 + added + taken)
        known = T + np.array(torques)
    ends = plan.end_rates[0][stretch]
    begins = np.vstack([w0, ends[:-1]])
    ramps = (plan.rates[0] != plan.end_rates[0]).any(axis=1)[stretch]
    begins = np.where(ramps[:, None], begins, plan.rates[0][stretch])
    # the last step of a ramp ends before the step does; found by how far the mean is
    change = ends - begins
    size = (change**2).sum(axis=1)
    way = np.ones(end_steps)
    way[ramps] = (change * (plan.rates[0][stretch] - begins)).sum(axis=1)[ramps] / size[ramps]
    with np.errstate(divide="ignore", invalid="ignore"):
        acceleration = np.where(
            ramps[:, None], change / (2.0 * (1.0 - way) * model.step)[:, None], 0.0
        )
    sides = (known[1], begins, slice(0, end_steps)), (known[0], ends, slice(1, end_steps + 1))
    for with_sign, rate, at in sides:
        momentum = own[at] - rate @ J, extra[at]
        effort = (
            acceleration @ J + np.cross(rate, own[at]) - with_sign[at],
            T[at] - np.cross(rate, extra[at]),
        )
        for which, (plain, disturbance) in enumerate((momentum, effort)):
            yield which, plain, disturbance


def loads(given, x, end_steps):
    """Greatest momentum and torque of a wheel, with the pseudo-inverse of the wheels' axes."""
    wheels = given.wheels
    A = wheels.normalized_axes().T
    h0 = np.array(wheels.initial_momentum or np.zeros(A.shape[1]))
    W = np.linalg.pinv(A)
    circulating = h0 - W @ A @ h0
    greatest = [0.0, 0.0]
    for which, plain, disturbance in by_hand(given, x, end_steps):
        load = np.abs(plain @ W.T + (0.0 if which else circulating))
        margin = wheels.disturbance_margin - (given.magnetorquers is not None)
        load = load + margin * np.abs(disturbance @ W.T)
        greatest[which] = max(greatest[which], load.max())
    return greatest


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
def test_compiled_loads_are_those_of_slow_sums(maneuvers, initial, wheels):
    given = scenario(maneuvers, initial, **wheels)
    model = FilterModel.from_scenario(given)
    X = designs(np.random.default_rng(3), 6, max_duration=300.0)
    X[:, np.arange(12) % 4 != 3] *= 0.5
    result = evaluate(model, X)
    ends = np.rint(result.t_end / model.step).astype(int)
    expected = [loads(given, x, end) for x, end in zip(X, ends, strict=True)]
    np.testing.assert_allclose(result.wheel_load, expected, rtol=1e-9)
    for threads in (1, 5):
        again = compute_wheel_loads(
            model.momentum_budget, model.build_schedule(X), ends, model.step, threads
        )
        np.testing.assert_array_equal(again, result.wheel_load)


@pytest.mark.slow
def test_momentum_at_rest_is_the_integral_of_a_constant_torque():
    """In a field and gravity that do not change: h = h0 + margin |T| t, to the last digit."""
    given = scenario(axes=((1, 0, 0), (0, 1, 0), (0, 0, 1)), initial_momentum=(1e-3, 2e-3, -3e-3))
    model = FilterModel.from_scenario(given)
    n = model.n_steps + 1
    position, field = np.array([4e6, -3e6, 5e6]), np.array([2e-5, -1e-5, 3e-5])
    budget = dataclasses.replace(
        model.momentum_budget, position=np.tile(position, (n, 1)), field=np.tile(field, (n, 1))
    )
    T = torque(given.wheels.inertia_matrix(), position) + np.cross([0.01, -0.02, 0.005], field)
    found = compute_wheel_loads(
        budget, model.build_schedule(np.zeros((1, 12))), np.array([900]), 1.0, 1
    )[0]
    assert found[0] == pytest.approx(
        np.max([1e-3, 2e-3, 3e-3] + 2.0 * np.abs(T) * 900.0), rel=1e-12
    )
    assert found[1] == pytest.approx(2.0 * np.abs(T).max(), rel=1e-12)


def test_coils_unload_what_is_across_the_field():
    """At rest in a field that stays: by a share of step / response in each; along it nothing."""
    quiet = {"residual_dipole": (0.0,) * 3, "gravity_gradient": False}
    axes = {"axes": ((1, 0, 0), (0, 1, 0), (0, 0, 1))}
    strong = dataclasses.replace(UNLOADING, max_dipole=(50.0, 50.0, 50.0))
    given = scenario(None, None, strong, **quiet, **axes, initial_momentum=(1e-3, 2e-3, 0.0))
    model = FilterModel.from_scenario(given)
    field = np.tile([0.0, 4e-5, 0.0], (model.n_steps + 1, 1))
    budget = dataclasses.replace(model.momentum_budget, field=field @ model.initial_attitude)
    still = model.build_schedule(np.zeros((1, 12)))
    for after in (0, 10, 50):
        found = compute_wheel_loads(budget, still, np.array([900]), 1.0, 1, after)[0]
        assert found[0] == pytest.approx(2e-3, rel=1e-12)  # about y, along the field
        assert found[1] == pytest.approx(1e-3 / 20.0 * 0.95**after, rel=1e-9)  # what x gives
    weak = dataclasses.replace(budget, magnetorquer_dipole=np.full(3, 0.01))
    found = compute_wheel_loads(weak, still, np.array([900]), 1.0, 1)[0]
    assert found[1] == pytest.approx(0.01 * 4e-5, rel=1e-12)  # at its most


def momentum_along_x():
    """The model of a body without disturbances whose wheels about x hold all momentum."""
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


def test_a_turn_across_the_momentum_brings_it_to_every_axis():
    """H along x, turning about z at w: its components go round, and the torque is w H."""
    model, w = momentum_along_x(), np.radians(1.0)
    budget, plan = model.momentum_budget, model.build_schedule([[0.0, 0.0, 1.0, 2000.0]])
    found = compute_wheel_loads(budget, plan, np.array([90]), 1.0, 1)[0]
    assert found[0] == pytest.approx(2e-3, rel=1e-12)
    assert found[1] == pytest.approx(2e-3 * w, rel=1e-9)
    turned = Rotation.from_rotvec([0.0, 0.0, -w * 30.0]).apply([2e-3, 0.0, 0.0])
    part = compute_wheel_loads(budget, plan, np.array([30]), 1.0, 1)[0]
    assert part[0] == pytest.approx(max(2e-3, np.abs(turned).max(), 0.05 * w), rel=1e-12)


def test_loads_from_a_step_on_are_those_of_the_rest():
    """The greatest of a part and of what follows is the greatest of all."""
    model = FilterModel.from_scenario(scenario(None, SPINNING))
    X = designs(np.random.default_rng(8), 5, max_duration=300.0)
    plan, ends = model.build_schedule(X), np.full(5, 900)
    whole = compute_wheel_loads(model.momentum_budget, plan, ends, 1.0, 1)
    for k in (1, 137, 500, 899):
        before = compute_wheel_loads(model.momentum_budget, plan, np.full(5, k), 1.0, 1)
        after = compute_wheel_loads(model.momentum_budget, plan, ends, 1.0, 1, k)
        np.testing.assert_array_equal(np.maximum(before, after), whole)
        assert (after < whole).any() or k < 500


def test_both_are_constraints_in_their_units():
    given = scenario(max_momentum=2.5e-3)
    entries = {entry.label: entry for entry in list_constraints(given)}
    assert [*entries] == ["wheel momentum", "wheel torque"]
    model = FilterModel.from_scenario(given)
    X = designs(np.random.default_rng(5), 6, max_duration=200.0)
    result = evaluate(model, X)
    for column, (label, bound) in enumerate((("wheel momentum", 2.5e-3), ("wheel torque", 1e-4))):
        found = entries[label].compute_violations(result).max(axis=0)
        np.testing.assert_allclose(found, result.wheel_load[:, column] / bound - 1.0, rtol=1e-12)
        violated = found > 0.0
        assert violated.any() == (column == 0)  # ramps leave 40 % of the torque for the rest
        assert not violated.all()


@pytest.mark.parametrize("allocation", ALLOCATIONS)
def test_without_a_budget_four_wheels_share_the_momentum_by_their_allocation(allocation):
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
    for found, x in zip(entry.compute_violations(result).max(axis=0), X, strict=True):
        plan = build_schedule(x[None], model.step, model.slew_limits, model.n_steps)
        ends = plan.end_rates[0][plan.has_duration()[0]]
        expected = np.abs(ends @ given.wheels.inertia_matrix() @ W.T).max()
        assert found == pytest.approx(expected / 4e-3 - 1.0, rel=1e-9)


def test_a_spin_about_the_momentum_moves_nothing():
    """H along x, turning about x: h = H - J ω all the time, and no gyroscopic torque."""
    model = momentum_along_x()
    x = np.array([[0.5, 0.0, 0.0, 200.0, -0.5, 0.0, 0.0, 200.0, 0.0, 0.0, 0.0, 10.0]])
    found = evaluate(model, x).wheel_load[0]
    assert found[0] == pytest.approx(2e-3 + 0.13 * np.radians(0.5), rel=1e-12)
    assert found[1] == pytest.approx(0.0, abs=1e-18)


def test_a_spin_that_goes_on_leaves_the_wheels_as_they_are():
    """A body that turns about a principal axis keeps its momentum without a torque; slowed down,
    its wheels take what it had: J ω about z, at once or along a ramp, wherever it starts from."""
    quiet = {
        "residual_dipole": (0.0,) * 3,
        "gravity_gradient": False,
        "products_of_inertia": (0.0,) * 3,
        "axes": ((1, 0, 0), (0, 1, 0), (0, 0, 1)),
        "initial_momentum": (0.0, 0.0, 1e-4),
        "max_torque": None,
        "ramp_share": 1.0,
    }
    initial = InitialConditions(pointing="sun", rate_deg_s=(0.0, 0.0, 0.5))
    model = FilterModel.from_scenario(scenario(None, initial, **quiet))
    spin = 0.05 * np.radians(0.5)
    going, stopped = ([0.0, 0.0, rate, 900.0] for rate in (0.5, 0.0))
    found = evaluate(model, [going * 3, stopped * 3]).wheel_load
    np.testing.assert_allclose(found[:, 0], [1e-4, 1e-4 + spin], rtol=1e-12)
    np.testing.assert_allclose(found[:, 1], 0.0, atol=1e-18)
    ramped = scenario(ManeuverBounds(max_acceleration_deg_s2=0.02), initial, **quiet)
    found = evaluate(FilterModel.from_scenario(ramped), [stopped * 3]).wheel_load[0]
    np.testing.assert_allclose(found, [1e-4 + spin, 0.05 * np.radians(0.02)], rtol=1e-9)
