"""Motion by coils against SciPy's integrator, which is given the law and nothing else."""

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
COILS = {
    "max_dipole": [0.2, 0.15, 0.1],
    "inertia": [0.0021, 0.0018, 0.0014],
    "products_of_inertia": [2e-5, -1e-5, 3e-5],
    "rate_tolerance_deg_s": 0.3,
    "residual_dipole": [1e-4, -2e-4, 5e-5],
}
#: Spin up about z, turn over to x, despin.
DESIGN = np.array([0.1, -0.2, 2.0, 300.0, 1.5, 0.3, 0.0, 250.0, 0.0, 0.0, 0.0, 100.0])


def one_unit(**changed):
    """A satellite of one unit with coils, in the cubesat's orbit, at a rate at the start."""
    coils = COILS | changed.pop("magnetorquers", {})
    table = {"preset": "cubesat_6u", "duration": 1200.0, "magnetorquers": coils}
    table["convergence"] = {"rule": "trace"}
    initial = {"rate_deg_s": [0.4, -0.3, 0.2], "quaternion": [0.1, 0.7, -0.1, 0.7]}
    return Scenario.from_dict(
        table | {"initial": initial, "maneuvers": {"count": 3, "max_rate_deg_s": 3.0}} | changed
    )


@pytest.fixture(scope="module")
def model():
    return FilterModel.from_scenario(one_unit())


@pytest.fixture(scope="module")
def flown(model):
    return model.build_schedule(DESIGN)


def integrated(field, attitude, rate, design, step, coils):
    """Attitudes, rates and whether coils are off of a rigid body under the law, by SciPy."""
    most = 0.8 * np.array(coils["max_dipole"])
    residual, near = np.array(coils["residual_dipole"]), np.radians(coils["rate_tolerance_deg_s"])
    table = design.reshape(-1, 4)
    begins = np.ceil(np.append(0.0, np.cumsum(table[:-1, 3])) / step)
    q, w, off = Rotation.from_matrix(attitude).inv().as_quat(), rate, False
    found, rates, free = [attitude], [], []
    for k in range(len(field) - 1):
        m = np.searchsorted(begins, k, side="right") - 1
        error = w - np.radians(table[m, :3])
        off = (off and k not in begins) or np.linalg.norm(error) <= near
        middle = 0.5 * (field[k] + field[k + 1])
        b = Rotation.from_quat(q).inv().apply(middle)
        dipole = np.cross(b, np.cross(w, J @ w) - J @ error / 10.0) / (b @ b)
        dipole = (0.0 if off else 1.0) * dipole / max(1.0, *np.abs(dipole) / most) + residual

        def motion(_, y, dipole=dipole, middle=middle):
            to_body, w = Rotation.from_quat(y[:4]).inv(), y[4:]
            torque = np.cross(dipole, to_body.apply(middle)) - np.cross(w, J @ w)
            turn = 0.5 * np.append(y[3] * w + np.cross(y[:3], w), -y[:3] @ w)
            return np.append(turn, np.linalg.solve(J, torque))

        y = solve_ivp(motion, (0.0, step), np.append(q, w), method="DOP853", rtol=1e-12, atol=1e-14)
        q, w = y.y[:4, -1] / np.linalg.norm(y.y[:4, -1]), y.y[4:, -1]
        found.append(Rotation.from_quat(q).inv().as_matrix())
        rates.append(w)
        free.append(off)
    return np.array(found), np.array(rates), np.array(free)


@pytest.mark.slow
def test_motion_is_that_of_a_rigid_body_under_the_law_by_another_integrator(model, flown):
    drive = model.slew_limits
    field = drive.field[:601]
    attitudes, rates, free = integrated(
        field, model.initial_attitude, model.initial_rate, DESIGN, model.step, COILS
    )
    assert (flown.free[0, :600] == free).all()
    assert free[250]
    assert not free[20]
    assert not free[310]
    np.testing.assert_allclose(flown.end_rates[0, :600], rates, rtol=0.0, atol=1e-9)
    motion = Motion.from_design(model, DESIGN, 600)
    np.testing.assert_allclose(motion.attitude, attitudes, rtol=0.0, atol=1e-9)


