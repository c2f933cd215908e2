"""Runs on problems with variables of several kinds."""

import numpy as np
import pytest
from pymoo.core.problem import Problem
from pymoo.core.variable import Integer

from mgeo.algorithms.variables import designs_of
from mgeo.runs.algorithms import build_algorithm
from mgeo.runs.limits import limits
from mgeo.runs.solve import solve

from ..algorithms.test_mixed import Rod as Strict


class Rod(Strict):
    """Without its checks of types: pymoo's operators give NumPy's numbers."""

    def _evaluate(self, X, out, *args, **kwargs):
        plain = {key: value.item() if hasattr(value, "item") else value for key, value in X.items()}
        super()._evaluate({**plain, "coated": bool(plain["coated"])}, out, *args, **kwargs)


class Free(Problem):
    """Without constraints."""

    def __init__(self):
        super().__init__(vars={"n": Integer(bounds=(0, 9))}, n_obj=2)


@pytest.mark.parametrize(
    "name",
    [
        "mgeo-directed",
        "mgeo-canonical",
        "nsga2",
        "nsga3",
        "u-nsga3",
        "spea2",
        "sms-emoa",
        "age-moea2",
    ],
)
def test_a_front_in_numbers_is_that_of_the_designs(name):
    problem = Rod()
    size = {} if name.startswith("mgeo") else {"population": 20}
    outcome = solve(problem, build_algorithm(name, size, problem), 300, seed=1)
    assert outcome.X.shape == (len(outcome.F), 5)
    designs = designs_of(problem, outcome.X)
    assert {type(design["material"]) for design in designs} == {str}
    F, G = problem.evaluate(designs, return_values_of=["F", "G"])
    assert np.array_equal(F, outcome.F)
    told = [limit.margin for each in limits(problem, outcome.X) for limit in each]
    assert told == (-G[:, 0]).tolist()


@pytest.mark.parametrize("name", ["random", "gde3", "moead", "cmopso"])
def test_what_takes_arrays_alone_is_refused(name):
    with pytest.raises(ValueError, match=f"algorithm '{name}' .*one of mgeo-real, .*, nsga2, "):
        build_algorithm(name, {"population": 20}, Free())
