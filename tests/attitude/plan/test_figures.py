"""Figures of a plan against its tables."""

import numpy as np
from mgeo_attitude.plan.figures import build_plan_figures
from mgeo_attitude.plan_sections import SECTION_KEYS


def test_figures_show_numbers_of_tables(plan):
    figures = build_plan_figures(plan)
    assert set(figures) <= set(SECTION_KEYS)
    rates = figures["timeline"].data[0]
    np.testing.assert_array_equal(rates.x, [0.0, 100.0, plan.t_end])
    np.testing.assert_allclose(rates.y, [0.5, 0.3, 0.3])
    heat = figures["axes"].data[0]
    np.testing.assert_array_equal(heat.z, plan.compute_correlations())
    assert heat.x[0] == heat.y[0] == "attitude x"
    lines = {line.name: line for line in figures["accuracy"].data}
    assert list(lines)[-1] == "mag bias"
    table = plan.compute_uncertainty_by_phase()
    worst = table[[f"mag bias {axis} [nT]" for axis in "xyz"]].max(axis=1)
    np.testing.assert_allclose(lines["mag bias"].customdata, worst)
    np.testing.assert_allclose(lines["mag bias"].y, worst / 2000.0)
    assert len(lines["mag bias"].x) == len(set(lines["mag bias"].x)) == len(table)
    shares = np.array([bar.x for bar in figures["drivers"].data], dtype=float)
    np.testing.assert_allclose(shares.sum(axis=0), 100.0)
    assert [bar.name for bar in figures["drivers"].data] == list(
        plan.compute_error_budget().index[:-1]
    )
    np.testing.assert_array_equal(
        figures["drivers"].data[0].customdata, plan.compute_error_budget().iloc[0]
    )
