"""Starts and polish as a run in a folder has them."""

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
LOADED = {"inertia": [0.1, 0.1, 0.1], "max_momentum": 0.01, "gravity_gradient": True}
SIZE = {"evaluations": 240, "parameters": {"n_walkers": 4}}


class Killed(BaseException):
    pass


@pytest.mark.slow
def test_a_run_that_is_killed_amid_its_polish_ends_as_one_that_was_not(tmp_path):
    run = prepare_run("attitude", SHORT, initial_designs=2, refine=True, **SIZE)

    def kill(state):
        if state.refinement is not None:
            raise Killed

    try:
        run.solve(kill, tmp_path)
    except Killed:
        outcome = resume_run(tmp_path).solve()
    expected = prepare_run("attitude", SHORT, initial_designs=2, refine=True, **SIZE).solve()
    np.testing.assert_array_equal(outcome.X, expected.X)
    np.testing.assert_array_equal(outcome.F, expected.F)
    search = prepare_run("attitude", SHORT, initial_designs=2, **SIZE).solve()
    assert expected.n_refined > 0
    assert expected.hypervolume > search.hypervolume


CUBESAT = {"preset": "cubesat_6u", "duration": 1200.0, "step": 10.0}
TEN, THREE = {"maneuvers": {"count": 10}}, {"maneuvers": {"count": 3}}


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        (CUBESAT | TEN, (12, True, 6_000)),
        (CUBESAT | THREE | {"convergence": TRACE}, (0, False, 59_904)),
        ({"preset": "paper"}, (0, False, 59_904)),
        ({"preset": "paper"} | TEN, (0, False, 199_680)),
        (CUBESAT | THREE | {"wheels": LOADED}, (12, False, 59_904)),
        (CUBESAT | TEN | {"monte_carlo": {"n_runs": 8}}, (0, False, 199_680)),
        (CUBESAT | TEN | {"objectives": ["t_end", "angle"]}, (12, False, 199_680)),
    ],
)
def test_a_run_without_options_does_what_the_problem_recommends(given, expected):
    found = prepare_run("attitude", given, initial_designs=None, refine=None).configuration
    assert (found.initial_designs, found.refine, found.evaluations) == expected
