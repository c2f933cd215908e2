"""What is wrong is named, with its size; 60 faults at the edge of mattering."""

import dataclasses
import pickle
import re
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import numpy as np
import ppigrf
import pytest
from mgeo_attitude.sensors import StarTracker, TwoAxisSunSensor
from mgeo_calibration import CannotCalibrate, TelemetryMapping, calibrate
from mgeo_calibration import fly as fly_plan
from mgeo_calibration.calibration.questions import questions
from mgeo_calibration.calibration.refused import causes
from mgeo_calibration.estimation.batch import batch
from mgeo_calibration.estimation.belief import Belief
from mgeo_calibration.estimation.departures import PARTS
from mgeo_calibration.estimation.fit import fit
from mgeo_calibration.estimation.score import scores
from mgeo_calibration.telemetry.mapping import GyroChannels

from .faults import FAULTS, GROSS, MOTION, SCENARIO, SCORED, Fault, says
from .flights import PLAN, options, short
from .independent import Craft, coning, fly, tumble


def first_line(fault, seed):
    return calibrate(SCENARIO, fault.fly(seed)).conclusion.partition(": ")[2]


@pytest.mark.parametrize("late", [-0.2, 0.2])
def test_a_delay_that_passed_is_told_with_its_size(late):
    """It was supported, with the Sun sensor's misalignment 6 sigma off."""
    found = calibrate(SCENARIO, fly(SCENARIO, MOTION, 5, Craft(late={"mag": late})))
    assert not found.supported
    side = "late" if late > 0.0 else "early"
    said = re.match(
        rf"mag is ([0-9.]+) ± ([0-9.]+) s {side} \(.*: mag\.initial_delay_s$", found.failures[0]
    )
    size, sigma = map(float, said.groups())
    assert sigma < 0.03
    assert abs(size - abs(late)) < 3.0 * sigma


@pytest.mark.cases(0, 2)
@pytest.mark.parametrize("kind", ["magnetometer's scale", "orbit", "step of the Sun sensor"])
def test_what_is_wrong_is_the_first_line(kind):
    assert re.match(SCORED[kind].cause, first_line(SCORED[kind], 11))


def test_rates_at_the_samples_that_are_read_as_means_are_told():
    """Magnetometer and Sun sensor were blamed, late by half a step; the key that is named mends."""
    scenario = short(SCENARIO, 600.0)
    telemetry = fly(scenario, coning(1.0, 0.1), 3, Craft(instantaneous=True), duration=600.0)
    found = calibrate(scenario, telemetry)
    said = re.match(
        r"gyro reports rates ([0-9.]+) ± ([0-9.]+) s early \(.*: rate = \"instantaneous\" under",
        found.failures[0],
    )
    size, sigma = map(float, said.groups())
    assert sigma < 0.1
    assert abs(size - 0.5) < 3.0 * sigma
    mapping = TelemetryMapping(gyro=GyroChannels(rate="instantaneous"))
    assert calibrate(scenario, telemetry.frame(), mapping).supported


def test_rates_at_the_samples_that_a_spin_hardly_tells_from_means_are_a_note():
    """Half a step is a turn about the spin: misalignments were off by 14 sigma, without a word."""
    scenario = short(SCENARIO, 600.0)
    spin = tumble((0.185, 0.144, 0.061), (0.28, 0.0, 1.45), 600.0)
    for instantaneous in (True, False):
        craft = Craft(instantaneous=instantaneous)
        found = calibrate(scenario, fly(scenario, spin, 1, craft, duration=600.0))
        assert found.supported
        told = [note for note in found.notes if note.startswith("gyro may report the rates at its")]
        assert len(told) == instantaneous
        if told:
            assert "misalignment would be" in told[0]


def test_all_is_asked_in_spans_as_at_once(monkeypatch):
    scenario = short(SCENARIO, 600.0)
    telemetry = fly(scenario, MOTION, 1, Craft(late={"sun": 0.3}), duration=600.0)
    solution = fit(batch(scenario, telemetry), Belief.of(scenario), 1e-5).solution
    asked = options(questions(solution, {}))
    whole = scores(solution, asked)
    monkeypatch.setattr("mgeo_calibration.estimation.trajectory.SPAN", 97)
    parts = scores(solution, asked)
    # mean squares, since what hardly matters is what rounding leaves
    scale = np.sqrt(np.diag(whole.information)) + 1e-6
    np.testing.assert_allclose(
        parts.information / np.outer(scale, scale),
        whole.information / np.outer(scale, scale),
        rtol=0.0,
        atol=1e-9,
    )
    np.testing.assert_allclose(parts.score / scale, whole.score / scale, rtol=0.0, atol=1e-7)
    np.testing.assert_allclose(parts.change, whole.change, rtol=0.0, atol=1e-8)


