"""Mixed variables: steps of integers, binary variables and choices, and whole fronts."""

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pymoo.core.mixed import MixedVariableSampling
from pymoo.core.problem import ElementwiseProblem, Problem
from pymoo.core.variable import Binary, Choice, Integer, Real
from pymoo.indicators.hv import HV
from pymoo.optimize import minimize

from mgeo import MGEOCanonical, MGEODirected
from mgeo.algorithms import Variables
from mgeo.algorithms.steps import round_steps
from mgeo.algorithms.variables import KINDS

from .. import naive

MATERIALS = {"steel": (7.8, 210.0), "titanium": (4.5, 110.0), "carbon": (1.6, 150.0)}
PRICE = {"steel": 1.0, "titanium": 6.0, "carbon": 9.0}


class Rod(ElementwiseProblem):
    """Cost and elongation of a bundle of rods, with variables of each kind; real ones optional."""

    def __init__(self, real=True):
        kinds = {
            "coated": Binary(),
            "rods": Integer(bounds=(1, 6)),
            "material": Choice(options=list(MATERIALS)),
            "grade": Choice(options=[3, 1, 2, 7]),
        }
        if real:
            kinds["area"] = Real(bounds=(0.5, 2.0))
        super().__init__(vars=kinds, n_obj=2, n_ieq_constr=1)

    def _evaluate(self, X, out, *args, **kwargs):
        assert type(X["rods"]) is int
        assert type(X["coated"]) is bool
        assert type(X["material"]) is str
        density, modulus = MATERIALS[X["material"]]
        area = X.get("area", 1.0) * X["rods"]
        misfit = (X["grade"] - 2 * X["rods"] / 3) ** 2
        cost = area * density * PRICE[X["material"]] + misfit + 0.5 * X["coated"]
        out["F"] = [cost, 100.0 / (modulus * area) * (2 - X["coated"]) + 0.01 * misfit]
        out["G"] = [area - 9.0]


def exhaustive(problem, areas=(None,)):
    """Return the front of all designs with the given areas."""
    rows = []
    for coated, rods, material, grade, area in itertools.product(
        (False, True), range(1, 7), MATERIALS, (3, 1, 2, 7), areas
    ):
        x = {"coated": coated, "rods": rods, "material": material, "grade": grade}
        rows.append(x if area is None else {**x, "area": float(area)})
    F, G = problem.evaluate(np.array(rows, dtype=object), return_values_of=["F", "G"])
    F = F[G[:, 0] <= 0]
    return F[naive.archive_rows(F.tolist(), [0.0] * len(F))]


@pytest.mark.cases(2)
@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.parametrize(
    "algorithm",
    [MGEODirected(), MGEODirected(momentum=(0.5, 0.5)), MGEOCanonical(1.0, 5)],
    ids=repr,
)
def test_whole_front_of_discrete_variables_is_found(algorithm, seed):
    problem = Rod(real=False)
    result = minimize(problem, algorithm, ("n_eval", 3000), seed=seed)
    found, expected = (F[np.lexsort(F.T)] for F in (result.F, exhaustive(problem)))
    assert np.array_equal(found, expected)
    assert np.array_equal(problem.evaluate(result.X, return_values_of=["F"]), result.F)


@pytest.fixture(scope="module")
def grid_front():
    """Front of all designs on a grid of areas."""
    return exhaustive(Rod(), np.linspace(0.5, 2.0, 31))


@pytest.mark.cases(0)
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_front_of_mixed_variables_matches_grid_search(grid_front, seed):
    problem = Rod()
    ideal, nadir = grid_front.min(axis=0), grid_front.max(axis=0)
    volume = HV(ref_point=np.array([1.1, 1.1]))
    result = minimize(problem, MGEODirected(), ("n_eval", 6000), seed=seed)
    share = volume((result.F - ideal) / (nadir - ideal)) / volume(
        (grid_front - ideal) / (nadir - ideal)
    )
    assert share > 0.999
    assert (result.G <= 0).all()