@pytest.mark.slow
def test_free_motion_keeps_momentum_in_inertial_axes_and_energy(model):
    quiet = {"residual_dipole": [0.0, 0.0, 0.0], "rate_tolerance_deg_s": 100.0}
    free = FilterModel.from_scenario(one_unit(magnetorquers=quiet))
    plan, motion = free.build_schedule(DESIGN), Motion.from_design(free, DESIGN, 1200)
    rates = np.vstack([free.initial_rate, plan.end_rates[0]])
    assert plan.free.all()
    assert np.ptp(rates, axis=0).min() > 1e-4
    momentum = np.einsum("kji,kj->ki", motion.attitude, rates @ J)
    energy = np.einsum("ki,ij,kj->k", rates, J, rates)
    np.testing.assert_allclose(momentum - momentum[0], 0.0, atol=1e-12 * np.abs(momentum).max())
    np.testing.assert_allclose(energy, energy[0], rtol=1e-12)


@pytest.mark.slow
def test_torque_is_across_the_field_and_no_coil_gives_more_than_it_can(model, flown):
    drive, rates = model.slew_limits, np.vstack([model.initial_rate, flown.end_rates[0]])
    attitude = Motion.from_design(model, DESIGN, 1200).attitude
    inertial = np.einsum("kji,kj->ki", attitude, rates @ J)
    torque = np.diff(inertial, axis=0)[:300]  # of a second, in inertial axes
    field = 0.5 * (drive.field[:-1] + drive.field[1:])[:300]
    along = np.abs((torque * field).sum(axis=1)) / np.linalg.norm(field, axis=1)
    # held in body axes, the dipole turns away from across the field by what the body turns
    assert along.max() < 1e-9 * np.linalg.norm(torque, axis=1).max()
    most = np.linalg.norm(0.8 * np.array(COILS["max_dipole"])) + 3e-4
    assert (np.linalg.norm(torque, axis=1) <= most * np.linalg.norm(field, axis=1)).all()


@pytest.mark.slow
def test_the_filter_runs_along_the_motion_as_filterpy_does(model):
    found = compare_filters(model, DESIGN)
    assert found.has_equal_ends
    assert found.n_samples > 300
    assert found.max_difference < 1e-9


def test_designs_of_coils_that_begin_alike_are_those_flown_each_by_itself():
    """With a history all are, in jobs of their own."""
    scenario = dataclasses.replace(three("cubesat_1u"), duration=5000.0)
    convergence = dataclasses.replace(scenario.convergence, relative_decrease=0.001)
    model = FilterModel.from_scenario(dataclasses.replace(scenario, convergence=convergence))
    designs = np.array([np.tile([0.3, -1.2, 0.8, each], 3) for each in (10.0, 50.0, 500.0)])
    designs[:, 8:11] *= -1.0
    found, whole = evaluate(model, designs, covariance=True), evaluate(model, designs, history=True)
    assert found.t_end.tolist() == whole.t_end.tolist()
    assert found.trace.tolist() == whole.trace.tolist()
    steps = np.rint(found.t_end / model.step).astype(int)
    for k, step in enumerate(steps):
        np.testing.assert_array_equal(found.plan.rates[k, :step], whole.plan.rates[k, :step])
        np.testing.assert_array_equal(np.diagonal(found.covariance[k]), whole.variances[k, step])


def test_a_turned_satellite_moves_as_one_in_a_turned_field(model):
    turn = Rotation.from_rotvec([0.1, -0.05, 0.2]).as_matrix()
    other = dataclasses.replace(model.slew_limits, initial_attitude=model.initial_attitude @ turn.T)
    rates, starts = np.radians(DESIGN.reshape(1, -1, 4)[:, :, :3]), np.array([[0, 300, 550]])
    expected = other.compute_rates(rates, starts, 1.0, 1200)
    found = model.rotate_initial_attitude(turn).slew_limits.compute_rates(rates, starts, 1.0, 1200)
    np.testing.assert_allclose(found[1], expected[1], atol=1e-12)


def test_phases_are_the_time_with_coils_and_free_motion_after_it(model, flown):
    found = list_phases(DESIGN, 1200.0, model.step, model.slew_limits)
    ramp, coast = found[:2]
    assert coast.label == "maneuver 1"
    assert coast.end == 300.0
    assert ramp.label == f"{RAMP_PREFIX}maneuver 1"
    assert ramp.end == flown.free[0].argmax()
    assert [a.end for a in found[:-1]] == [b.start for b in found[1:]]
    assert found[-1].end == 1200.0
    angles = np.degrees(np.linalg.norm(flown.rates[0], axis=1)).sum()
    assert sum(phase.rotation_deg for phase in found) == pytest.approx(angles, rel=1e-12)


@pytest.mark.parametrize(
    ("changed", "key", "words"),
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
def test_what_coils_do_not_go_with_is_refused_with_a_way_out(changed, key, words):
    with pytest.raises(InvalidValue) as refused:
        one_unit(**changed)
    assert key in str(refused.value)
    assert words in str(refused.value)
