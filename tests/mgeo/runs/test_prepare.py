import json

import numpy as np
import pytest

from mgeo.runs.algorithms import complete_parameters
from mgeo.runs.prepare import PreparedRun, prepare
from mgeo.runs.registry import DEFAULT
from mgeo.store.run import RunConfiguration
from mgeo.validation.tables import checked

pytestmark = pytest.mark.usefixtures("stand_in")


def test_a_configuration_states_everything():
    configuration = prepare(
        "cantilever", {"preset": "heavy"}, parameters={"n_walkers": 5}
    ).configuration
    assert configuration.model_dump() == {
        "problem": "cantilever",
        "options": {"load": 2000.0},  # what the preset meant
        "algorithm": DEFAULT,
        "parameters": json.loads(json.dumps(complete_parameters(DEFAULT, {"n_walkers": 5}))),
        "evaluations": 1000 * 5 * 2,
        "seed": 1,
        "starts": 0,
        "polish": False,
    }


def test_the_same_configuration_gives_the_same_front_after_a_trip_through_json():
    prepared = prepare(
        "cantilever",
        {"load": 1234.5},
        algorithm="mgeo-real",
        parameters={"sigma": (0.003, 0.1), "n_walkers": 3},
        evaluations=300,
        seed=7,
    )
    configuration = checked(
        RunConfiguration, json.loads(json.dumps(prepared.configuration.model_dump()))
    )
    assert configuration == prepared.configuration
    once, again, rebuilt = prepared.solve(), prepared.solve(), PreparedRun.of(configuration).solve()
    assert np.array_equal(once.X, again.X)
    assert np.array_equal(once.X, rebuilt.X)
    assert np.array_equal(once.F, rebuilt.F)


@pytest.mark.parametrize("value", [{1, 2}, float("nan")])
def test_options_that_cannot_be_written_are_refused_before_the_run(value, monkeypatch):
    monkeypatch.setattr("stand_in.Cantilever.options", lambda self: {"load": value})
    with pytest.raises(ValueError, match="options of 'cantilever' are not JSON values"):
        prepare("cantilever")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"seed": True}, "seed = True: expected a valid integer"),
        ({"evaluations": "10"}, "evaluations = '10': expected a valid integer"),
        ({"sed": 1}, "sed is unknown"),
    ],
)
def test_a_damaged_configuration_is_refused(change, message):
    data = prepare("cantilever").configuration.model_dump()
    with pytest.raises((ValueError, TypeError), match=message):
        checked(RunConfiguration, data | change)
