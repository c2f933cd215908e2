"""Simple designs, and their comparison against single runs of the reference filter."""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude import Scenario, run_reference_filter
from mgeo_attitude.view.observability.improvements import build_baselines, compare_designs


def test_baselines_are_simple_designs():
    baselines = build_baselines(Scenario.paper(), 600.0, rate_deg_s=0.5)
    assert baselines == {
        "no maneuver": (0.0, 0.0, 0.0, 600.0),
        "x only": (0.5, 0.0, 0.0, 600.0),
        "y only": (0.0, 0.5, 0.0, 600.0),
        "z only": (0.0, 0.0, 0.5, 600.0),
        "x, y, z sequence": (0.5, 0, 0, 200.0, 0, 0.5, 0, 200.0, 0, 0, 0.5, 200.0),
        "x, y, z sequence, both directions": (
            *(0.5, 0, 0, 100.0, -0.5, 0, 0, 100.0),
            *(0, 0.5, 0, 100.0, 0, -0.5, 0, 100.0),
            *(0, 0, 0.5, 100.0, 0, 0, -0.5, 100.0),
        ),
    }
    # The default rate is the maximum rate of the scenario.
    assert build_baselines(Scenario.paper(), 600.0)["x only"][0] == 1.0


@pytest.mark.slow
def test_comparison_equals_single_runs_at_the_common_time(problem, design, history):
    baselines = build_baselines(problem.scenario, 351.0)
    table = compare_designs(problem, {"plan": design, **baselines}, history.t_end)
    assert list(table.index) == ["plan", *baselines]
    assert table.loc["plan", "t_end [s]"] == history.t_end
    assert table.loc["plan", "trace [-]"] == pytest.approx(history.trace[-1], rel=1e-9)
    assert table.loc["plan", "trace / first trace [-]"] == 1.0
    nonconverging_model = dataclasses.replace(problem.model, relative_decrease=-np.inf)
    name = "x, y, z sequence"
    history_at_time = run_reference_filter(nonconverging_model, baselines[name])
    step = round(history.t_end)
    assert table.loc[name, "trace [-]"] == pytest.approx(history_at_time.trace[step], rel=1e-9)
    assert table.loc[name, "mag bias 1-sigma [nT]"] == pytest.approx(
        50e3 * history_at_time.sigma[step, 15:].max(), rel=1e-9
    )
    converged = run_reference_filter(problem.model, baselines[name])
    assert table.loc[name, "t_end [s]"] == converged.t_end
    assert table.loc[name, "trace at t_end [-]"] == pytest.approx(converged.trace[-1], rel=1e-9)
    # Without rotation, misalignments and biases are not observable.
    assert table.loc["no maneuver", "trace / first trace [-]"] > 10.0
