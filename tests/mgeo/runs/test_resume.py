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


SMALL_PARAMETERS = {"n_walkers": 4, "fidelity_schedule": [0.5, 1.0]}


def at_fidelity(self, fidelity):
    """Return a problem with inaccurate values at the first two fidelity levels."""
    if fidelity >= 2:
        return self
    inaccurate = copy.copy(self)
    inaccurate._evaluate = partial(evaluate_inaccurately, inaccurate)
    return inaccurate


def evaluate_inaccurately(self, X, out, *args, **kwargs):
    type(self)._evaluate(self, X, out)
    out["F"] = out["F"] / 4.0


def test_history_of_staged_run_omits_low_fidelity_values(tmp_path, monkeypatch):
    problem = load_problem("cantilever")
    monkeypatch.setattr(type(problem), "at_fidelity", at_fidelity, raising=False)
    staged = {
        "algorithm": "mgeo-staged",
        "parameters": SMALL_PARAMETERS,
        "evaluations": 320,
        "seed": 2,
    }
    run = prepare_run("cantilever", **staged, record=True)
    outcome = run.solve(folder=tmp_path)
    record = read_record(tmp_path / "evaluations")
    assert len(record) == outcome.n_evaluations > 320  # The final evaluation is included.
    evaluations, volumes = compute_hypervolume_history(run.problem, outcome, record)
    assert outcome.n_low_fidelity == evaluations[0] - 1 >= 320
    assert volumes[-1] == pytest.approx(outcome.hypervolume)
    # The resumed run continues before the final evaluation.
    resumed = resume_run(tmp_path, check=False)
    assert np.array_equal(resumed.solve(folder=tmp_path).F, outcome.F)
    pd.testing.assert_frame_equal(read_record(tmp_path / "evaluations"), record)
