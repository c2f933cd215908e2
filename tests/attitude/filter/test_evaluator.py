"""Evaluation of batches by the compiled filter, compared with filterpy."""

import dataclasses

import numpy as np
import pydantic.dataclasses
import pytest
from mgeo_attitude import FilterModel, Magnetometer, Scenario, Sensor, evaluate
from mgeo_attitude.filter.evaluator import count_available_threads
from mgeo_attitude.geometry import vector
from mgeo_attitude.maneuvers.actuation import SlewLimits

from .agreement import assert_agrees, designs, special_designs


def test_filters_agree_on_special_designs():
    coarse = dataclasses.replace(Scenario.paper(), step=4.0)
    X = special_designs(np.random.default_rng(1))
    assert_agrees(FilterModel.from_scenario(coarse), X)


@pytest.mark.parametrize("count", [1, 5])
def test_filters_agree_for_any_number_of_maneuvers(count, short):
    rng = np.random.default_rng(count)
    X = np.tile(rng.uniform(-1.0, 1.0, (10, 4)), count)
    X[:, 3::4] = rng.uniform(0.0, 900.0 / count, (10, count))
    assert_agrees(FilterModel.from_scenario(short), X)


def test_filters_agree_for_ramps_shorter_than_a_step(short):
    # Some ramps are cut short within a maneuver of at most one step.
    model = FilterModel.from_scenario(short)
    ramped = dataclasses.replace(model, slew_limits=SlewLimits(np.radians(0.7), np.inf, np.eye(3)))
    X = designs(np.random.default_rng(14), 12, max_duration=300.0)
    X[:6, 3::4] = np.random.default_rng(15).uniform(0.0, 6.0, (6, 3))
    assert_agrees(ramped, X)


@pydantic.dataclasses.dataclass(frozen=True)
class EarthSensor(Sensor):
    """Sensor of the direction to the Earth's center, with a bias, unavailable on the day side."""

    kind = "earth-sensor"

    def states(self):
        return {"bias": 0.01}

    def linearize_measurement(self, x, v):
        return vector.cross(v, x.theta) + x.bias

    def noise_sigmas(self):
        return (0.005, 0.005, 0.02)

    def inertial_vector(self, environment):
        return -environment.position / np.linalg.norm(environment.position, axis=1)[:, None]

    def find_available_samples(self, environment):
        return np.einsum("ij,ij->i", self.inertial_vector(environment), environment.sun) < 0.0


@pytest.mark.slow
def test_filters_agree_for_user_defined_sensor(short):
    sensors = (EarthSensor(name="earth"), Magnetometer())
    model = FilterModel.from_scenario(dataclasses.replace(short, sensors=sensors))
    assert model.suite.blocks[2] == "earth.bias"
    assert_agrees(model, designs(np.random.default_rng(12), 20, 300.0))


def test_result_does_not_depend_on_batch_order_or_threads(paper):
    X = np.vstack(
        [designs(np.random.default_rng(6), 40), special_designs(np.random.default_rng(7))]
    )
    batch = evaluate(paper, X, threads=1)
    order = np.random.default_rng(8).permutation(len(X))
    shuffled = evaluate(paper, X[order], threads=2)
    single = [evaluate(paper, x, threads=1) for x in X]
    for name in ("t_end", "trace"):
        values = getattr(batch, name)
        np.testing.assert_array_equal(getattr(shuffled, name), values[order])
        np.testing.assert_array_equal([getattr(result, name)[0] for result in single], values)
        np.testing.assert_array_equal(getattr(evaluate(paper, X, threads=3), name), values)


def test_earliest_and_latest_end_of_run(paper):
    """Convergence is tested from the start without maneuvers; without convergence, the run is
    complete.
    """
    never = dataclasses.replace(paper, relative_decrease=-1e9)
    X = designs(np.random.default_rng(9), 3)
    assert (evaluate(never, X).t_end == 11984.0).all()
    always = dataclasses.replace(paper, relative_decrease=1.0 - 1e-12)
    X[:, 3::4] = 0.0
    assert (evaluate(always, X).t_end == 300.0).all()
    X[:, 3::4] = 400.0
    assert (evaluate(always, X).t_end == 1200.0).all()


def test_lost_positive_definiteness_gives_warning_and_nan(paper):
    """With P0 / R = 1e12, some covariances lose positive definiteness."""
    X = designs(np.random.default_rng(10), 20)
    noise = paper.suite.sensors[1].noise_sigmas()[0]
    broken = dataclasses.replace(paper, initial_sigma=np.full(18, 1e6 * noise))
    message = "lost positive definiteness in .* of 20 designs, first"
    with pytest.warns(RuntimeWarning, match=message):
        result = evaluate(broken, X)
    is_lost = np.isnan(result.trace)
    assert is_lost.any()
    np.testing.assert_array_equal(np.isnan(result.t_end), is_lost)
    with pytest.warns(RuntimeWarning, match="lost positive definiteness"):
        reversed_result = evaluate(broken, X[::-1], threads=1)
    np.testing.assert_array_equal(reversed_result.trace, result.trace[::-1])


def test_empty_batch_gives_empty_results(paper):
    result = evaluate(paper, np.empty((0, 12)))
    assert result.t_end.shape == result.trace.shape == (0,)


def test_environment_variable_limits_number_of_threads(monkeypatch):
    monkeypatch.setattr("os.sched_getaffinity", lambda pid: set(range(8)), raising=False)
    for limit, threads in (("3", 3), ("16", 8), ("0", 1), ("", 8), ("many", 8)):
        monkeypatch.setenv("NUMBA_NUM_THREADS", limit)
        assert count_available_threads() == threads
    monkeypatch.delenv("NUMBA_NUM_THREADS")
    assert count_available_threads() == 8
