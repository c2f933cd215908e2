"""Baselines as designs, and the comparison against single runs of the reference filter."""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude import Scenario, run_reference_filter
from mgeo_attitude.view.observability.improvements import build_baselines, compare_designs


def test_designs_by_hand():
    found = build_baselines(Scenario.paper(), 600.0, rate_deg_s=0.5)
    assert found == {
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
    assert (
        build_baselines(Scenario.paper(), 600.0)["x only"][0] == 1.0
    )  # the scenario's greatest rate


@pytest.mark.slow
def test_comparison_is_that_of_single_runs_at_the_same_time(problem, design, history):
    others = build_baselines(problem.scenario, 351.0)
    table = compare_designs(problem, {"plan": design, **others}, history.t_end)
    assert list(table.index) == ["plan", *others]
    assert table.loc["plan", "t_end [s]"] == history.t_end
    assert table.loc["plan", "trace [-]"] == pytest.approx(history.trace[-1], rel=1e-9)
    assert table.loc["plan", "trace / first trace [-]"] == 1.0
    endless = dataclasses.replace(problem.model, relative_decrease=-np.inf)
    name = "x, y, z sequence"
    alone = run_reference_filter(endless, others[name])
    step = round(history.t_end)
    assert table.loc[name, "trace [-]"] == pytest.approx(alone.trace[step], rel=1e-9)
    assert table.loc[name, "mag bias 1-sigma [nT]"] == pytest.approx(
        50e3 * alone.sigma[step, 15:].max(), rel=1e-9
    )
    own = run_reference_filter(problem.model, others[name])
    assert table.loc[name, "t_end [s]"] == own.t_end
    assert table.loc[name, "trace at t_end [-]"] == pytest.approx(own.trace[-1], rel=1e-9)
    # without turning, misalignments and biases stay what they were
    assert table.loc["no maneuver", "trace / first trace [-]"] > 10.0
