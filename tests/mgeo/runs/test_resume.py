import copy
from functools import partial

import numpy as np
import pandas as pd
import pytest

from mgeo import read_record
from mgeo.plugins.problems import load_problem
from mgeo.report.history import compute_hypervolume_history
from mgeo.runs.prepare import prepare_run, resume_run

pytestmark = pytest.mark.usefixtures("stand_in")


SMALL = {"n_walkers": 4, "fidelity_schedule": [0.5, 1.0]}


def at_fidelity(self, fidelity):
    """Estimates in the first two stages."""
    if fidelity >= 2:
        return self
    rough = copy.copy(self)
    rough._evaluate = partial(estimate, rough)
    return rough


def estimate(self, X, out, *args, **kwargs):
    type(self)._evaluate(self, X, out)
    out["F"] = out["F"] / 4.0


def test_the_history_of_a_staged_run_is_without_estimates(tmp_path, monkeypatch):
    problem = load_problem("cantilever")
    monkeypatch.setattr(type(problem), "at_fidelity", at_fidelity, raising=False)
    staged = {"algorithm": "mgeo-staged", "parameters": SMALL, "evaluations": 320, "seed": 2}
    run = prepare_run("cantilever", **staged, record=True)
    outcome = run.solve(folder=tmp_path)
    record = read_record(tmp_path / "evaluations")
    assert len(record) == outcome.n_evaluations > 320  # with the last judgment
    evaluations, volumes = compute_hypervolume_history(run.problem, outcome, record)
    assert outcome.n_low_fidelity == evaluations[0] - 1 >= 320
    assert volumes[-1] == pytest.approx(outcome.hypervolume)
    # and again, where the run goes on from before the judgment
    again = resume_run(tmp_path, check=False)
    assert np.array_equal(again.solve(folder=tmp_path).F, outcome.F)
    pd.testing.assert_frame_equal(read_record(tmp_path / "evaluations"), record)
