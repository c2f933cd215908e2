"""Whether a sensor's innovations are what the scenario says of its noise."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from mgeo_attitude._typing import Floats
from scipy.stats import chi2, norm

from mgeo_calibration.estimation.residuals import Innovations

#: Probability that any test of a calibration fails by chance.
SIGNIFICANCE = 0.01
#: Lags, in readings of a sensor, at which innovations are tested for correlation.
LAGS = 5
#: Share of a sensor's readings that may be outliers.
MOST_REJECTED = 0.05


@dataclass(frozen=True, kw_only=True)
class SensorTest:
    """Tests of a sensor's innovations; all intervals are exceeded by chance only.

    Attributes
    ----------
    sensor : str
    readings : int
        Used and rejected ones.
    rejected : int
        Outliers.
    nis, nis_low, nis_high : float
        Mean normalized innovation squared per component, and its interval about 1.
    correlation, correlation_bound : float
        Largest magnitude of the autocorrelation at `LAGS` lags, and its bound: innovations of the
        right model are white.
    unit : str
    noise, before, after : float
        Root mean square per component: the scenario's noise, and residuals of the used readings to
        the smoothed attitude with no error of the sensor taken out and with those estimated.
    """

    sensor: str
    readings: int
    rejected: int
    nis: float
    nis_low: float
    nis_high: float
    correlation: float
    correlation_bound: float
    unit: str
    noise: float
    before: float
    after: float

    def failures(self) -> list[str]:
        """What does not hold, in words."""
        found = []
        if not self.nis <= self.nis_high:
            found.append(
                f"{self.sensor} scatters more than its noise (NIS {self.nis:.3f}, expected "
                f"{self.nis_low:.3f} to {self.nis_high:.3f})"
            )
        if not self.correlation <= self.correlation_bound:
            found.append(
                f"innovations of {self.sensor} are not white (correlation {self.correlation:.3f}, "
                f"expected at most {self.correlation_bound:.3f})"
            )
        if self.rejected > MOST_REJECTED * self.readings:
            share = 100.0 * self.rejected / self.readings
            found.append(f"{share:.2g} % of {self.sensor} are outliers")
        return found

    def notes(self) -> list[str]:
        """Noise that is less than was said: the estimate is better than its 1-sigmas say."""
        if self.nis >= self.nis_low:
            return []
        less = float(np.sqrt(self.nis))
        angle = self.unit == "-"  # of a unit vector
        unit, said = ("deg", np.degrees(self.noise)) if angle else (self.unit, self.noise)
        return [
            f"{self.sensor}: sigmas are too large by {1.0 / less:.3g}; measured {less * said:.3g} "
            f"{unit}, the scenario says {said:.3g}"
        ]


def nis_bounds(count: int, tests: int) -> tuple[float, float]:
    """Interval of the mean of so many squares of standard normal numbers, for one of the tests."""
    tail = 0.5 * SIGNIFICANCE / tests
    low, high = chi2.ppf([tail, 1.0 - tail], count) / count
    return float(low), float(high)


def correlation_bound(count: int, tests: int) -> float:
    """What the largest of `LAGS` correlations of so many numbers exceeds by chance only."""
    return float(norm.isf(0.5 * SIGNIFICANCE / tests / LAGS) / np.sqrt(count))


def greatest_correlation(innovations: Innovations) -> float:
    """Largest magnitude of the autocorrelation, over lags and averaged over the components."""
    w: Floats = innovations.whitened
    variance = (w * w).mean() if len(w) else 1.0
    found = [
        abs(float((w[lag:] * w[:-lag]).mean() / variance))
        for lag in range(1, LAGS + 1)
        if len(w) > lag
    ]
    return max(found, default=0.0)
