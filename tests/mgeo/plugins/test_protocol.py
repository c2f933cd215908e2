import pytest
from pymoo.core.problem import Problem

from mgeo.plugins import protocol
from mgeo.plugins.protocol import column_names


def problem(**attributes):
    made = Problem(n_var=2, n_obj=2, xl=0, xu=1)
    for name, value in attributes.items():
        setattr(made, name, value)
    return made


def test_names_come_from_the_problem_or_are_numbered():
    assert column_names(problem()) == (("x1", "x2"), ("f1", "f2"))
    named = problem(var_names=["a [m]", "b"], obj_names=["c", "d"])
    assert column_names(named) == (("a [m]", "b"), ("c", "d"))


@pytest.mark.parametrize("names", [["a"], ["a", "a"], ["a", "b", "c"]])
def test_wrong_names_are_refused(names):
    with pytest.raises(ValueError, match=r"var_names of Problem = \['a'.*expected 2 different"):
        column_names(problem(var_names=names))


def test_a_name_for_a_variable_and_an_objective_is_refused():
    with pytest.raises(ValueError, match="'a' names both"):
        column_names(problem(var_names=["a", "b"], obj_names=["c", "a"]))


def test_a_problem_may_be_an_instance_of_a_function():
    assert protocol.instance_of(problem()) == ""
    assert protocol.instance_of(problem(instance_of="f12")) == "f12"
    with pytest.raises(ValueError, match="instance_of of problem Problem = 12: expected a text"):
        protocol.instance_of(problem(instance_of=12))


def test_a_robust_problem_can_be_built_again():
    other = problem(options=dict)
    assert protocol.robust(problem(robust=lambda: other)) is other
    with pytest.raises(ValueError, match=r"^Problem has no robust\(\): expected"):
        protocol.robust(problem())
    with pytest.raises(
        ValueError, match=r"robust\(\) of problem Problem gives 3: expected a pymoo"
    ):
        protocol.robust(problem(robust=lambda: 3))
    with pytest.raises(ValueError, match=r"robust\(\) of problem Problem has no options\(\)"):
        protocol.robust(problem(robust=problem))
