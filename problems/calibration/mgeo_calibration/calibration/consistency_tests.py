"""Statistical tests of a calibration: innovations of each sensor, and distance of the estimate from
the prior.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
import pandas as pd
from mgeo_attitude._typing import Floats
from scipy.special import chdtrc, gammaincinv, ndtri

from mgeo_calibration.calibration.corrections import find_innovation_unit
from mgeo_calibration.estimation.fit import Fit
from mgeo_calibration.estimation.linearization import compute_innovations
from mgeo_calibration.estimation.prior import PriorEstimate
from mgeo_calibration.estimation.residuals import FilterEstimates, Innovations
from mgeo_calibration.estimation.smoother import Solution
from mgeo_calibration.estimation.trajectory import Trajectory

#: Probability that at least one test of a healthy calibration fails.
SIGNIFICANCE = 0.01
#: Lags, in readings of a sensor, at which innovations are tested for correlation.
N_LAGS = 5
#: Largest fraction of a sensor's readings that may be outliers.
MAX_OUTLIER_FRACTION = 0.05
#: Ratio of the rms of a varying error to its declared 1-sigma below which the declared 1-sigma is
#: reported as too large.
_MIN_RMS_RATIO = 0.5
#: Block name of the test of all states together.
ALL_STATES = "all parameters"


@dataclass(frozen=True)
class Failure:
    """Failed test of a calibration, with its evidence, likely cause and remedy.

    ``str(failure)`` is one line of text.

    Attributes
    ----------
    test : str
        Name of the test.
    cause : str
        Most likely cause.
    evidence : str
        Test statistic and its expected value; empty for checks of the telemetry.
    action : str
        What the user should do; empty if the cause includes it.
    alternatives : str
        Other causes that cannot be distinguished from this one, with their actions.
    """

    test: str
    cause: str
    evidence: str = ""
    action: str = ""
    alternatives: str = ""

    def __str__(self) -> str:
        return f"{self.summary}; {self.alternatives}" if self.alternatives else self.summary

    @property
    def summary(self) -> str:
        """Cause, evidence and action in one line of text."""
        evidence = f" ({self.evidence})" if self.evidence else ""
        action = f": {self.action}" if self.action else ""
        return f"{self.cause}{evidence}{action}"

    def list_alternatives(self) -> list[str]:
        """Return the alternative causes, one line of text each."""
        return [text.removeprefix("or ") for text in self.alternatives.split("; ") if text]


@dataclass(frozen=True, kw_only=True)
class SensorTest:
    """Results of the innovation tests of one sensor: NIS, whiteness and outliers.

    Attributes
    ----------
    sensor : str
        Name of the sensor.
    n_readings : int
        Number of readings, rejected readings included.
    n_outliers : int
        Number of outliers.
    nis, nis_low, nis_high : float
        Mean normalized innovation squared per component, and its acceptance interval about 1.
    correlation, correlation_bound : float
        Autocorrelation of largest magnitude within `N_LAGS` lags, and the bound of its magnitude.
        Innovations of a correct model are white. They correlate positively if declared errors are
        too small and negatively if declared errors are too large.
    unit : str
        Unit of the three rms values.
    rms_noise, rms_before, rms_after : float
        Root mean square per component: declared noise, and residuals of the used readings without
        and with the estimated calibration parameters of the sensor.
    """

    sensor: str
    n_readings: int
    n_outliers: int
    nis: float
    nis_low: float
    nis_high: float
    correlation: float
    correlation_bound: float
    unit: str
    rms_noise: float
    rms_before: float
    rms_after: float

    @property
    def variance_ratio(self) -> float:
        """Ratio of the actual to the predicted variance of the mean innovation. Positively
        correlated innovations increase the ratio.
        """
        correlated = self.correlation if self.correlation > self.correlation_bound else 0.0
        return self.nis * (1.0 + 2.0 * N_LAGS * correlated)

    @property
    def has_negative_correlation(self) -> bool:
        """True if the innovations have a significant negative correlation."""
        return self.correlation < -self.correlation_bound

    @property
    def outlier_percentage(self) -> float:
        """Percentage of readings that are outliers."""
        return 100.0 * self.n_outliers / self.n_readings

    @property
    def is_noise_as_declared(self) -> bool:
        """True if the innovations scatter no more than the declared noise."""
        return self.nis <= self.nis_high

    @property
    def max_correlation(self) -> float:
        """Largest autocorrelation of the innovations that still passes the whiteness test.

        This is the bound for white innovations, or the correlation at which the variance ratio is 1
        if the declared noise is larger than the actual noise.
        """
        return max(self.correlation_bound, (1.0 / self.nis - 1.0) / (2.0 * N_LAGS))

    @property
    def is_white(self) -> bool:
        """True if the innovations have no significant positive correlation."""
        return self.correlation <= self.max_correlation

    @property
    def has_few_outliers(self) -> bool:
        """True if the share of outliers is acceptable."""
        return self.n_outliers <= MAX_OUTLIER_FRACTION * self.n_readings

    def list_failures(self) -> list[Failure]:
        """Return a failure for each test that the sensor does not pass."""
        result = []
        if not self.is_noise_as_declared:
            result.append(
                Failure(
                    f"noise of {self.sensor}",
                    f"{self.sensor} readings scatter more than their declared noise",
                    f"NIS {self.nis:.3f}, expected at most {self.nis_high:.3f}",
                    "repeat with --fit noise, and declare the noise that is printed",
                )
            )
        if not self.is_white:
            result.append(
                Failure(
                    f"whiteness of {self.sensor}",
                    f"innovations of {self.sensor} are not white, because an error that varies is "
                    "missing or declared too small",
                    f"autocorrelation {self.correlation:.3f}, expected at most "
                    f"{self.max_correlation:.3f}",
                    f"declare more gyro noise, or a varying error of {self.sensor}",
                )
            )
        if not self.has_few_outliers:
            result.append(
                Failure(
                    f"outliers of {self.sensor}",
                    f"{self.outlier_percentage:.2g} % of the {self.sensor} readings are outliers",
                    f"expected at most {100.0 * MAX_OUTLIER_FRACTION:.2g} %",
                    f"correct or remove these readings, or declare more noise of {self.sensor}",
                )
            )
        return result

    def describe_excess_noise(self) -> list[str]:
        """Return a list with a note if the declared noise is larger than the measured noise."""
        if self.nis >= self.nis_low or self.has_negative_correlation:
            return []
        declared, measured = (
            f"{noise:.3g} {self.unit.removeprefix('-')}".rstrip()
            for noise in (self.rms_noise, float(np.sqrt(self.nis)) * self.rms_noise)
        )
        return [
            f"{self.sensor}: the declared noise of {declared} is larger than the measured noise of "
            f"{measured}, so that all 1-sigmas are too large"
        ]


def describe_overestimated_errors(
    solution: Solution, tests: Iterable[SensorTest]
) -> tuple[str, ...]:
    """Return notes if the scenario overstates errors that vary in time, such as gyro noise."""
    negative_tests = [test for test in tests if test.has_negative_correlation]
    if not negative_tests:
        return ()
    suite, states = solution.batch.suite, solution.estimate.states
    result = []
    for block, process in suite.processes.items():
        first, unit = 3 * suite.blocks.index(block), suite.units[block]
        declared, rms = (
            _compute_rms(np.array(process.sigma)),
            _compute_rms(states[:, first : first + 3]),
        )
        if rms < _MIN_RMS_RATIO * declared:
            result.append(
                f"{block} is declared with {unit.factor * declared:.3g} {unit.text}, but "
                f"telemetry shows at most {unit.factor * rms:.2g} {unit.text}"
            )
    names = ", ".join(f"{test.sensor} ({test.correlation:.3f})" for test in negative_tests)
    causes = "; ".join(result) or "noise or steps of the gyro are declared larger than they are"
    return (
        f"innovations of {names} correlate negatively, so all 1-sigmas are too large: {causes}",
    )


def compute_nis_bounds(n_values: int, n_tests: float) -> tuple[float, float]:
    """Compute the acceptance interval of the mean normalized innovation squared (NIS).

    Parameters
    ----------
    n_values : int
        Number of innovation components.
    n_tests : float
        Number of tests that share the significance level.
    """
    tail = 0.5 * SIGNIFICANCE / n_tests
    low, high = 2.0 * gammaincinv(0.5 * n_values, [tail, 1.0 - tail]) / n_values
    return float(low), float(high)


def compute_correlation_bound(n_values: int, n_tests: float) -> float:
    """Compute the acceptance bound for the autocorrelation of white innovations.

    The bound applies to the autocorrelation of largest magnitude within `N_LAGS` lags.

    Parameters
    ----------
    n_values : int
        Number of innovation components.
    n_tests : float
        Number of tests that share the significance level.
    """
    return float(-ndtri(0.5 * SIGNIFICANCE / n_tests / N_LAGS) / np.sqrt(n_values))


def compute_max_autocorrelation(innovations: Innovations) -> float:
    """Return the autocorrelation of largest magnitude within `N_LAGS` lags, averaged over
    components.
    """
    w: Floats = innovations.whitened_values
    variance = (w * w).mean() if len(w) else 1.0
    result = [
        float((w[lag:] * w[:-lag]).mean() / variance)
        for lag in range(1, N_LAGS + 1)
        if len(w) > lag
    ]
    return max(result, key=abs, default=0.0)


def run_sensor_tests(
    fit_result: Fit, filter_results: FilterEstimates, n_tests: float
) -> tuple[SensorTest, ...]:
    """Test the innovations of each sensor that has readings.

    Parameters
    ----------
    fit_result : Fit
    filter_results : FilterEstimates
        Innovations of the fit.
    n_tests : float
        Number of tests that share the significance level.
    """
    suite, tests = fit_result.batch.suite, []
    estimate = fit_result.solution.estimate
    uncalibrated = Trajectory(estimate.attitude, np.zeros_like(estimate.states))
    for index, (sensor, each) in enumerate(
        zip(suite.sensors, filter_results.innovations, strict=True)
    ):
        if not len(each.samples):
            continue
        unit = find_innovation_unit(sensor)
        count, rejected = each.whitened_values.size, int(fit_result.is_rejected[index].sum())
        low, high = compute_nis_bounds(count, n_tests)
        before = compute_innovations(fit_result.batch, index, uncalibrated)
        tests.append(
            SensorTest(
                sensor=sensor.name,
                n_readings=len(each.samples) + rejected,
                n_outliers=rejected,
                nis=float((each.whitened_values**2).mean()),
                nis_low=low,
                nis_high=high,
                correlation=compute_max_autocorrelation(each),
                correlation_bound=compute_correlation_bound(count, n_tests),
                unit=unit.text,
                rms_noise=unit.factor
                * _compute_rms(fit_result.batch.noise[index, : before.shape[1]]),
                rms_before=unit.factor * _compute_rms(before[each.samples]),
                rms_after=unit.factor
                * _compute_rms(fit_result.residuals.values[index, each.samples, : before.shape[1]]),
            )
        )
    return tuple(tests)


@dataclass(frozen=True, kw_only=True)
class PriorTest:
    """Result of a chi-square test of the difference between an estimate and its prior.

    Attributes
    ----------
    block : str
        Block of states, or `ALL_STATES`.
    chi_square : float
        (x - x0)ᵀ P0⁻¹ (x - x0) at the first sample. Without readings it is zero; the test therefore
        fails less often than its significance level.
    degrees_of_freedom : int
        Degrees of freedom.
    max_deviation_sigmas : float
        Largest difference of a state in units of its prior 1-sigma.
    p : float
        Upper bound of the p-value.
    significance_level : float
        Significance level.
    """

    block: str
    chi_square: float
    degrees_of_freedom: int
    max_deviation_sigmas: float
    p: float
    significance_level: float

    @property
    def is_failed(self) -> bool:
        """True if the estimate contradicts the prior at the significance level."""
        return self.p < self.significance_level

    @property
    def failure(self) -> Failure:
        """Description of the failed test."""
        evidence = format_chi_square(
            self.chi_square, self.degrees_of_freedom, self.p, self.significance_level
        )
        if self.block == ALL_STATES:
            cause = "the estimates together contradict their prior"
            action = "check mounting, units and the initial 1-sigmas of the scenario"
        else:
            cause = (
                f"{self.block} differs from its prior by {self.max_deviation_sigmas:.3g} initial "
                "1-sigmas"
            )
            action = (
                f"check mounting and units; if they are right, increase the initial 1-sigma of "
                f"{self.block}"
            )
        return Failure("prior", cause, evidence, action)


def format_chi_square(
    chi_square: float, degrees_of_freedom: int, p: float, significance_level: float
) -> str:
    chance = f"p = {p:.2g}" if p > 1e-300 else "p < 1e-300"
    freedom = f"{degrees_of_freedom} degree{'s' if degrees_of_freedom > 1 else ''} of freedom"
    return (
        f"chi-square {chi_square:.4g} with {freedom}, {chance}, expected at least "
        f"{significance_level:.2g}"
    )


def tabulate_tests(test_class: type[Any], tests: Sequence[Any], index: str) -> pd.DataFrame:
    """Convert test results to a table with one row per result."""
    columns = [field.name for field in fields(test_class)]
    rows = [vars(test) for test in tests]
    frame = pd.DataFrame(rows, columns=columns).set_index(index)
    return frame.drop(columns="significance_level", errors="ignore")


def list_prior_contradictions(tests: Iterable[PriorTest]) -> list[tuple[float, Failure]]:
    """Return the chi-square and the failure of each prior test that fails.

    The test of all states is included only if no block fails.
    """
    failed = [test for test in tests if test.is_failed]
    blocks = [test for test in failed if test.block != ALL_STATES]
    return [(test.chi_square, test.failure) for test in blocks or failed]


def count_prior_tests(prior: PriorEstimate) -> int:
    """Return the number of tests that `run_prior_tests` makes."""
    return len(_list_blocks(prior)) + 1


def run_prior_tests(
    prior: PriorEstimate, attitude: Floats, states: Floats, significance_level: float
) -> tuple[PriorTest, ...]:
    """Test whether the estimate at the first sample agrees with its prior.

    Parameters
    ----------
    attitude : array, shape (3, 3)
        Estimated rotation matrix from body to GCRS.
    states : array, shape (n_states,)
        Estimated states.
    significance_level : float
        Significance level of each test.
    """
    off = prior.compute_difference(attitude, states)
    tests = []
    for name, block in {ALL_STATES: slice(None), **_list_blocks(prior)}.items():
        x = off[block] / prior.sigma[block]
        square = float(x @ np.linalg.solve(prior.correlation[block, block], x))
        freedom = (
            len(x) if name != ALL_STATES else sum(len(off[b]) for b in _list_blocks(prior).values())
        )
        tests.append(
            PriorTest(
                block=name,
                chi_square=square,
                degrees_of_freedom=freedom,
                max_deviation_sigmas=float(np.abs(x).max()),
                p=float(chdtrc(freedom, square)),
                significance_level=significance_level,
            )
        )
    return tuple(tests)


def _list_blocks(prior: PriorEstimate) -> dict[str, slice]:
    named = {name: slice(3 * i, 3 * i + 3) for i, name in enumerate(prior.suite.blocks)}
    if prior.attitude is None:
        del named["attitude"]
    return named


def _compute_rms(values: Floats) -> float:
    return float(np.sqrt((values * values).mean()))