def test_declared_real_variables_give_identical_front():
    class Plain(Problem):
        def __init__(self, **sizes):
            super().__init__(n_obj=2, **sizes)

        def _evaluate(self, X, out, *args, **kwargs):
            X = np.array([[x["a"], x["b"]] for x in X]) if X.dtype == object else X
            out["F"] = np.column_stack([(X**2).sum(axis=1), ((X - 1) ** 2).sum(axis=1)])

    declared = {name: Real(bounds=(-3.0, 5.0)) for name in "ab"}
    a, b = (
        minimize(problem, MGEODirected(), ("n_eval", 2000), seed=4)
        for problem in (Plain(vars=declared), Plain(n_var=2, xl=-3.0, xu=5.0))
    )
    assert a.F.tobytes() == b.F.tobytes()


def test_initial_points_take_all_levels_equally_often():
    run = MGEODirected(n_walkers=6000).setup(Rod(), seed=2)
    for column, levels in zip(run.walkers.T, (2, 6, 3, 4), strict=False):
        counts = np.unique(column, return_counts=True)[1]
        assert len(counts) == levels
        assert counts == pytest.approx(6000 / levels, rel=0.1)


@st.composite
def steps(draw):
    """Strategy for the arguments of `round_steps` with 6 variables."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    xl = rng.integers(-3, 3, 6).astype(float)
    xu = xl + rng.integers(0, 5, 6)
    x, end_points, donor = (xl + (xu - xl) * rng.random((4, 5, 6)) for _ in range(3))
    donor = np.where(rng.random((4, 5, 1)) < 0.5, np.rint(donor), np.nan)
    primary, choice = rng.integers(0, 6, (4, 5)), rng.random(6) < 0.5
    return np.rint(x[:, :1]), end_points, primary, donor, choice, xl, xu, rng.random((4, 5, 6))


@given(steps())
def test_rounded_steps_are_valid_and_change_primary_variable(arguments):
    x, end_points, primary, donor, choice, xl, xu, _ = arguments
    end = round_steps(*arguments)
    assert np.array_equal(end, np.rint(end))
    assert ((end >= xl) & (end <= xu)).all()
    changed = end != x
    primary_changed = np.take_along_axis(changed, primary[..., None], axis=2)[..., 0]
    assert np.array_equal(primary_changed, (xu > xl)[primary])
    others = np.arange(6) != primary[..., None]
    assert not changed[others & (np.rint(end_points) == x)].any()
    ordered = others & ~choice
    assert np.array_equal(end[ordered], np.rint(end_points)[ordered])
    copied = others & choice & ~np.isnan(donor) & (np.rint(end_points) != x)
    assert np.array_equal(end[copied], donor[copied])


def test_choice_without_donor_takes_all_other_options_equally_often():
    n, rng = 30_000, np.random.default_rng(1)
    x, end_points = np.full((n, 1), 2.0), np.full((n, 1), 3.0)
    bounds = np.array([0.0]), np.array([4.0])
    none, primary = np.full((n, 1), np.nan), np.zeros(n, dtype=int)
    end = round_steps(x, end_points, primary, none, np.array([True]), *bounds, rng.random((n, 1)))
    found, counts = np.unique(end, return_counts=True)
    assert found.tolist() == [0, 1, 3, 4]
    assert counts == pytest.approx(n / 4, rel=0.05)


def test_conversion_of_designs_to_numbers_is_invertible():
    variables = Variables.from_problem(Rod(), KINDS)
    designs = MixedVariableSampling().do(Rod(), 50, random_state=np.random.default_rng(1)).get("X")
    assert variables.to_designs(variables.to_numbers(designs)).tolist() == designs.tolist()
    assert variables.is_choice.tolist() == [False, False, True, True, False]
    assert variables.xu.tolist() == [1, 6, 2, 3, 2]
