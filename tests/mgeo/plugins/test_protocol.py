"""Optional parts of a problem: what is called, and the defaults."""

import numpy as np
import pytest
from pymoo.core.problem import Problem

from mgeo import ProblemMixin
from mgeo.plugins import protocol
from mgeo.plugins.discovery import PluginError
from mgeo.plugins.protocol import get_column_names


def problem(**attributes):
    made = Problem(n_var=2, n_obj=2, xl=0, xu=1)
    for name, value in attributes.items():
        setattr(made, name, value)
    return made


class Plain(ProblemMixin, Problem):
    def __init__(self):
        super().__init__(n_var=2, n_obj=2, xl=0, xu=1)


@pytest.mark.parametrize("made", [problem(), Plain()])
def test_a_problem_without_optional_parts_has_the_defaults(made):
    assert get_column_names(made) == (("x1", "x2"), ("f1", "f2"))
    assert protocol.get_options(made) is None
    assert protocol.get_indicator_map(made) is None
    assert protocol.get_recommended_settings(made) == (0, False, None)
    assert protocol.get_function_name(made) == ""
    with pytest.raises(ValueError, match=r"has no to_robust\(\): expected a run without it"):
        protocol.get_robust_problem(made)
    with pytest.raises(PluginError, match=r"has no refine\(\): expected a run without --refine"):
        next(protocol.iterate_refinement(made, np.zeros((1, 2))))
    assert not protocol.has_override(made, ProblemMixin.suggest_initial_designs)


def test_a_part_that_raises_is_named():
    def steps(X):
        yield X
        raise KeyError("spring")

    def summary(F):
        raise ZeroDivisionError

    broken = problem(refine=steps, map_to_indicator_space=summary)
    tables = protocol.iterate_refinement(broken, np.zeros((1, 2)))
    assert next(tables).shape == (1, 2)
    with pytest.raises(PluginError, match=r"^refine of problem Problem raised KeyError: 'spring'"):
        next(tables)
    with pytest.raises(
        PluginError, match=r"^map_to_indicator_space of problem Problem raised ZeroDiv"
    ):
        protocol.get_indicator_map(broken)(np.zeros((1, 2)))
