"""Figures of a plan against its tables."""

import numpy as np
from mgeo_attitude.plan.figures import build_plan_figures


def test_figures_show_numbers_of_tables(plan):
    figures = build_plan_figures(plan)
    assert list(figures) == ["rates", "uncertainty_by_phase", "error_budget", "correlation"]
    rates = figures["rates"].data[0]
    np.testing.assert_array_equal(rates.x, [0.0, 100.0, plan.t_end])
    np.testing.assert_allclose(rates.y, [0.5, 0.3, 0.3])
    heat = figures["correlation"].data[0]
    np.testing.assert_array_equal(heat.z, plan.compute_correlations())
    assert heat.x[0] == heat.y[0] == "attitude x"
    lines = {line.name: line for line in figures["uncertainty_by_phase"].data}
    assert list(lines)[-1] == "mag bias"
    table = plan.compute_uncertainty_by_phase()
    worst = table[[f"mag bias {axis} [nT]" for axis in "xyz"]].max(axis=1)
    np.testing.assert_allclose(lines["mag bias"].customdata, worst)
    np.testing.assert_allclose(lines["mag bias"].y, worst / 2000.0)
    assert len(lines["mag bias"].x) == len(set(lines["mag bias"].x)) == len(table)
    shares = np.array([bar.x for bar in figures["error_budget"].data], dtype=float)
    np.testing.assert_allclose(shares.sum(axis=0), 100.0)
    assert [bar.name for bar in figures["error_budget"].data] == list(
        plan.compute_error_budget().index[:-1]
    )
    np.testing.assert_array_equal(
        figures["error_budget"].data[0].customdata, plan.compute_error_budget().iloc[0]
    )
