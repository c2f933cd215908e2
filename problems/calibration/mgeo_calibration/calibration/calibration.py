"""A calibration: what is known of attitude, gyro and sensors once telemetry has been read."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
from mgeo_attitude._typing import Floats
from mgeo_attitude.environment.times import utc_texts
from mgeo_attitude.geometry.quaternion import quaternions
from mgeo_attitude.scenario.after import SUPPORTED
from mgeo_attitude.scenario.scenario import Scenario
from mgeo_attitude.sensors.suite import Suite

from mgeo_calibration.calibration.agreement import (
    PriorTest,
    SensorTest,
    contradictions,
    tests_table,
)
from mgeo_calibration.calibration.corrections import in_units, telemetry_units, uplink
from mgeo_calibration.calibration.model_tests import ModelTest, scatter_of
from mgeo_calibration.estimation.residuals import History

if TYPE_CHECKING:
    import plotly.graph_objects as go
    from mgeo_attitude.plan.plan import ManeuverPlan


@dataclass(frozen=True, eq=False, kw_only=True)
class Calibration:
    """What telemetry says, at its last sample.

    Attributes
    ----------
    scenario : Scenario
    time : float
        Of the last sample [s].
    quaternion : array, shape (4,)
        Attitude then, from GCRF to body, scalar last; see `quaternions`.
    rate_deg_s : array, shape (3,)
        Body rate in the last step, by the gyro without its errors.
    states : array, shape (n_states,)
        Gyro and sensor states then, in the filter's units, rotations as vectors of
        `rotation.rotate`; zero for the attitude.
    covariance : array, shape (n_states, n_states)
        Of their errors, the attitude's first.
    tests : tuple of SensorTest
    prior_tests : tuple of PriorTest
        Of the estimate against what was believed before; none in files of earlier versions.
    model_tests : tuple of ModelTest
        Of what the scenario says beside; none in files of earlier versions.
    causes : tuple of str
        Why prior, model or innovations speak against it, in words, as far as that is seen without
        any attitude; none in files of earlier versions.
    notes : tuple of str
        What else telemetry says, in words.
    rejected : tuple of (time [s], name of sensor, chi-square)
        Outliers.
    history : History, optional
        Not in files.

    Examples
    --------
    >>> from mgeo_attitude import Scenario
    >>> from mgeo_calibration import calibrate, fly
    >>> scenario = Scenario.from_dict({"preset": "paper", "duration": 900.0})
    >>> design = [0.5, 0.3, -0.2, 300.0, -0.3, 0.6, 0.2, 300.0, 0.2, -0.4, 0.7, 300.0]
    >>> found = calibrate(scenario, fly(scenario, design, seed=1))
    >>> found.table()[["block", "estimate", "sigma"]].head(3).round(4)
           block  estimate   sigma
    0  gyro.bias   -0.0136  0.0006
    1  gyro.bias    0.0095  0.0004
    2  gyro.bias    0.0040  0.0005
    """

    scenario: Scenario
    time: float
    quaternion: Floats
    rate_deg_s: Floats
    states: Floats
    covariance: Floats
    tests: tuple[SensorTest, ...]
    rejected: tuple[tuple[float, str, float], ...]
    prior_tests: tuple[PriorTest, ...] = ()
    model_tests: tuple[ModelTest, ...] = ()
    causes: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    history: History | None = field(default=None, repr=False)

    @property
    def suite(self) -> Suite:
        """Gyro, sensors and world."""
        return self.scenario.suite

    @property
    def utc(self) -> str:
        """The instant of the last sample, ISO 8601."""
        return utc_texts(self.scenario.epoch, [self.time])[0]

    def table(self) -> pd.DataFrame:
        """A row for each error and axis: ``block``, ``axis``, ``unit``, ``estimate``...

        ``sigma`` is the 1-sigma of the estimate, ``prior_sigma`` what was believed before; an error
        that varies is that at the last sample. The gyro's bias is in deg/s, that of other sensors
        in the unit of their readings; misalignments are rotation vectors in deg.
        """
        known, sigma = self.scenario.prior, np.sqrt(np.diag(self.covariance))
        prior = self.suite.initial_sigma(0.0) if known is None else known.sigma
        rows = []
        for number, (block, unit) in enumerate(telemetry_units(self.suite).items(), start=1):
            values = in_units(self.suite, self.states, block)
            for i, axis in enumerate("xyz"):
                k = 3 * number + i
                spread = (sigma[k] * unit.factor, prior[k] * unit.factor)
                rows.append((block, axis, unit.text, float(values[i]), *map(float, spread)))
        columns = ["block", "axis", "unit", "estimate", "sigma", "prior_sigma"]
        return pd.DataFrame(rows, columns=columns)

    def uplink(self) -> dict[str, Any]:
        """Numbers to send up, of gyro and sensors by name.

        A sensor reports R (I + diag k + N) s + b of a vector s in body axes, the gyro of the rate:
        ``dcm`` is R, rows first, and ``quaternion`` the same from body to sensor, scalar last;
        ``scale_factor`` is k; ``nonorthogonality`` the elements yz, zx and xy of the symmetric N,
        whose diagonal is zero; ``bias`` is b, in ``unit``, that of the report. So
        s = (I + diag k + N)⁻¹ Rᵀ (report - b), and where there is k or N, ``correction`` is the
        matrix before the bracket. What the scenario does not estimate is left out, and so is what
        varies.
        """
        return uplink(self.suite, self.states)

    @property
    def failures(self) -> list[str]:
        """What prior, model and innovations say against it, in words; none is what one wants.

        The `causes` come first. What is far from its prior, or what the scenario does not say,
        follows, that with the greatest chi-square before the other: it makes good readings look
        bad.
        """
        said = [words for test in self.tests for words in test.failures()]
        scatter = scatter_of(self.tests)  # which tests of the model are without
        # what has changed since an earlier calibration looks like a change soon after
        since = [
            f"{test.block} "
            for test in self.prior_tests
            if test.fails and self.scenario.prior is not None
        ]
        named = [
            (0.0 if test.says.startswith(tuple(since)) else scatter * test.chi_square, test.words)
            for test in self.model_tests
            if test.named
        ]
        far = sorted(contradictions(self.prior_tests), reverse=True)
        first, second = sorted((far, named), key=lambda causes: causes[:1], reverse=True)
        return [*self.causes, *(words for _, words in first + second), *said]

    @property
    def supported(self) -> bool:
        """Whether innovations and estimate are what the scenario says of them."""
        return not self.failures

    @property
    def conclusion(self) -> str:
        """That in one line."""
        if self.supported:
            return SUPPORTED
        return f"{self._against} not support it: {'; '.join(self.failures)}"

    @property
    def _against(self) -> str:
        against = {
            "prior": any(test.fails for test in self.prior_tests),
            "model": any(test.named for test in self.model_tests),
            "innovations": any(test.failures() for test in self.tests),
        }
        (*others, last) = (name for name, speaks in against.items() if speaks)
        if others:
            return f"{', '.join(others)} and {last} do"
        return "the innovations do" if last == "innovations" else f"the {last} does"

    def test_table(self) -> pd.DataFrame:
        """A row for each sensor, see `SensorTest`."""
        return tests_table(SensorTest, self.tests, "sensor")

    def prior_table(self) -> pd.DataFrame:
        """A row for each block of states and one for all, see `PriorTest`."""
        return tests_table(PriorTest, self.prior_tests, "block")

    def model_table(self) -> pd.DataFrame:
        """A row for each test of what the scenario says, see `ModelTest`."""
        return tests_table(ModelTest, self.model_tests, "name")

    def rejected_table(self) -> pd.DataFrame:
        """A row for each outlier: ``time``, ``sensor``, ``chi_square``."""
        return pd.DataFrame(list(self.rejected), columns=["time", "sensor", "chi_square"])

    @property
    def attitude(self) -> pd.DataFrame:
        """The attitude at every sample.

        Columns: ``time``; ``q1`` to ``q4`` from GCRF to body and ``sigma_x``... [deg] about body
        axes by the smoother; the same by the filter, ``filtered_q1``...

        Raises
        ------
        ValueError
            If the calibration was read from a file, which has no history.
        """
        history = self.history
        if history is None:
            raise ValueError("no history of the attitude: a file holds the last sample only")
        columns = {"time": history.times}
        for name, R, sigma in (
            ("", history.smoothed, history.smoothed_sigma),
            ("filtered_", history.filtered, history.filtered_sigma),
        ):
            columns |= {f"{name}q{i + 1}": q for i, q in enumerate(quaternions(R).T)}
            degrees = np.degrees(sigma).T
            columns |= {f"{name}sigma_{axis}": s for axis, s in zip("xyz", degrees, strict=True)}
        return pd.DataFrame(columns)

    def entries(self) -> dict[str, Any]:
        """Where a run goes on from, as JSON has it; a part of files."""
        states = self.states.reshape(-1, 3)[1:].tolist()
        return {
            "scenario": self.scenario.to_dict(),
            "time_s": self.time,
            "quaternion": self.quaternion.tolist(),
            "rate_deg_s": self.rate_deg_s.tolist(),
            "states": dict(zip(self.suite.blocks[1:], states, strict=True)),
            "covariance": self.covariance.tolist(),
        }

    def scenario_after(self, changes: Mapping[str, Any] | None = None) -> Scenario:
        """The scenario that goes on from here: plans are searched, flown and calibrated from it.

        Its epoch is the last sample, its `Scenario.prior` has attitude, rate, estimates and the
        whole covariance. With an ``epoch`` among the changes it is a later one: constants are known
        as well as before, the gyro's bias has drifted by its model, attitude and rate are those of
        ``initial``. All else stays but for the `changes`, as in `Scenario.from_dict`:
        ``{"maneuvers": {"count": 2}}``. A rate above the limit of maneuvers or wheels by no more
        than the gyro's noise is at the limit.

        Raises
        ------
        InvalidValue
            If the calibration is not `supported`, unless ``{"accept_unsupported": True}`` is among
            the changes. Or from the scenario: a run that leaves the field model, say.
        """
        document = {**self.entries(), "conclusion": self.conclusion}
        return Scenario.from_dict({**(changes or {}), "after": document})

    def compare(self, plan: ManeuverPlan) -> pd.DataFrame:
        """1-sigmas that a plan promises for the last sample beside those achieved, per state.

        Columns: ``unit``, that of telemetry, ``predicted``, ``achieved``, and their ratio. The
        plan's linear covariance is that at the last sample, or at the end of the plan's scenario
        if that is earlier: ``attrs["time_s"]``. ``attrs["flown"]`` says of what motion, if that
        may be asked.

        Raises
        ------
        ValueError
            For a plan of a satellite with other states, or from another epoch.
        """
        from mgeo_attitude.filter.history import filter_history
        from mgeo_attitude.view.describe import exactly
        from mgeo_attitude.view.observability.covariance import States

        model, suite = plan.problem.model, self.suite
        if model.suite.blocks != suite.blocks:
            raise ValueError(
                f"the plan is for a satellite with the states {list(model.suite.blocks)}: expected "
                f"the calibration's {list(suite.blocks)}"
            )
        if plan.scenario.epoch != self.scenario.epoch:
            raise ValueError(
                f"the plan begins at {plan.scenario.epoch.isoformat()}: expected the calibration's "
                f"epoch, {self.scenario.epoch.isoformat()}"
            )
        history = filter_history(model.endless, plan.trajectory.commanded)
        k = int(np.argmin(np.abs(history.times - self.time)))
        units = {"attitude": suite.units["attitude"], **telemetry_units(suite)}
        each = [units[block] for block in suite.blocks for _ in "xyz"]
        factors = np.array([unit.factor for unit in each])
        predicted = history.sigma[k] * factors
        achieved = np.sqrt(np.diag(self.covariance)) * factors
        found = pd.DataFrame(
            {
                "unit": [unit.text for unit in each],
                "predicted": predicted,
                "achieved": achieved,
                "achieved / predicted [-]": achieved / predicted,
            },
            index=pd.Index(States.of(model.suite).names, name="state"),
        )
        found.attrs |= {"time_s": float(history.times[k]), "flown": exactly(plan.scenario)}
        return found

    def figures(self) -> dict[str, go.Figure]:
        """Figures ``constants`` and, of one with history, ``innovations`` and ``attitude``."""
        from mgeo_calibration.calibration.figures import calibration_figures

        names, known = [sensor.name for sensor in self.scenario.sensors], self.scenario.prior
        states = np.zeros_like(self.states) if known is None else known.estimates
        believed = [in_units(self.suite, states, block) for block in telemetry_units(self.suite)]
        return calibration_figures(self.table(), np.concatenate(believed), names, self.history)
