"""Bit encoding of real, integer and binary variables."""

import numpy as np
import pytest
from pymoo.core.problem import ElementwiseProblem, Problem
from pymoo.core.variable import Binary, Choice, Integer, Real
from pymoo.optimize import minimize

from mgeo import MGEOCanonical, MGEOReal, MGEOVar
from mgeo.algorithms import BitEncoding, Variables

from .. import naive

KINDS = ("real", "integer", "binary")


def code_of(kinds, xl, xu, bits, gray=False):
    variables = Variables(tuple(kinds), np.array(xl, dtype=float), np.array(xu, dtype=float))
    return BitEncoding.from_variables(variables, bits, gray)


def all_strings(length):
    return (np.arange(2**length)[:, None] >> np.arange(length)[::-1] & 1).astype(float)


@pytest.mark.parametrize("gray", [False, True])
def test_real_variable_has_evenly_spaced_values_from_bound_to_bound(gray):
    code = code_of(["real"], [-3.0], [7.0], 5, gray)
    values = code.decode(all_strings(5))[:, 0]
    assert np.sort(values) == pytest.approx(np.linspace(-3, 7, 32), rel=1e-15)
    assert (values.min(), values.max()) == (-3.0, 7.0)
    assert np.array_equal(code.encode(values[:, None]), all_strings(5))


def test_gray_codes_of_neighbors_differ_in_one_bit():
    code = code_of(["real"], [0.0], [1.0], 6, gray=True)
    strings = code.encode(np.linspace(0, 1, 64)[:, None])
    assert (np.abs(np.diff(strings, axis=0)).sum(axis=1) == 1).all()


@pytest.mark.parametrize("levels", [1, 2, 3, 5, 8, 11, 100])
@pytest.mark.parametrize("gray", [False, True])
def test_levels_of_integer_are_equally_frequent(levels, gray):
    code = code_of(["integer", "real"], [-4, 0], [-4 + levels - 1, 1], 1, gray)
    assert code.bits.tolist() == [int(np.ceil(np.log2(levels))), 1]
    values, counts = np.unique(code.decode(all_strings(code.length))[:, 0], return_counts=True)
    assert values.tolist() == list(range(-4, -4 + levels))
    assert counts.max() - counts.min() <= 2  # The bit of the real variable doubles all counts.
    points = np.column_stack([values, np.zeros(levels)])
    assert np.array_equal(code.decode(code.encode(points)), points)


@pytest.mark.parametrize("gray", [False, True])
def test_variables_of_several_kinds_and_lengths_are_encoded_together(gray):
    code = code_of(KINDS, [-1, 2, 0], [1, 8, 1], [9, 1, 1], gray)
    assert code.bits.tolist() == [9, 3, 1]
    strings = np.random.default_rng(0).integers(0, 2, (4, 50, 13)).astype(float)
    values = code.decode(strings)
    assert values.shape == (4, 50, 3)
    assert np.array_equal(code.decode(code.encode(values)), values)
    assert np.isin(values[..., 1], range(2, 9)).all()
    assert np.isin(values[..., 2], (0, 1)).all()
    assert np.array_equal(values[..., 2], strings[..., 12])


def test_variable_with_equal_bounds_is_constant():
    code = code_of(["real", "integer"], [2.5, 3], [2.5, 3], 4)
    assert np.array_equal(code.decode(all_strings(4)), np.tile([2.5, 3.0], (16, 1)))
    assert np.array_equal(code.encode(np.array([[2.5, 3.0]])), np.zeros((1, 4)))


# ---- problems of integer and binary variables -------------------------------------------------


class Knapsack(Problem):
    """Biobjective knapsack problem with a weight constraint and 2^10 designs."""

    def __init__(self):
        super().__init__(n_var=10, n_obj=2, n_ieq_constr=1, xl=0, xu=1, vtype=bool)
        self.value = np.random.default_rng(4).integers(1, 30, (3, 10))

    def _evaluate(self, X, out, *args, **kwargs):
        assert X.dtype == bool
        total = X @ self.value.T
        out["F"] = -1.0 * total[:, :2]
        out["G"] = total[:, 2:] - self.value[2].sum() / 2


@pytest.mark.slow
def test_whole_front_of_binary_variables_is_found():
    problem = Knapsack()
    X = all_strings(10).astype(bool)
    F, G = problem.evaluate(X)
    front = F[naive.archive_rows(F.tolist(), np.maximum(G[:, 0], 0).tolist())]
    result = minimize(problem, MGEOCanonical(1.0, 10), ("n_eval", 20_000), seed=1)
    assert np.array_equal(result.F, front)
    assert result.X.dtype == bool


