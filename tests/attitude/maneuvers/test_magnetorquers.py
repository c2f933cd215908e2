"""Motion under magnetorquers, against an integration of the control law by SciPy."""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude import FilterModel, compare_filters, evaluate
from mgeo_attitude.maneuvers.motion import RAMP_PREFIX, Motion, list_phases
from mgeo_attitude.scenario import Scenario
from mgeo_attitude.settings.errors import InvalidValue
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from ...three import three

J = np.array([[0.0021, 2e-5, -1e-5], [2e-5, 0.0018, 3e-5], [-1e-5, 3e-5, 0.0014]])
MAGNETORQUERS = {
    "max_dipole": [0.2, 0.15, 0.1],
    "inertia": [0.0021, 0.0018, 0.0014],
    "products_of_inertia": [2e-5, -1e-5, 3e-5],
    "rate_tolerance_deg_s": 0.3,
    "residual_dipole": [1e-4, -2e-4, 5e-5],
}
#: Spin-up about z, change of the spin axis to x, despin.
DESIGN = np.array([0.1, -0.2, 2.0, 300.0, 1.5, 0.3, 0.0, 250.0, 0.0, 0.0, 0.0, 100.0])


def build_scenario(**changes):
    """Return a 1U cubesat with magnetorquers and an initial rate, in the orbit of cubesat_6u."""
    magnetorquers = MAGNETORQUERS | changes.pop("magnetorquers", {})
    table = {"preset": "cubesat_6u", "duration": 1200.0, "magnetorquers": magnetorquers}
    table["convergence"] = {"rule": "trace"}
    initial = {"rate_deg_s": [0.4, -0.3, 0.2], "quaternion": [0.1, 0.7, -0.1, 0.7]}
    return Scenario.from_dict(
        table | {"initial": initial, "maneuvers": {"count": 3, "max_rate_deg_s": 3.0}} | changes
    )


@pytest.fixture(scope="module")
def model():
    return FilterModel.from_scenario(build_scenario())


@pytest.fixture(scope="module")
def schedule(model):
    return model.build_schedule(DESIGN)


def integrate_motion(field, attitude, rate, design, step, magnetorquers):
    """Return attitudes, rates and whether the magnetorquers are off in each step, by SciPy."""
    max_dipole = 0.8 * np.array(magnetorquers["max_dipole"])
    residual = np.array(magnetorquers["residual_dipole"])
    tolerance = np.radians(magnetorquers["rate_tolerance_deg_s"])
    maneuvers = design.reshape(-1, 4)
    starts = np.ceil(np.append(0.0, np.cumsum(maneuvers[:-1, 3])) / step)
    q, w, off = Rotation.from_matrix(attitude).inv().as_quat(), rate, False
    attitudes, rates, free = [attitude], [], []
    for k in range(len(field) - 1):
        m = np.searchsorted(starts, k, side="right") - 1
        error = w - np.radians(maneuvers[m, :3])
        off = (off and k not in starts) or np.linalg.norm(error) <= tolerance
        mean_field = 0.5 * (field[k] + field[k + 1])
        b = Rotation.from_quat(q).inv().apply(mean_field)
        dipole = np.cross(b, np.cross(w, J @ w) - J @ error / 10.0) / (b @ b)
        dipole = (0.0 if off else 1.0) * dipole / max(1.0, *np.abs(dipole) / max_dipole) + residual

        def derivative(_, y, dipole=dipole, field=mean_field):
            to_body, w = Rotation.from_quat(y[:4]).inv(), y[4:]
            torque = np.cross(dipole, to_body.apply(field)) - np.cross(w, J @ w)
            q_derivative = 0.5 * np.append(y[3] * w + np.cross(y[:3], w), -y[:3] @ w)
            return np.append(q_derivative, np.linalg.solve(J, torque))

        initial, tolerances = np.append(q, w), {"rtol": 1e-12, "atol": 1e-14}
        solution = solve_ivp(derivative, (0.0, step), initial, method="DOP853", **tolerances)
        y = solution.y[:, -1]
        q, w = y[:4] / np.linalg.norm(y[:4]), y[4:]
        attitudes.append(Rotation.from_quat(q).inv().as_matrix())
        rates.append(w)
        free.append(off)
    return np.array(attitudes), np.array(rates), np.array(free)


@pytest.mark.slow
def test_motion_equals_integration_of_control_law_by_scipy(model, schedule):
    drive = model.slew_limits
    field = drive.field[:601]
    attitudes, rates, free = integrate_motion(
        field, model.initial_attitude, model.initial_rate, DESIGN, model.step, MAGNETORQUERS
    )
    assert (schedule.free[0, :600] == free).all()
    assert free[250]
    assert not free[20]
    assert not free[310]
    np.testing.assert_allclose(schedule.end_rates[0, :600], rates, rtol=0.0, atol=1e-9)
    motion = Motion.from_design(model, DESIGN, 600)
    np.testing.assert_allclose(motion.attitude, attitudes, rtol=0.0, atol=1e-9)


@pytest.mark.slow
def test_free_motion_conserves_angular_momentum_and_energy(model):
    off = {"residual_dipole": [0.0, 0.0, 0.0], "rate_tolerance_deg_s": 100.0}
    free = FilterModel.from_scenario(build_scenario(magnetorquers=off))
    plan, motion = free.build_schedule(DESIGN), Motion.from_design(free, DESIGN, 1200)
    rates = np.vstack([free.initial_rate, plan.end_rates[0]])
    assert plan.free.all()
    assert np.ptp(rates, axis=0).min() > 1e-4
    momentum = np.einsum("kji,kj->ki", motion.attitude, rates @ J)
    energy = np.einsum("ki,ij,kj->k", rates, J, rates)
    np.testing.assert_allclose(momentum - momentum[0], 0.0, atol=1e-12 * np.abs(momentum).max())
    np.testing.assert_allclose(energy, energy[0], rtol=1e-12)


