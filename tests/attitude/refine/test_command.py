"""Initial designs and local refinement of runs, and recommended settings."""

import numpy as np
import pytest

from mgeo.runs.prepare import prepare_run, resume_run

from ...three import TRACE

SHORT = {
    "preset": "paper",
    "duration": 600.0,
    "step": 2.0,
    "maneuvers": {"count": 3},
    "convergence": {"rule": "end"},
}
WHEELS = {"inertia": [0.1, 0.1, 0.1], "max_momentum": 0.01, "gravity_gradient": True}
SHORT_RUN = {"evaluations": 240, "parameters": {"n_walkers": 4}}


class SimulatedKill(BaseException):
    pass


@pytest.mark.slow
def test_killed_refinement_resumes_to_equal_result(tmp_path):
    run = prepare_run("attitude", SHORT, initial_designs=2, refine=True, **SHORT_RUN)

    def kill_during_refinement(state):
        if state.refinement is not None:
            raise SimulatedKill

    try:
        run.solve(kill_during_refinement, tmp_path)
    except SimulatedKill:
        outcome = resume_run(tmp_path).solve()
    expected = prepare_run("attitude", SHORT, initial_designs=2, refine=True, **SHORT_RUN).solve()
    np.testing.assert_array_equal(outcome.X, expected.X)
    np.testing.assert_array_equal(outcome.F, expected.F)
    search = prepare_run("attitude", SHORT, initial_designs=2, **SHORT_RUN).solve()
    assert expected.n_refined > 0
    assert expected.hypervolume > search.hypervolume


CUBESAT = {"preset": "cubesat_6u", "duration": 1200.0, "step": 10.0}
TEN, THREE = {"maneuvers": {"count": 10}}, {"maneuvers": {"count": 3}}


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        (CUBESAT | TEN, (12, True, 6_000)),
        (CUBESAT | THREE | {"convergence": TRACE}, (0, False, 59_904)),
        ({"preset": "paper"}, (0, False, 59_904)),
        ({"preset": "paper"} | TEN, (0, False, 199_680)),
        (CUBESAT | THREE | {"wheels": WHEELS}, (12, False, 59_904)),
        (CUBESAT | TEN | {"monte_carlo": {"n_runs": 8}}, (0, False, 199_680)),
        (CUBESAT | TEN | {"objectives": ["t_end", "angle"]}, (12, False, 199_680)),
    ],
)
def test_run_without_options_follows_recommendations(options, expected):
    configuration = prepare_run(
        "attitude", options, initial_designs=None, refine=None
    ).configuration
    assert (
        configuration.initial_designs,
        configuration.refine,
        configuration.evaluations,
    ) == expected
