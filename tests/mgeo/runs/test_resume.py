import numpy as np
import pytest

from mgeo.runs.persistence import RunPersistence
from mgeo.runs.prepare import PreparedRun, prepare
from mgeo.runs.resume import resume_run

pytestmark = pytest.mark.usefixtures("stand_in")


def begun(folder, generations):
    """A run of 40 generations that was stopped, kept in a folder."""
    run = prepare("cantilever", parameters={"n_walkers": 4}, evaluations=320, seed=2)

    def stop(state):
        if state.evaluations >= 8 * generations:
            state.stop()

    run.solve(stop, RunPersistence(folder, run.configuration, run.algorithm))
    return run


@pytest.mark.parametrize("generations", [1, 17, 40])
def test_it_ends_as_the_run_would_have_ended(generations, tmp_path):
    expected = begun(tmp_path, generations).solve()
    resumed = resume_run(tmp_path)
    outcome = resumed.solve()
    assert np.array_equal(outcome.X, expected.X)
    assert np.array_equal(outcome.F, expected.F)
    assert outcome.hypervolume == expected.hypervolume
    assert (outcome.status, outcome.evaluations) == ("finished", 320)


def test_the_configuration_has_the_new_budget(tmp_path):
    begun(tmp_path, 3)
    longer = resume_run(tmp_path, generations=50)
    assert longer.configuration.evaluations == 400
    once, again = longer.solve(), PreparedRun.of(longer.configuration).solve()
    assert np.array_equal(once.F, again.F)
    shorter = resume_run(tmp_path, evaluations=100)
    assert shorter.solve().evaluations == 104  # the last generation is completed


def test_one_budget_at_a_time(tmp_path):
    begun(tmp_path, 1)
    with pytest.raises(ValueError, match="evaluations and generations are both given"):
        resume_run(tmp_path, evaluations=500, generations=50)


def test_a_run_killed_before_its_first_generation_begins_anew(tmp_path):
    run = prepare("cantilever", parameters={"n_walkers": 4}, evaluations=320, seed=2)

    class Killed(BaseException):
        pass

    class Impatient(RunPersistence):
        def begin(self, algorithm, notes):
            super().begin(algorithm, notes)
            raise Killed

    with pytest.raises(Killed):
        run.solve(persistence=Impatient(tmp_path, run.configuration, run.algorithm))
    assert resume_run(tmp_path, generations=40).configuration == run.configuration
    assert np.array_equal(resume_run(tmp_path).solve().F, run.solve().F)
