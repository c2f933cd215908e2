"""A calibration costs a fraction of one pass of the filter that takes a sample after the other."""

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
from .measure import interleaved


@pytest.mark.benchmark
@pytest.mark.parametrize("preset", ["paper", "cubesat_6u"])
def test_a_calibration_costs_less_than_filtering_step_by_step(preset):
    scenario = short(getattr(Scenario, preset)(), 3000.0)
    model = FilterModel.from_scenario(scenario)
    motion = Motion.from_design(model, PLAN, model.n_steps)
    flight = simulate_run(
        model, motion, draw_errors(model, model.n_steps, np.random.default_rng(1))
    )
    telemetry = build_telemetry(model, flight)

    def filtered():
        start = Estimate.from_model(model, 1)
        one = ErrorStateFilter(model.suite, FilterSettings())
        for _ in one.run(start, [flight.readings], motion.rates, model.references):
            pass

    timings = interleaved(
        {"calibrated": lambda: calibrate(scenario, telemetry), "filtered": filtered}, rounds=5
    )
    ratio = timings["calibrated"].processor / timings["filtered"].processor
    print(f"\n{preset}: a calibration takes {ratio:.3f} of a pass of the filter")
    assert ratio < 0.25
