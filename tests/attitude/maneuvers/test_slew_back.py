"""Slew back to the attitude law of the start, by hand and by integration of each step."""

import numpy as np
import pytest
from mgeo_attitude import FilterModel, Scenario
from mgeo_attitude.environment.directions import SatelliteState
from mgeo_attitude.maneuvers.schedule import build_schedule
from mgeo_attitude.settings.errors import InvalidValue
from mgeo_attitude.trajectory.trajectory import SlewSearch, find_slew_back
from scipy.spatial.transform import Rotation

WHEELS = {"inertia": [0.15, 0.2, 0.3], "products_of_inertia": [0.01, -0.02, 0.03]}
LIMITS = {
    "none": {},
    "acceleration": {"maneuvers": {"max_acceleration_deg_s2": 0.05}},
    "slow": {"maneuvers": {"max_acceleration_deg_s2": 0.005, "max_rate_deg_s": 0.4}, "step": 2.0},
    "wheels": {"wheels": WHEELS | {"max_torque": 2e-4, "max_momentum": 2.5e-3}},
}


def build_scenario(limits, initial=None, **changes):
    table = {"preset": "cubesat_6u", "duration": 3000.0, "initial": initial or {}}
    table |= LIMITS[limits] | changes
    table["maneuvers"] = {"slew_back": True} | table.get("maneuvers", {})
    return Scenario.from_dict(table)


def find_slew(scenario, design, t_end, model=None):
    model = model or FilterModel.from_scenario(scenario)
    slew = find_slew_back(scenario, design, t_end, model.slew_limits, model.initial_attitude)
    return model, slew


def compute_step_rates(model, design, n_steps):
    """Return the mean body rate in every step and the rate at its end [rad/s]."""
    plan = build_schedule(design, model.step, model.slew_limits, n_steps)
    interval = np.repeat(np.arange(plan.starts.shape[1]), plan.count_steps(n_steps)[0])
    return plan.rates[0, interval], plan.end_rates[0, interval]


