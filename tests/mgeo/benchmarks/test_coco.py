"""COCO functions as pymoo problems agree with COCO."""

import pickle
import subprocess
import sys

import numpy as np
import pytest

from mgeo.benchmarks.collections import expand_name, format_short_name
from mgeo.plugins.problems import load_problem

cocoex = pytest.importorskip("cocoex")

NAME = "coco:bbob-biobj/f12/d10/i3"


def points(n, n_var=10, seed=0):
    return np.random.default_rng(seed).uniform(-5, 5, (n, n_var))


@pytest.fixture(scope="module")
def suite():
    """Suite of COCO with all instances."""
    return cocoex.Suite("bbob-biobj", "", "")


@pytest.mark.parametrize(
    ("function", "dimension", "instance"), [(1, 2, 1), (12, 10, 3), (55, 20, 15)]
)
def test_values_bounds_and_name_agree_with_coco(suite, function, dimension, instance):
    reference = suite.get_problem_by_function_dimension_instance(function, dimension, instance)
    problem = load_problem(f"coco:bbob-biobj/f{function}/d{dimension}/i{instance}")
    X = points(20, dimension)
    assert np.array_equal(problem.evaluate(X), [reference(x) for x in X])
    assert (problem.n_var, problem.n_obj, problem.n_constr) == (dimension, 2, 0)
    assert np.array_equal(problem.xl, reference.lower_bounds)
    assert np.array_equal(problem.xu, reference.upper_bounds)
    assert problem.function_name == f"bbob-biobj f{function}"


def test_first_function_consists_of_two_spheres():
    # Both objectives of f1 are |x - x_opt|^2 + f_opt, with the second differences of |x|^2.
    problem = load_problem("coco:bbob-biobj/f1/d5/i2")
    x, step = points(1, 5)[0], 0.5 * np.eye(5)
    low, at, high = (problem.evaluate(X) for X in (x - step, x[None], x + step))
    assert low - 2 * at + high == pytest.approx(np.full((5, 2), 2 * 0.5**2), rel=1e-6)


def test_values_agree_in_another_process():
    problem, X = load_problem(NAME), points(50)
    expected = problem.evaluate(X)
    code = (
        "import pickle, sys, numpy as np\n"
        f"problem = pickle.loads({pickle.dumps(problem)!r})\n"
        "X = np.random.default_rng(0).uniform(-5, 5, (50, 10))\n"
        "sys.stdout.write(problem.evaluate(X).tobytes().hex())"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, check=True, text=True)
    assert done.stdout == expected.tobytes().hex()


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("bbob-biobj/f56/d10/i1", "has no function 56 in 10 dimensions, instance 1"),
        ("bbob-biobj/f1/d10/i16", "instance 16 of COCO's bbob-biobj: expected 1 to 15"),
        ("bbob-biobj/f1,2/d10/i1", "expected one function, one dimension and one instance"),
        ("bbob-biobj/f1/d10", "expected SUITE/fFUNCTION/dDIMENSION/iINSTANCE"),
        ("bbob-mixint/f1/d10/i1", "COCO's suite 'bbob-mixint': expected one of bbob, bbob-biobj"),
    ],
)
def test_invalid_names_are_rejected(name, message):
    with pytest.raises(ValueError, match=message):
        load_problem(f"coco:{name}")


def test_ranges_are_expanded():
    found = expand_name("coco:bbob-biobj/f1-3,7/d5,10/i2")
    assert len(found) == 8
    assert found[0] == "coco:bbob-biobj/f1/d5/i2"
    assert found[-1] == "coco:bbob-biobj/f7/d10/i2"
    assert expand_name("pymoo:zdt1") == ["pymoo:zdt1"]
    assert format_short_name(found[0]) == "bbob_biobj f1 d5 i2"
    with pytest.raises(ValueError, match="'3-1' is not a number or range"):
        expand_name("coco:bbob-biobj/f3-1/d5/i2")