@pytest.mark.cases(0)
@pytest.mark.parametrize("of", ["mag", "gyro"])
def test_a_step_is_told_with_its_time_and_size(of):
    """Its time is not known beforehand; waves of a drift are far from it."""
    telemetry = fly(SCENARIO, MOTION, 8)
    step = 1.0 * (telemetry.times > 1400.0)[:, None] * np.array([0.0, 1.0, 0.0])
    if of == "mag":
        field = telemetry.sensors["mag"] + 300.0 * step
        spoiled = dataclasses.replace(telemetry, sensors=telemetry.sensors | {"mag": field})
    else:
        spoiled = dataclasses.replace(telemetry, gyro_deg_s=telemetry.gyro_deg_s + 0.01 * step)
    found = calibrate(SCENARIO, spoiled)
    said = re.match(
        rf"{of}\.bias changes by ([0-9.]+) (nT|deg/s) at about (\d+) s", found.failures[0]
    )
    assert float(said[1]) == pytest.approx(300.0 if of == "mag" else 0.01, rel=0.25)
    assert float(said[3]) == pytest.approx(1400.0, abs=3000.0 / PARTS)


@pytest.mark.slow
def test_what_can_hardly_be_told_apart_is_told_as_both():
    """A drift that goes as a temperature does, but for what no reading shows."""
    telemetry = fly(SCENARIO, MOTION, 9)
    share = telemetry.times / 3000.0
    frame = telemetry.frame()
    frame["temperature"] = 20.0 + 5.0 * share + 0.05 * np.sin(0.05 * telemetry.times)
    frame["mag_x"] += 200.0 * share
    (first, *_) = found = calibrate(SCENARIO, frame).failures
    assert len(found) == 1
    drift, follows = r"mag\.bias changes by [^;]*, evenly", r"mag\.bias follows temperature by "
    assert says(drift, first)
    assert says(follows, first)
    assert not says(r"sun\.", first)


def test_noise_that_is_set_too_high_is_a_note():
    """It ended "not supported", exit 3, with nothing wrong but modest 1-sigmas."""
    sun, mag = SCENARIO.sensors
    careful = dataclasses.replace(
        SCENARIO, sensors=(dataclasses.replace(sun, noise_deg=1.4 * sun.noise_deg), mag)
    )
    found = calibrate(careful, fly(SCENARIO, MOTION, 1))
    assert found.supported
    (note,) = (note for note in found.notes if note.startswith("sun"))
    said = re.match(r"sun: sigmas are too large by 1\.[34]\d?; measured ([0-9.]+) deg", note)
    assert float(said[1]) == pytest.approx(sun.noise_deg, rel=0.03)


@pytest.mark.slow
def test_sensors_of_two_angles_and_trackers_are_asked():
    """Of a tracker the misalignment may change, of two angles nothing along the direction."""
    mag = SCENARIO.sensors[1]
    scenario = short(SCENARIO, 600.0, sensors=(TwoAxisSunSensor(), StarTracker(), mag))
    telemetry = fly_plan(scenario, PLAN, 1)
    found = calibrate(scenario, telemetry)
    assert found.supported, found.conclusion
    table = found.model_table()
    assert {"sun.delay", "sun.drift", "tracker.delay", "tracker.drift"} <= set(table.index)
    assert table.loc["tracker.drift", "says"].startswith("tracker.misalignment changes by ")
    shifted = {**telemetry.sensors, "tracker": np.roll(telemetry.sensors["tracker"], 1, axis=0)}
    shifted["tracker"][0] = np.nan
    late = calibrate(scenario, dataclasses.replace(telemetry, sensors=shifted))
    assert re.match(r"tracker is (0\.9\d|1\.0\d) ± 0\.0\d s late", late.failures[0])


@pytest.mark.cases(0, 1)
@pytest.mark.parametrize(
    "kind",
    ["magnetometer frozen", "fill values", "Sun sensor flipped", "Excel", "local time", "ITRF"],
)
def test_a_cause_is_seen_without_any_attitude(kind):
    assert re.match(GROSS[kind].cause, seen(GROSS[kind], 7)[0])


def test_local_time_is_seen_by_few_calls_of_the_field_s_model(monkeypatch):
    """Each begins with as much work as a thousand places; it was called for every time and place.

    Places are those of UTC, as a receiver of GPS has them.
    """
    healthy = Fault("").fly(7)
    place, _ = SCENARIO.orbit.propagate(SCENARIO.epoch, healthy.times)
    calls, field = [], ppigrf.igrf_gc
    monkeypatch.setattr(ppigrf, "igrf_gc", lambda *asked: calls.append(asked) or field(*asked))
    late = dataclasses.replace(healthy, times=healthy.times + 5400.0)
    for telemetry in (late, dataclasses.replace(late, position=place)):
        calls.clear()
        assert causes(SCENARIO, telemetry, None) == ("times are 1.5 h ahead of UTC: local time?",)
        assert len(calls) < 12


def test_no_cause_is_seen_of_a_healthy_flight():
    for seed in (1, 2):
        assert seen(Fault(""), seed) == ()