def integrate_attitude(model, rates):
    """Return the attitude after all steps at given rates from the start of the plan, by SciPy."""
    rotations = Rotation.from_rotvec(-rates * model.step)
    while len(rotations) > 1:  # Products of all pairs of neighbors are faster than a sequence.
        pairs = rotations[1::2] * rotations[: len(rotations) // 2 * 2 : 2]
        rotations = Rotation.concatenate([pairs, rotations[-1:]]) if len(rotations) % 2 else pairs
    return rotations[0] * Rotation.from_matrix(model.initial_attitude)


def draw_designs(rng, n):
    X = rng.uniform(-0.4, 0.4, (n, 12))
    X[:, 3::4] = rng.uniform(0.0, 400.0, (n, 3))
    return X


@pytest.mark.parametrize(
    ("limits", "rate", "angle", "seconds"),
    [
        ("none", 0.5, 90.0, 90),  # 90 deg at 1 deg/s
        ("acceleration", 0.5, 90.0, 110),  # two ramps of 20 s, 10 deg each
        ("acceleration", 0.1, 4.0, 18),  # below the maximum rate: 2 √(4 / 0.05) = 17.9
        ("slow", 0.2, 36.0, 170),  # 0.4 deg/s after 80 s, 16 deg: 90 + 80 s
    ],
)
def test_slew_from_rest_about_one_axis_has_duration_computed_by_hand(limits, rate, angle, seconds):
    design = [0.0, 0.0, rate, angle / rate, 0.0, 0.0, 0.0, 100.0]
    scenario = build_scenario(limits)
    model, slew = find_slew(scenario, design, 1200.0)
    assert (slew.start, slew.end - slew.start) == (1200.0, seconds)
    _, ends = compute_step_rates(model, slew.design, round(slew.end / model.step))
    np.testing.assert_allclose(ends[:, :2], 0.0, atol=1e-9)
    assert np.degrees(ends[:, 2].min()) >= -scenario.maneuvers.max_rate_deg_s * (1 + 2e-9)


@pytest.mark.parametrize(("limits", "pointing"), [("none", "nadir"), ("wheels", "velocity")])
def test_slew_ends_at_attitude_law_within_all_limits(limits, pointing):
    """Attitude and rate follow from all steps since the start of the plan, by SciPy."""
    scenario = build_scenario(limits, {"pointing": pointing})
    model = FilterModel.from_scenario(scenario)
    for x, t_end in zip(draw_designs(np.random.default_rng(4), 2), (1500.0, 2998.0), strict=True):
        _, slew = find_slew(scenario, x, t_end, model)
        n = round(slew.end / model.step)
        assert n * model.step == slew.end > slew.start == t_end
        rates, ends = compute_step_rates(model, slew.design, n)
        before, _ = compute_step_rates(model, x[None], round(t_end / model.step))
        np.testing.assert_array_equal(rates[: len(before)], before)
        attitude = integrate_attitude(model, rates)
        orbit_state = SatelliteState.from_times(scenario, np.array([slew.end]))
        law = scenario.initial.compute_attitude(orbit_state)[0]
        assert (attitude * Rotation.from_matrix(law).inv()).magnitude() < 1e-9
        final = build_schedule(slew.design, model.step, model.slew_limits, n + 1)
        last = final.rates[0, final.has_duration()[0]][-1]
        law_rate = scenario.initial.compute_law_rate(orbit_state)[0]
        np.testing.assert_allclose(last, law_rate, rtol=0, atol=1e-15)

        slew_rates = ends[len(before) :]
        assert np.degrees(np.abs(slew_rates).max()) <= scenario.maneuvers.max_rate_deg_s * (
            1 + 2e-9
        )
        change = np.diff(ends[len(before) - 1 :], axis=0) / model.step
        if max_acceleration := scenario.maneuvers.max_acceleration_deg_s2:
            assert np.degrees(np.abs(change).max()) <= max_acceleration * (1 + 1e-9)
        if scenario.wheels:
            inertia = scenario.wheels.inertia_matrix()
            assert np.abs(change @ inertia).max() <= scenario.wheels.max_torque * (1 + 1e-9)
            assert np.abs(slew_rates @ inertia).max() <= scenario.wheels.max_momentum * (1 + 2e-9)


@pytest.mark.parametrize("limits", ["none", pytest.param("acceleration", marks=pytest.mark.slow)])
def test_no_shorter_slew_exists_among_all_durations(limits, monkeypatch):
    scenario = build_scenario(limits, {"pointing": "nadir"})
    x = draw_designs(np.random.default_rng(8), 1)[0]
    _, slew = find_slew(scenario, x, 1500.0)
    model, tried = FilterModel.from_scenario(scenario), {}
    original = SlewSearch.find_maneuvers

    def try_all_durations(self, n):
        if not tried:  # The search itself tries only few durations.
            for steps in range(1, round(slew.end - slew.start) + 1):
                tried[steps] = original(self, steps)
        return original(self, n)

    monkeypatch.setattr(SlewSearch, "find_maneuvers", try_all_durations)
    find_slew_back(scenario, x, 1500.0, model.slew_limits, model.initial_attitude)
    assert [n for n, maneuvers in tried.items() if maneuvers is not None] == [slew.end - slew.start]


def test_slew_that_exceeds_duration_is_rejected():
    """Nadir is 35 deg ahead, and the maximum rate is only 0.005 deg/s above the orbital rate."""
    maneuvers = {"max_rate_deg_s": 0.065}
    scenario = build_scenario("none", {"pointing": "nadir"}, duration=600.0, maneuvers=maneuvers)
    with pytest.raises(InvalidValue, match=r"maneuvers\.slew_back = True: no slew back fits into"):
        find_slew(scenario, [0.0, 0.0, 0.0, 100.0], 590.0)
