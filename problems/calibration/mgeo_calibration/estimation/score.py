"""Score tests of model errors that the estimator does not contain.

C. R. Rao, Large sample tests of statistical hypotheses concerning several parameters, Mathematical
Proceedings of the Cambridge Philosophical Society 44 (1948) 50-57. One pass of the filter estimates
the states of the model together with the coefficients of the model errors.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import TypeVar

import numpy as np
from mgeo_attitude._typing import Bools, Floats, Ints
from scipy.linalg import solve_triangular
from scipy.special import chdtrc

from mgeo_calibration.estimation.kernels import load_compiled_module
from mgeo_calibration.estimation.linearization import Equations
from mgeo_calibration.estimation.smoother import Solution, Span

K = TypeVar("K")
#: Indices of a coefficients, shape (a,), and their effects on n steps or readings, shape (n, 3, a).
Columns = tuple[Ints, Floats]
#: Chi-square above which the tail probability is computed by a series.
_SERIES_THRESHOLD = 500.0


@dataclass(frozen=True, eq=False, kw_only=True)
class ModelError:
    """Model error for score tests, described by the effects of its k coefficients on attitude and
    readings.

    A coefficient of one is a large error. A combination of coefficients with a 1-sigma above one is
    not tested.

    Attributes
    ----------
    n_coefficients : int
        Number k of coefficients.
    attitude_changes : function of Equations, optional
        Change of the attitude error in each step [rad], shape (n - 1, 3, k).
    reading_changes : mapping of int to function of Equations
        Change of the readings of a sensor, by sensor index, in the filter's units, shape (n, 3, k).
    last_bias_change : array, shape (3, k), optional
        Change of the gyro bias at the last sample in addition to its estimated error [rad/s].
    """

    n_coefficients: int
    attitude_changes: Callable[[Equations], Floats] | None = None
    reading_changes: Mapping[int, Callable[[Equations], Floats]] = field(default_factory=dict)
    last_bias_change: Floats | None = None


@dataclass(frozen=True, eq=False)
class ModelErrorCombination:
    """Model error formed by linear combinations of the coefficients of another model error.

    Attributes
    ----------
    model_error : ModelError
    combinations : array, shape (model_error.n_coefficients, k)
        Coefficients of the model error for each of the k combinations.
    """

    model_error: ModelError
    combinations: Floats

    @property
    def n_coefficients(self) -> int:
        """Number of coefficients, k."""
        return int(self.combinations.shape[1])


@dataclass(frozen=True, eq=False)
class Score:
    """Result of the score test of one model error.

    Attributes
    ----------
    estimate, sigma : arrays, shape (k,)
        Estimated coefficients and their 1-sigmas. Combinations that are not tested have an estimate
        of zero and an infinite 1-sigma.
    chi_square : float
        Test statistic; chi-square distributed if the model is correct.
    degrees_of_freedom : int
        Degrees of freedom; zero if no combination is tested.
    alternative, n_alternatives : int
        Index of the model error among the tested alternatives, and their number.
    """

    estimate: Floats
    sigma: Floats
    chi_square: float
    degrees_of_freedom: int
    alternative: int = 0
    n_alternatives: int = 1

    def compute_p_value(self, variance_ratio: float = 1.0) -> float:
        """Return the p-value of the test for a given ratio of actual to declared noise variance.

        Parameters
        ----------
        variance_ratio : float
            Ratio of the actual noise variance to the declared noise variance.
        """
        return float(np.exp(-0.5 * self.compute_evidence(variance_ratio)))

    def compute_evidence(self, variance_ratio: float = 1.0) -> float:
        """Return -2 ln p for the p-value of the test. Larger values are stronger evidence against
        the model.

        The result is finite even where p underflows. If the model is correct, -2 ln p is chi-square
        distributed with two degrees of freedom.

        Parameters
        ----------
        variance_ratio : float
            Ratio of the actual noise variance to the declared noise variance.
        """
        if not self.degrees_of_freedom:
            return 0.0
        tail = log_chi_square_tail(self.chi_square / variance_ratio, self.degrees_of_freedom)
        return max(0.0, -2.0 * (tail + math.log(self.n_alternatives)))


@dataclass(frozen=True, eq=False)
class ScoreTests:
    """Fisher information and log-likelihood gradient for score tests of several model errors.

    Attributes
    ----------
    information : array, shape (m, m)
        Fisher information of the coefficients.
    gradient : array, shape (m,)
        Gradient of the log-likelihood at coefficients of zero.
    state_changes : array, shape (n_states, m)
        Change of the estimates at the last sample per coefficient, stochastic states first.
    slices : mapping of str to slice
        Coefficients of each model error, by name.
    """

    information: Floats
    gradient: Floats
    state_changes: Floats
    slices: Mapping[str, slice]

    def compute_score(self, name: str, nuisance: Sequence[str] = ()) -> Score:
        """Run the score test for one model error. Other model errors can be estimated at the same
        time as nuisance parameters.

        Parameters
        ----------
        name : str
            Name of the model error.
        nuisance : sequence of str
            Names of other model errors to estimate at the same time.

        Returns
        -------
        Score
        """
        indices = np.arange(len(self.gradient))
        tested = indices[self.slices[name]]
        others = np.concatenate([indices[:0], *(indices[self.slices[each]] for each in nuisance)])
        information, score = self.information[np.ix_(tested, tested)], self.gradient[tested]
        if len(others):
            nuisance_covariance = _invert_information(self.information[np.ix_(others, others)])[0]
            projection = self.information[np.ix_(tested, others)] @ nuisance_covariance
            information = information - projection @ self.information[np.ix_(others, tested)]
            score = score - projection @ self.gradient[others]
        covariance, is_estimable, axes = _invert_information(information)
        sigma = np.sqrt(np.diag(covariance))
        sigma[(np.abs(axes[:, ~is_estimable]) > _MIN_COMPONENT).any(axis=1)] = np.inf
        return Score(
            estimate=covariance @ score,
            sigma=sigma,
            chi_square=float(score @ covariance @ score),
            degrees_of_freedom=int(is_estimable.sum()),
        )


#: Smallest component of a unit eigenvector that counts as a contribution of a coefficient.
_MIN_COMPONENT = 0.1


def compute_scores(
    solution: Solution, model_errors: Mapping[str, ModelError | ModelErrorCombination]
) -> ScoreTests:
    """Compute the Fisher information and the log-likelihood gradient for score tests of several
    model errors, in one filter pass.

    Parameters
    ----------
    solution : Solution
        Converged smoother solution.
    model_errors : mapping of str to ModelError or ModelErrorCombination
        Model errors by name.

    Returns
    -------
    ScoreTests
    """
    base_of_each = [
        each.model_error if isinstance(each, ModelErrorCombination) else each
        for each in model_errors.values()
    ]
    bases = dict.fromkeys(
        base_of_each
    )  # Model errors compare by identity; a dict keeps their order.
    base_slices = _assign_slices({base: base.n_coefficients for base in bases})
    slices = _assign_slices({name: each.n_coefficients for name, each in model_errors.items()})
    m = sum(base.n_coefficients for base in bases)
    columns = np.zeros((m, sum(each.n_coefficients for each in model_errors.values())))
    for base, (name, each) in zip(base_of_each, model_errors.items(), strict=True):
        combinations = (
            each.combinations
            if isinstance(each, ModelErrorCombination)
            else np.eye(base.n_coefficients)
        )
        columns[base_slices[base], slices[name]] = combinations
    r, J = solution.prior_equations
    q, d = len(r), solution.stochastic_errors.shape[1]
    R, gram, last = np.zeros((q, q + 1 + m)), np.zeros((m + 1, m + 1)), np.zeros((d, m))
    R[:, : q + 1] = np.linalg.qr(np.column_stack([J, r]))[1][:q]
    _run_filter(solution, base_slices, last, R, gram)
    slopes = -solve_triangular(R[:, :q], R[:, q + 1 :])
    stochastic_changes = last + solution.span_starts[-1][1] @ slopes
    state_changes = np.vstack(
        [stochastic_changes, solution.constant_factors[-1, : q - d, None] * slopes[d:]]
    )
    order = np.concatenate([solution.partition.stochastic, solution.partition.constant])
    for base, columns_of_base in base_slices.items():
        if base.last_bias_change is not None:
            state_changes[np.isin(order, [3, 4, 5]), columns_of_base] += base.last_bias_change
    return ScoreTests(
        information=columns.T @ gram[1:, 1:] @ columns,
        gradient=columns.T @ gram[1:, 0],
        state_changes=state_changes @ columns,
        slices=slices,
    )


def log_chi_square_tail(x: float, degrees_of_freedom: int) -> float:
    """Return the logarithm of the probability that a chi-square variable exceeds x.

    The result is finite even where the probability underflows. Large arguments use the asymptotic
    series of the incomplete gamma function (NIST Digital Library of Mathematical Functions,
    8.11.2).

    Parameters
    ----------
    x : float
        Chi-square.
    degrees_of_freedom : int
        Degrees of freedom.
    """
    if x < max(_SERIES_THRESHOLD, 10.0 * degrees_of_freedom):
        return math.log(chdtrc(degrees_of_freedom, x))
    a, y = 0.5 * degrees_of_freedom, 0.5 * x
    series = np.cumprod([1.0, *((a - k) / y for k in range(1, 10))]).sum()
    return float((a - 1.0) * math.log(y) - y - math.lgamma(a) + math.log(series))


def _assign_slices(widths: Mapping[K, int]) -> dict[K, slice]:
    ends = np.cumsum([0, *widths.values()]).tolist()
    return {key: slice(*pair) for key, pair in zip(widths, pairwise(ends), strict=True)}


def _run_filter(
    solution: Solution,
    slices: Mapping[ModelError, slice],
    last_sensitivities: Floats,
    R: Floats,
    gram: Floats,
) -> None:
    """Run the filter with the model error coefficients as additional unknowns.
    `last_sensitivities`, `R` and `gram` are updated in place.
    """
    for span in solution.iterate_spans():
        attitude_columns, reading_columns = _collect_effects(span, slices)
        s, n, b = (
            len(reading_columns),
            span.high - span.low,
            max(len(indices) for indices, _ in reading_columns),
        )
        reading_changes, coefficients = np.zeros((s, n, 3, b)), np.zeros((s, b), dtype=np.int64)
        for index, (indices, columns) in enumerate(reading_columns):
            reading_changes[index, :, :, : len(indices)] = columns
            coefficients[index, : len(indices)] = indices
        load_compiled_module("sensitivities").compute_sensitivities(
            span.process.F,
            attitude_columns[1],
            attitude_columns[0],
            span.is_used,
            span.measurements.arrays[1:],
            reading_changes,
            np.array([len(indices) for indices, _ in reading_columns]),
            coefficients,
            span.readings,
            span.first_new,
            last_sensitivities,
            R,
            gram,
        )
    gram += np.triu(gram, 1).T


def _collect_effects(
    span: Span, slices: Mapping[ModelError, slice]
) -> tuple[Columns, list[Columns]]:
    """Return the effects of the model error coefficients on the attitude and on each sensor's
    readings, with the coefficient indices.
    """
    n, measurements = span.high - span.low, span.measurements
    attitude_columns, reading_columns = (
        [_build_empty_columns(n - 1)],
        [[_build_empty_columns(n)] for _ in measurements.has_reading],
    )
    for model_error, columns in slices.items():
        indices = np.arange(columns.start, columns.stop)
        if model_error.attitude_changes is not None:
            attitude_columns.append((indices, model_error.attitude_changes(span)))
        for index, compute_changes in model_error.reading_changes.items():
            if measurements.has_reading[index].any():
                reading_columns[index].append((indices, compute_changes(span)))
    return _drop_zero_columns(attitude_columns), [
        _drop_zero_columns(each) for each in reading_columns
    ]


def _drop_zero_columns(effects: Sequence[Columns]) -> Columns:
    indices, columns = (np.concatenate(of, axis=-1) for of in zip(*effects, strict=True))
    is_nonzero = columns.any(axis=(0, 1))
    return indices[is_nonzero], np.compress(is_nonzero, columns, axis=2)


def _build_empty_columns(n: int) -> Columns:
    return np.zeros(0, dtype=np.int64), np.zeros((n, 3, 0))


def _invert_information(information: Floats) -> tuple[Floats, Bools, Floats]:
    """Return the pseudo-inverse of an information matrix in the subspace of eigenvalues above one.

    Returns
    -------
    covariance : array, shape (m, m)
        Pseudo-inverse in the subspace of these eigenvectors.
    is_estimable : array of bool, shape (m,)
        True for eigenvectors with a 1-sigma below one.
    axes : array, shape (m, m)
        All eigenvectors.
    """
    values, axes = np.linalg.eigh(information)
    is_estimable: Bools = values > 1.0
    covariance: Floats = (axes[:, is_estimable] / values[is_estimable]) @ axes[:, is_estimable].T
    return covariance, is_estimable, axes
