"""Rate timelines against the attitude that the reference filter flies."""

import numpy as np
import pytest
from mgeo_attitude import reference_run
from mgeo_attitude.view.figures.against_time import timeline
from scipy.spatial.transform import Rotation


def design(*durations):
    x = np.array([0.5, -1.0, 0.25, 0.0, -0.125, 0.75, 1.0, 0.0, 0.0625, -0.5, 0.875, 0.0])
    x[3::4] = durations
    return x


@pytest.mark.parametrize(
    "durations",
    [(400.0, 350.5, 123.4), (0.0, 300.0, 200.0), (0.25, 0.25, 0.25), (100.0, 0.0, 0.0), (0, 0, 0)],
)
def test_timeline_flown_step_by_step_gives_the_reference_attitude(problem, durations):
    x = design(*durations)
    history = reference_run(problem.model, x)
    times, rates, over = timeline(problem, x, history.t_end)
    assert times[0] == 0.0
    assert times[-1] == history.t_end
    assert (np.diff(times) > 0.0).all()
    assert over == np.ceil(sum(durations))
    attitude = np.eye(3)
    for rate, span in zip(rates, np.diff(times), strict=False):
        attitude = Rotation.from_rotvec(-np.radians(rate) * span).as_matrix() @ attitude
    np.testing.assert_allclose(attitude, history.attitude[-1], atol=1e-11)


def test_timeline_stops_with_the_run(problem):
    """Maneuvers that the run does not reach are not shown."""
    times, rates, over = timeline(problem, design(100.0, 200.0, 50.0), 250.0)
    np.testing.assert_array_equal(times, [0.0, 100.0, 250.0])
    np.testing.assert_allclose(rates, [[0.5, -1.0, 0.25], [-0.125, 0.75, 1.0], [-0.125, 0.75, 1.0]])
    assert over == 250.0
