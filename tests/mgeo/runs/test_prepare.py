import json

import pytest

from mgeo.runs.algorithms import complete_parameters
from mgeo.runs.prepare import prepare_run
from mgeo.runs.registry import DEFAULT_ALGORITHM

pytestmark = pytest.mark.usefixtures("stand_in")


def test_configuration_contains_all_settings():
    configuration = prepare_run(
        "cantilever", {"preset": "heavy"}, parameters={"n_walkers": 5}
    ).configuration
    assert configuration.model_dump() == {
        "problem": "cantilever",
        "options": {"load": 2000.0},  # The load of the preset.
        "algorithm": DEFAULT_ALGORITHM,
        "parameters": json.loads(
            json.dumps(complete_parameters(DEFAULT_ALGORITHM, {"n_walkers": 5}))
        ),
        "evaluations": 1000 * 5 * 2,
        "seed": 1,
        "initial_designs": 0,
        "refine": False,
    }


@pytest.mark.parametrize("value", [{1, 2}, float("nan")])
def test_options_that_are_not_json_are_rejected_before_the_run(value, monkeypatch):
    monkeypatch.setattr("stand_in.Cantilever.to_options", lambda self: {"load": value})
    with pytest.raises(ValueError, match="options of 'cantilever' are not JSON values"):
        prepare_run("cantilever")
