"""Convergence curves against filterpy's run of the same design."""

import numpy as np
import pytest
from mgeo_attitude import reference_run
from mgeo_attitude.view.figures.against_time import convergence_figure, sample_steps, trace_curves
from mgeo_attitude.view.figures.style import Solutions

DEG = 180.0 / np.pi
FACTORS = [DEG, DEG * 3600.0, DEG, DEG * 60.0, DEG, 50e3]


@pytest.fixture(scope="module")
def solutions(problem, X):
    return Solutions.of(problem.view(X[:2]))


def test_curves_are_the_reference_filters(problem, solutions):
    for x, (times, values) in zip(solutions.X, trace_curves(problem, solutions), strict=True):
        history = reference_run(problem.model, x)
        steps = times.astype(int)
        np.testing.assert_array_equal(times, history.times[steps])
        assert times[-1] == history.t_end
        np.testing.assert_allclose(values[0], history.trace[steps], rtol=1e-9)
        worst = history.sigma[steps].reshape(-1, 6, 3).max(axis=2)
        np.testing.assert_allclose(values[1:].T, worst * FACTORS, rtol=1e-9)


def test_panels(problem, solutions):
    figure = convergence_figure(problem, solutions)
    titles = [annotation.text for annotation in figure.layout.annotations]
    assert titles == [
        "trace [-]",
        "attitude, 1-sigma [deg]",
        "gyro bias, 1-sigma [deg/h]",
        "sun misalignment, 1-sigma [deg]",
        "sun bias, 1-sigma [arcmin]",
        "mag misalignment, 1-sigma [deg]",
        "mag bias, 1-sigma [nT]",
    ]
    assert len(figure.data) == 14
    lines = trace_curves(problem, solutions)
    for index, trace in enumerate(figure.data):
        panel, solution = divmod(index, 2)
        np.testing.assert_array_equal(trace.x, lines[solution][0])
        np.testing.assert_array_equal(trace.y, lines[solution][1][panel])
        assert trace.name == solutions.labels[solution]
        assert trace.showlegend == (panel == 0)
    assert {axis.type for axis in figure.select_yaxes() if axis.anchor != "x8"} == {"log"}


@pytest.mark.parametrize("last", [1, 2, 300, 11984])
def test_samples_keep_both_ends(last):
    steps = sample_steps(last)
    assert steps[0] == 0
    assert steps[-1] == last
    assert (np.diff(steps) > 0).all()
    assert np.diff(steps).max() <= last / 299 + 1
    assert set(range(min(last, 10) + 1)) <= set(steps.tolist())