@pytest.mark.slow
def test_torque_is_perpendicular_to_field_and_within_maximum_dipole(model, schedule):
    drive, rates = model.slew_limits, np.vstack([model.initial_rate, schedule.end_rates[0]])
    attitude = Motion.from_design(model, DESIGN, 1200).attitude
    inertial = np.einsum("kji,kj->ki", attitude, rates @ J)
    torque = np.diff(inertial, axis=0)[:300]  # Torque during one second, in inertial axes.
    field = 0.5 * (drive.field[:-1] + drive.field[1:])[:300]
    along = np.abs((torque * field).sum(axis=1)) / np.linalg.norm(field, axis=1)
    # The dipole is constant in body axes, so that it rotates with the body during a step.
    assert along.max() < 1e-9 * np.linalg.norm(torque, axis=1).max()
    max_dipole = np.linalg.norm(0.8 * np.array(MAGNETORQUERS["max_dipole"])) + 3e-4
    assert (np.linalg.norm(torque, axis=1) <= max_dipole * np.linalg.norm(field, axis=1)).all()


@pytest.mark.slow
def test_covariance_along_motion_equals_filterpy(model):
    comparison = compare_filters(model, DESIGN)
    assert comparison.has_equal_ends
    assert comparison.n_samples > 300
    assert comparison.max_difference < 1e-9


def test_designs_with_shared_beginning_equal_designs_evaluated_separately():
    """With `history`, each design is evaluated separately."""
    scenario = dataclasses.replace(three("cubesat_1u"), duration=5000.0)
    convergence = dataclasses.replace(scenario.convergence, relative_decrease=0.001)
    model = FilterModel.from_scenario(dataclasses.replace(scenario, convergence=convergence))
    designs = np.array([np.tile([0.3, -1.2, 0.8, each], 3) for each in (10.0, 50.0, 500.0)])
    designs[:, 8:11] *= -1.0
    shared = evaluate(model, designs, covariance=True)
    separate = evaluate(model, designs, history=True)
    assert shared.t_end.tolist() == separate.t_end.tolist()
    assert shared.trace.tolist() == separate.trace.tolist()
    steps = np.rint(shared.t_end / model.step).astype(int)
    for k, step in enumerate(steps):
        np.testing.assert_array_equal(shared.plan.rates[k, :step], separate.plan.rates[k, :step])
        np.testing.assert_array_equal(
            np.diagonal(shared.covariance[k]), separate.variances[k, step]
        )


def test_rotated_satellite_moves_as_satellite_in_rotated_field(model):
    rotation = Rotation.from_rotvec([0.1, -0.05, 0.2]).as_matrix()
    rotated = dataclasses.replace(
        model.slew_limits, initial_attitude=model.initial_attitude @ rotation.T
    )
    rates, starts = np.radians(DESIGN.reshape(1, -1, 4)[:, :, :3]), np.array([[0, 300, 550]])
    expected = rotated.compute_rates(rates, starts, 1.0, 1200)
    rates_in_rotated_field = model.rotate_initial_attitude(rotation).slew_limits.compute_rates(
        rates, starts, 1.0, 1200
    )
    np.testing.assert_allclose(rates_in_rotated_field[1], expected[1], atol=1e-12)


def test_phases_are_magnetorquer_intervals_and_free_motion(model, schedule):
    phases = list_phases(DESIGN, 1200.0, model.step, model.slew_limits)
    ramp, free = phases[:2]
    assert free.label == "maneuver 1"
    assert free.end == 300.0
    assert ramp.label == f"{RAMP_PREFIX}maneuver 1"
    assert ramp.end == schedule.free[0].argmax()
    assert [a.end for a in phases[:-1]] == [b.start for b in phases[1:]]
    assert phases[-1].end == 1200.0
    angles = np.degrees(np.linalg.norm(schedule.rates[0], axis=1)).sum()
    assert sum(phase.rotation_deg for phase in phases) == pytest.approx(angles, rel=1e-12)


@pytest.mark.parametrize(
    ("changes", "key", "suggestion"),
    [
        (
            {"magnetorquers": {"inertia": None, "products_of_inertia": [0.0] * 3}},
            "magnetorquers.inertia",
            "wheels",
        ),
        (
            {"magnetorquers": {"products_of_inertia": [0.1, 0.0, 0.0]}},
            "products_of_inertia",
            "definite",
        ),
        ({"magnetorquers": {"time_constant": 1.0}}, "magnetorquers.time_constant", "2 or more"),
        ({"maneuvers": {"slew_back": True}}, "maneuvers.slew_back", "magnetorquers"),
        ({"maneuvers": {"max_acceleration_deg_s2": 0.1}}, "max_acceleration", "max_dipole"),
        ({"wheels": {"inertia": [1.0, 1.0, 1.0]}}, "magnetorquers.inertia", "wheels.inertia"),
    ],
)
def test_inconsistent_magnetorquers_are_rejected_with_suggestion(changes, key, suggestion):
    with pytest.raises(InvalidValue) as error:
        build_scenario(**changes)
    assert key in str(error.value)
    assert suggestion in str(error.value)
