"""The way back to the attitude law of the start: by hand, and flown step by step."""

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


def scenario(limits, initial=None, **changes):
    table = {"preset": "cubesat_6u", "duration": 3000.0, "initial": initial or {}}
    table |= LIMITS[limits] | changes
    table["maneuvers"] = {"slew_back": True} | table.get("maneuvers", {})
    return Scenario.from_dict(table)


def back_of(scene, design, t_end, model=None):
    model = model or FilterModel.from_scenario(scene)
    found = find_slew_back(scene, design, t_end, model.slew_limits, model.initial_attitude)
    return model, found


def step_rates(model, design, n_steps):
    """Mean body rate in every step, and the rate at its end [rad/s]."""
    plan = build_schedule(design, model.step, model.slew_limits, n_steps)
    which = np.repeat(np.arange(plan.starts.shape[1]), plan.count_steps(n_steps)[0])
    return plan.rates[0, which], plan.end_rates[0, which]


def flown(model, rates):
    """The attitude after steps at these rates from the start of the plan, by scipy."""
    turns = Rotation.from_rotvec(-rates * model.step)
    while len(turns) > 1:  # every two neighbors at once: one after the other takes far longer
        pairs = turns[1::2] * turns[: len(turns) // 2 * 2 : 2]
        turns = Rotation.concatenate([pairs, turns[-1:]]) if len(turns) % 2 else pairs
    return turns[0] * Rotation.from_matrix(model.initial_attitude)


def designs(rng, n):
    X = rng.uniform(-0.4, 0.4, (n, 12))
    X[:, 3::4] = rng.uniform(0.0, 400.0, (n, 3))
    return X


@pytest.mark.parametrize(
    ("limits", "rate", "angle", "seconds"),
    [
        ("none", 0.5, 90.0, 90),  # 90 deg at 1 deg/s
        ("acceleration", 0.5, 90.0, 110),  # with two ramps of 20 s, 10 deg each
        ("acceleration", 0.1, 4.0, 18),  # too near for the full rate: 2 √(4 / 0.05) = 17.9
        ("slow", 0.2, 36.0, 170),  # 0.4 deg/s after 80 s, 16 deg: 90 + 80 s
    ],
)
def test_from_rest_about_one_axis_by_hand(limits, rate, angle, seconds):
    design = [0.0, 0.0, rate, angle / rate, 0.0, 0.0, 0.0, 100.0]
    scene = scenario(limits)
    model, back = back_of(scene, design, 1200.0)
    assert (back.start, back.end - back.start) == (1200.0, seconds)
    _, ends = step_rates(model, back.design, round(back.end / model.step))
    np.testing.assert_allclose(ends[:, :2], 0.0, atol=1e-9)
    assert np.degrees(ends[:, 2].min()) >= -scene.maneuvers.max_rate_deg_s * (1 + 2e-9)


@pytest.mark.parametrize(("limits", "pointing"), [("none", "nadir"), ("wheels", "velocity")])
def test_it_arrives_at_the_law_within_all_limits(limits, pointing):
    """Attitude and rate; all steps flown by scipy, from the start of the plan."""
    scene = scenario(limits, {"pointing": pointing})
    model = FilterModel.from_scenario(scene)
    for x, t_end in zip(designs(np.random.default_rng(4), 2), (1500.0, 2998.0), strict=True):
        _, back = back_of(scene, x, t_end, model)
        n = round(back.end / model.step)
        assert n * model.step == back.end > back.start == t_end
        rates, ends = step_rates(model, back.design, n)
        before, _ = step_rates(model, x[None], round(t_end / model.step))
        np.testing.assert_array_equal(rates[: len(before)], before)
        attitude = flown(model, rates)
        at = SatelliteState.from_times(scene, np.array([back.end]))
        law = scene.initial.compute_attitude(at)[0]
        assert (attitude * Rotation.from_matrix(law).inv()).magnitude() < 1e-9
        final = build_schedule(back.design, model.step, model.slew_limits, n + 1)
        last = final.rates[0, final.has_duration()[0]][-1]
        np.testing.assert_allclose(last, scene.initial.compute_law_rate(at)[0], rtol=0, atol=1e-15)

        slew = ends[len(before) :]
        assert np.degrees(np.abs(slew).max()) <= scene.maneuvers.max_rate_deg_s * (1 + 2e-9)
        change = np.diff(ends[len(before) - 1 :], axis=0) / model.step
        if scene.maneuvers.max_acceleration_deg_s2:
            assert np.degrees(np.abs(change).max()) <= scene.maneuvers.max_acceleration_deg_s2 * (
                1 + 1e-9
            )
        if scene.wheels:
            inertia = scene.wheels.inertia_matrix()
            assert np.abs(change @ inertia).max() <= scene.wheels.max_torque * (1 + 1e-9)
            assert np.abs(slew @ inertia).max() <= scene.wheels.max_momentum * (1 + 2e-9)


@pytest.mark.parametrize("limits", ["none", pytest.param("acceleration", marks=pytest.mark.slow)])
def test_no_sooner_slew_is_found_by_trying_all(limits, monkeypatch):
    scene = scenario(limits, {"pointing": "nadir"})
    x = designs(np.random.default_rng(8), 1)[0]
    _, back = back_of(scene, x, 1500.0)
    model, tried = FilterModel.from_scenario(scene), {}
    original = SlewSearch.find_maneuvers

    def remembered(self, n):
        if not tried:  # there is one search, and it asks for few of them
            for steps in range(1, round(back.end - back.start) + 1):
                tried[steps] = original(self, steps)
        return original(self, n)

    monkeypatch.setattr(SlewSearch, "find_maneuvers", remembered)
    find_slew_back(scene, x, 1500.0, model.slew_limits, model.initial_attitude)
    assert [n for n, found in tried.items() if found is not None] == [back.end - back.start]


def test_a_way_that_is_too_long_is_refused():
    """The Earth's center has gone 35 deg ahead, and followed 0.005 deg/s faster than it goes."""
    slow = {"max_rate_deg_s": 0.065}
    slow = scenario("none", {"pointing": "nadir"}, duration=600.0, maneuvers=slow)
    with pytest.raises(InvalidValue, match=r"maneuvers\.slew_back = True: no slew back fits into"):
        back_of(slow, [0.0, 0.0, 0.0, 100.0], 590.0)
