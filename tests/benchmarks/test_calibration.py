"""Time of a calibration, compared with a run of the error-state filter over its telemetry."""

import numpy as np
import pytest
from mgeo_attitude import FilterModel, Scenario
from mgeo_attitude.maneuvers.motion import Motion
from mgeo_calibration import FilterSettings, calibrate
from mgeo_calibration.estimation.innovation import Estimate
from mgeo_calibration.simulation.filter import ErrorStateFilter
from mgeo_calibration.simulators.kinematic import build_telemetry
from mgeo_calibration.simulators.simulated_run import draw_errors, simulate_run

from ..calibration.calibration.runs import PLAN, short
from .measure import time_interleaved


@pytest.mark.benchmark
@pytest.mark.parametrize("preset", ["paper", "cubesat_6u"])
def test_calibration_takes_less_time_than_filter_run(preset):
    scenario = short(getattr(Scenario, preset)(), 3000.0)
    model = FilterModel.from_scenario(scenario)
    motion = Motion.from_design(model, PLAN, model.n_steps)
    flight = simulate_run(
        model, motion, draw_errors(model, model.n_steps, np.random.default_rng(1))
    )
    telemetry = build_telemetry(model, flight)

    def run_filter():
        start = Estimate.from_model(model, 1)
        error_state_filter = ErrorStateFilter(model.suite, FilterSettings())
        for _ in error_state_filter.run(start, [flight.readings], motion.rates, model.references):
            pass

    timings = time_interleaved(
        {"calibrated": lambda: calibrate(scenario, telemetry), "filtered": run_filter}, rounds=5
    )
    ratio = timings["calibrated"].processor / timings["filtered"].processor
    print(f"\n{preset}: a calibration takes {ratio:.3f} of a pass of the filter")
    assert ratio < 0.25