@pytest.mark.slow
def test_the_cause_stands_in_front_of_what_was_refused():
    """It was "are orbit, epoch and mounting frames those of the satellite?" alone."""
    with pytest.raises(ValueError, match=r"^times are in minutes, not seconds \(the estimate does"):
        first_line(GROSS["minutes"], 1)


@pytest.mark.campaign
@pytest.mark.slow  # a process that imports all
def test_what_is_refused_in_another_process_is_told_in_this_one():
    """It ended as a broken pool, or as a TypeError without the cause."""
    with ProcessPoolExecutor(1, get_context("spawn")) as pool:
        refused = pool.submit(calibrate, SCENARIO, GROSS["minutes"].fly(1)).exception()
    assert isinstance(refused, CannotCalibrate)
    assert refused.causes[0].startswith("times are in minutes")
    assert refused.check_table().loc["times", "says"] == refused.causes[0]


def seen(fault, seed):
    telemetry = fault.fly(seed)
    return causes(SCENARIO, telemetry, batch(SCENARIO, telemetry))


@pytest.mark.slow
def test_a_bias_that_follows_a_channel_of_the_table_is_told():
    """A magnetometer's bias of 12 nT per degree, beside channels of which nothing follows."""
    telemetry = fly(SCENARIO, MOTION, 6)
    rng, t = np.random.default_rng(6), telemetry.times
    frame = telemetry.frame()
    frame["temperature"] = 20.0 + 8.0 * np.sin(2.0 * np.pi * t / 1700.0 + 1.0)
    for k in range(6):
        frame[f"current_{k}"] = np.cumsum(rng.standard_normal(len(t)))
    frame["mode"] = "nominal"
    assert calibrate(SCENARIO, frame).supported
    frame["mag_y"] += 12.0 * frame["temperature"]
    found = calibrate(SCENARIO, frame)
    said = re.match(
        r"mag\.bias follows temperature by ([0-9.]+) ± ([0-9.]+) nT along y", found.failures[0]
    )
    size, sigma = map(float, said.groups())
    assert abs(size - 12.0) < 4.0 * sigma + 0.5
    assert sigma < 1.0


def test_a_delay_is_told_before_what_it_moves():
    """With noise that is larger by what it leaves its chi-square is less than that of the prior."""
    scenario = short(SCENARIO, 600.0)
    rates = coning(1.5, 0.3)
    found = calibrate(scenario, fly(scenario, rates, 3, Craft(late={"mag": 0.7}), duration=600.0))
    late = found.model_table().loc["mag.delay", "chi_square"]
    assert max(test.chi_square for test in found.prior_tests if test.fails) > late
    assert re.match(r"mag is 0\.\d+ ± 0\.\d+ s late", found.failures[0])


@pytest.mark.slow
def test_what_makes_outliers_of_all_that_follows_is_told():
    """Beyond a large step all readings are outliers: those that were left said nothing is wrong."""
    telemetry = fly(SCENARIO, MOTION, 4)
    step = 0.3 * (telemetry.times > 1800.0)[:, None] * np.array([0.0, 0.0, 1.0])
    sun = telemetry.sensors["sun"] + step
    found = calibrate(
        SCENARIO, dataclasses.replace(telemetry, sensors=telemetry.sensors | {"sun": sun})
    )
    assert re.match(r"sun\.bias changes by 0\.\d+ -", found.failures[0])
    assert any("of sun are outliers" in words for words in found.failures)


@pytest.mark.cases(0, 0)
@pytest.mark.parametrize("third", range(3))
def test_nine_of_ten_faults_are_named(third):
    """One of each kind; see `faults.FAULTS`."""
    kinds = list(FAULTS.items())[third::3]
    named = {kind: named_right(fault, 21) for kind, fault in kinds}
    assert np.mean(list(named.values())) >= 0.9, named


def named_right(fault: Fault, seed: int) -> bool:
    try:
        line = first_line(fault, seed)
    except ValueError as error:
        line = str(error)
    return says(fault.cause, line)


def test_what_no_estimate_follows_from_has_tables():
    """Of a satellite far behind, with noise that is larger."""
    scenario = short(SCENARIO, 900.0)
    telemetry = fly(scenario, MOTION, 1, Craft(behind=45.0), duration=900.0)
    asked = batch(scenario, telemetry), Belief.of(scenario), 1e-5
    refused = CannotCalibrate.of("it does not settle", {"times": ()}, *asked)
    assert str(refused).startswith("the satellite is 4")
    assert str(refused).endswith("(it does not settle)")
    assert refused.check_table().loc["times", "says"] == "nothing"
    assert refused.model_table().loc["orbit.along_track", "named"]
    assert refused.noise_factor > 1.0
    again = pickle.loads(pickle.dumps(refused))
    assert (str(again), again.causes) == (str(refused), refused.causes)
    assert (again.noise_factor, again.model_tests) == (refused.noise_factor, refused.model_tests)
    assert again.check_table().equals(refused.check_table())
    seen = CannotCalibrate.of("it does not settle", {"times": ("in days",)}, *asked)
    assert (str(seen), seen.model_tests) == ("in days (it does not settle)", ())