class Grid(Problem):
    def __init__(self):
        super().__init__(n_var=3, n_obj=2, xl=[-7, 0, 3], xu=[12, 5, 9], vtype=int)

    def _evaluate(self, X, out, *args, **kwargs):
        assert np.issubdtype(X.dtype, np.integer)
        out["F"] = np.column_stack([((X - 4) ** 2).sum(axis=1), np.abs(X + 3).sum(axis=1)])


@pytest.mark.parametrize("variant", [MGEOCanonical, MGEOVar])
@pytest.mark.parametrize("coding", ["plain", "gray"])
def test_whole_front_of_integer_variables_is_found(variant, coding):
    problem = Grid()
    axes = [np.arange(low, high + 1) for low, high in zip(problem.xl, problem.xu, strict=True)]
    F = problem.evaluate(np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 3).astype(int))
    result = minimize(problem, variant(0.5, 10, coding=coding), ("n_eval", 10_000), seed=1)
    assert np.array_equal(result.F, F[naive.archive_rows(F.tolist(), [0.0] * len(F))])
    assert np.array_equal(problem.evaluate(result.X), result.F)


class Mixed(ElementwiseProblem):
    """Problem with a binary, an integer and a real variable, whose designs are dicts."""

    def __init__(self):
        kinds = {
            "on": Binary(),
            "count": Integer(bounds=(-2, 9)),
            "length": Real(bounds=(-1.0, 3.0)),
        }
        super().__init__(vars=kinds, n_obj=2)

    def _evaluate(self, X, out, *args, **kwargs):
        assert (type(X["on"]), type(X["count"]), type(X["length"])) == (bool, int, float)
        near = (X["count"] - 4) ** 2 + (X["length"] - 1) ** 2
        out["F"] = [near + X["on"], (X["length"] + 1) ** 2 + 3 * (not X["on"])]


def test_whole_front_of_mixed_variables_is_found():
    problem = Mixed()
    X = [
        {"on": on, "count": count, "length": float(length)}
        for on in (False, True)
        for count in range(-2, 10)
        for length in np.linspace(-1, 3, 64)
    ]
    F = problem.evaluate(np.array(X, dtype=object))
    result = minimize(problem, MGEOCanonical(0.5, 5, 6), ("n_eval", 5000), seed=1)
    assert pytest.approx(F[naive.archive_rows(F.tolist(), [0.0] * len(F))], abs=1e-14) == result.F
    assert all(set(x) == {"on", "count", "length"} for x in result.X)


@pytest.mark.parametrize(
    ("arguments", "variant", "message"),
    [
        (
            {"vars": {"c": Choice(options=["a", "a"])}},
            MGEOCanonical,
            r"vars\['c'\].*options = .*no duplicates",
        ),
        ({"vars": {"b": Binary()}}, MGEOReal, r"vars\['b'\] = .*Binary'>: expected real"),
        ({"vars": {"r": Real()}}, MGEOCanonical, r"xl\['r'\] = nan: expected a finite number"),
        ({"n_var": 2, "xl": 0, "xu": 1, "vtype": str}, MGEOCanonical, "vtype = <class 'str'>"),
        ({"n_var": 2, "xl": 0.5, "xu": 4, "vtype": int}, MGEOCanonical, "a finite integer"),
        ({"n_var": 2, "xl": 3, "xu": 3, "vtype": int}, MGEOCanonical, "all variables are fixed"),
        ({"n_var": 3, "xl": 0, "xu": 1}, lambda: MGEOVar(bits=[4, 4]), "bits of length 2"),
        ({"n_var": 3, "xl": 0, "xu": 1}, lambda: MGEOVar(bits=[4, 1, 4]), "variable 1 has 1 bit"),
        ({"vars": {"i": Integer(bounds=(0, 2**52))}}, MGEOVar, r"levels: expected at most 2\^52"),
        ({"vars": {"i": Integer(bounds=(2**53, 2**53 + 9))}}, MGEOCanonical, r"xl\['i'\] = 9.0"),
    ],
)
def test_problems_without_encoding_are_rejected(arguments, variant, message):
    with pytest.raises(ValueError, match=message):
        variant().setup(Problem(n_obj=2, **arguments))
