"""Optional methods of a problem: calls and defaults."""

import numpy as np
import pytest
from pymoo.core.problem import Problem

from mgeo import ProblemMixin
from mgeo.plugins import protocol
from mgeo.plugins.discovery import PluginError
from mgeo.plugins.protocol import get_column_names


def build_problem(**attributes):
    problem = Problem(n_var=2, n_obj=2, xl=0, xu=1)
    for name, value in attributes.items():
        setattr(problem, name, value)
    return problem


class Plain(ProblemMixin, Problem):
    def __init__(self):
        super().__init__(n_var=2, n_obj=2, xl=0, xu=1)


@pytest.mark.parametrize("problem", [build_problem(), Plain()])
def test_problem_without_optional_methods_has_defaults(problem):
    assert get_column_names(problem) == (("x1", "x2"), ("f1", "f2"))
    assert protocol.get_options(problem) is None
    assert protocol.get_indicator_map(problem) is None
    assert protocol.get_recommended_settings(problem) == (0, False, None)
    assert protocol.get_function_name(problem) == ""
    with pytest.raises(ValueError, match=r"has no to_robust\(\): solve it without --robust"):
        protocol.get_robust_problem(problem)
    with pytest.raises(PluginError, match=r"has no refine\(\): solve it without --refine"):
        next(protocol.iterate_refinement(problem, np.zeros((1, 2))))
    assert not protocol.has_override(problem, ProblemMixin.suggest_initial_designs)


def test_error_of_optional_method_states_its_name():
    def steps(X):
        yield X
        raise KeyError("spring")

    def summary(F):
        raise ZeroDivisionError

    broken = build_problem(refine=steps, map_to_indicator_space=summary)
    tables = protocol.iterate_refinement(broken, np.zeros((1, 2)))
    assert next(tables).shape == (1, 2)
    with pytest.raises(PluginError, match=r"^refine of problem Problem raised KeyError: 'spring'"):
        next(tables)
    with pytest.raises(
        PluginError, match=r"^map_to_indicator_space of problem Problem raised ZeroDiv"
    ):
        protocol.get_indicator_map(broken)(np.zeros((1, 2)))
