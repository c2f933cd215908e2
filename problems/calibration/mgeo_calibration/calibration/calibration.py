"""Result of a calibration: estimates, covariance, consistency tests, tables and JSON entries."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from operator import itemgetter
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
from mgeo_attitude._typing import Floats
from mgeo_attitude.environment.times import format_time_stamps
from mgeo_attitude.geometry.quaternion import quaternions_from_matrices
from mgeo_attitude.scenario.continuation import CONSISTENT
from mgeo_attitude.scenario.criteria import RequiredSigma
from mgeo_attitude.scenario.scenario import Scenario
from mgeo_attitude.sensors.suite import Suite

from mgeo_calibration.calibration.consistency_tests import (
    MAX_OUTLIER_FRACTION,
    Failure,
    PriorTest,
    SensorTest,
    list_prior_contradictions,
    tabulate_tests,
)
from mgeo_calibration.calibration.corrections import (
    compute_corrections,
    convert_block,
    convert_to_si,
    format_label,
)
from mgeo_calibration.calibration.model_tests import ModelTest, compute_variance_ratio
from mgeo_calibration.estimation.residuals import History

if TYPE_CHECKING:
    import plotly.graph_objects as go
    from mgeo_attitude.plan.plan import ManeuverPlan

#: Ratio of the final to the initial 1-sigma above which a parameter is hardly observable.
_UNOBSERVED_RATIO = 0.9


@dataclass(frozen=True, eq=False, kw_only=True)
class Calibration:
    """Result of a calibration: estimates at the last sample, their covariance, and consistency
    tests.

    The estimates are the attitude and the calibration parameters.

    Attributes
    ----------
    scenario : Scenario
    time : float
        Time of the last sample [s].
    quaternion : array, shape (4,)
        Attitude at the last sample, from GCRF to body, scalar last; see
        `quaternions_from_matrices`.
    rate_deg_s : array, shape (3,)
        Body rate in the last step from the corrected gyro [deg/s].
    states : array, shape (n_states,)
        Gyro and sensor states at the last sample in the filter's units. Rotations are vectors of
        `rotation.rotate`; the attitude block is zero.
    covariance : array, shape (n_states, n_states)
        Covariance of the state errors, attitude first.
    tests : tuple of SensorTest
        Tests of the innovations of each sensor.
    prior_tests : tuple of PriorTest
        Tests of the estimate against the prior; empty in files of earlier versions.
    model_tests : tuple of ModelTest
        Tests for errors that the scenario does not model; empty in files of earlier versions.
    data_faults : tuple of str
        Causes of an inconsistency that attitude-independent checks found; empty in files of earlier
        versions.
    notes : tuple of str
        Remarks for the user that are not failures, such as quantized readings.
    outliers : tuple of (float, str, float)
        Time [s], sensor name and chi-square of each rejected reading.
    history : History, optional
        Attitude at every sample; not stored in files.

    Examples
    --------
    >>> from mgeo_attitude import Scenario
    >>> from mgeo_calibration import calibrate, simulate_telemetry
    >>> scenario = Scenario.from_dict({"preset": "paper", "duration": 900.0})
    >>> design = [0.5, 0.3, -0.2, 300.0, -0.3, 0.6, 0.2, 300.0, 0.2, -0.4, 0.7, 300.0]
    >>> calibration = calibrate(scenario, simulate_telemetry(scenario, design, seed=1))
    >>> calibration.build_table()[["block", "unit", "estimate", "sigma"]].head(3).round(1)
           block   unit  estimate  sigma
    0  gyro.bias  deg/h     -49.0    2.1
    1  gyro.bias  deg/h      34.3    1.3
    2  gyro.bias  deg/h      14.3    1.8
    """

    scenario: Scenario
    time: float
    quaternion: Floats
    rate_deg_s: Floats
    states: Floats
    covariance: Floats
    tests: tuple[SensorTest, ...]
    outliers: tuple[tuple[float, str, float], ...]
    prior_tests: tuple[PriorTest, ...] = ()
    model_tests: tuple[ModelTest, ...] = ()
    data_faults: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    history: History | None = field(default=None, repr=False)

    @property
    def suite(self) -> Suite:
        """Gyro, sensors and environment model errors of the scenario.

        The states of this suite are the states of the calibration.
        """
        return self.scenario.suite

    @property
    def utc(self) -> str:
        """UTC of the last sample as an ISO 8601 string."""
        return format_time_stamps(self.scenario.epoch, [self.time])[0]

    @property
    def attitude_sigma_deg(self) -> float:
        """1-sigma of the attitude about the worst body axis at the last sample [deg]."""
        return float(np.degrees(np.sqrt(np.diag(self.covariance)[:3].max())))

    def build_table(self) -> pd.DataFrame:
        """Return a table of the estimated calibration parameters with one row per parameter and
        axis.

        Columns: ``block``, ``axis``, ``unit``, ``estimate``, ``sigma`` (1-sigma of the estimate)
        and ``prior_sigma``. Varying parameters are given at the last sample. Units are those of
        `Suite.units`, in which plans are shown, too; misalignments are rotation vectors.
        """
        scenario_prior, sigma = self.scenario.prior, np.sqrt(np.diag(self.covariance))
        prior = self.suite.initial_sigma(0.0) if scenario_prior is None else scenario_prior.sigma
        rows = []
        for number, block in enumerate(self.suite.blocks[1:], start=1):
            values, unit = convert_block(self.suite, self.states, block), self.suite.units[block]
            for i, axis in enumerate("xyz"):
                k = 3 * number + i
                sigmas = (sigma[k] * unit.factor, prior[k] * unit.factor)
                rows.append((block, axis, unit.text, float(values[i]), *map(float, sigmas)))
        columns = ["block", "axis", "unit", "estimate", "sigma", "prior_sigma"]
        return pd.DataFrame(rows, columns=columns)

    def build_requirement_table(self) -> pd.DataFrame:
        """Return a table that compares the achieved 1-sigmas with those that the scenario requires.

        The index contains the state blocks with a requirement, so that the table is empty for a
        scenario without requirements.

        Columns: ``unit`` as in `build_table`; ``required`` and ``achieved`` 1-sigma, the latter of
        the worst axis at the last sample; and ``satisfied``. No requirement is satisfied by an
        inconsistent calibration, because its 1-sigmas are not valid.
        """
        units = self.suite.units
        achieved = np.sqrt(np.diag(self.covariance)).reshape(-1, 3).max(axis=1)
        required = RequiredSigma(self.scenario.required_sigma).list_sigmas(units)
        rows = {
            block: (
                unit.text,
                bound * unit.factor,
                float(sigma) * unit.factor,
                self.is_consistent and bool(sigma <= bound),
            )
            for (block, unit), bound, sigma in zip(units.items(), required, achieved, strict=True)
            if bound < np.inf
        }
        columns = ["unit", "required", "achieved", "satisfied"]
        return pd.DataFrame(list(rows.values()), pd.Index(list(rows), name="block"), columns)

    def compute_corrections(self) -> dict[str, Any]:
        """Return the parameters with which the on-board software corrects raw readings.

        The dict maps the name of the gyro or of a sensor to a dict of its parameters.

        A sensor reports R (I + diag k + N) s + b for a vector s in the body frame, and the gyro for
        the body rate. ``dcm`` is R in row-major order, and ``quaternion`` the same rotation from
        body to sensor, scalar last. ``scale_factor`` is k. ``nonorthogonality`` contains the
        elements yz, zx and xy of the symmetric N with zero diagonal. ``bias`` is b in the unit
        ``unit`` of the readings. If k or N is estimated, ``correction`` is the matrix C = (I + diag
        k + N)⁻¹ Rᵀ of the correction s = C (report - b). ``latency_s`` is the time stamp of a
        reading minus the time of its measurement [s]. A photodiode has its ``gain`` and the unit
        vector ``normal``. Parameters that the scenario does not estimate and parameters that vary
        are omitted.
        """
        return compute_corrections(self.suite, self.states)

    @property
    def failures(self) -> list[Failure]:
        """Failed consistency tests, starting with the most likely cause of the inconsistency.

        The list is empty for a consistent calibration.

        `data_faults` come first. Contradictions of the prior and unmodeled errors follow, starting
        with the group of the largest chi-square. Failed innovation tests come last, because an
        unmodeled error also affects the innovations of healthy sensors.
        """
        data_failures = [Failure("telemetry faults", fault) for fault in self.data_faults]
        innovation_failures = [failure for test in self.tests for failure in test.list_failures()]
        # Chi-squares of model tests are divided by the variance ratio.
        variance_ratio = compute_variance_ratio(self.tests)
        # A change since an earlier calibration resembles a change soon after the first sample.
        changed_blocks = [
            f"{test.block} "
            for test in self.prior_tests
            if test.is_failed and self.scenario.prior is not None
        ]
        model_causes = [
            (
                0.0
                if test.description.startswith(tuple(changed_blocks))
                else variance_ratio * test.chi_square,
                test.failure,
            )
            for test in self.model_tests
            if test.is_selected
        ]
        prior_causes = sorted(
            list_prior_contradictions(self.prior_tests), key=itemgetter(0), reverse=True
        )
        first, second = sorted(
            (prior_causes, model_causes),
            key=lambda causes: causes[0][0] if causes else -np.inf,
            reverse=True,
        )
        causes = [failure for _, failure in first + second]
        return [*data_failures, *causes, *innovation_failures]

    @property
    def is_consistent(self) -> bool:
        """True if no consistency test fails and no check finds a fault in the telemetry."""
        return not self.failures

    @property
    def conclusion(self) -> str:
        """Text that states whether the calibration passes its consistency tests.

        For an inconsistent calibration, the text names the first failed test, its likely cause, and
        what the user should do.
        """
        if self.is_consistent:
            return CONSISTENT
        first = self.failures[0]
        evidence = f" ({first.evidence})" if first.evidence else ""
        others = " (other causes are possible)" if first.alternatives else ""
        sentences = [
            f'Statistically inconsistent: the test "{first.test}" failed{evidence}.',
            f"Likely cause{others}: {first.cause}.",
        ]
        if first.action:
            sentences.append(f"Do this: {first.action}.")
        return " ".join(sentences)

    def build_test_table(self) -> pd.DataFrame:
        """Return the results of all tests, one row per test.

        The prior is tested by the block with the smallest p-value, and errors that the scenario
        does not model by the error that is closest to its significance level.

        Returns
        -------
        DataFrame
            Columns: ``statistic``; ``value``; ``bound_type`` ("at most" or "at least"),
            ``bound_value``; and ``is_passed``.
        """
        rows: dict[str, tuple[str, float, str, float, bool]] = {}
        if self.data_faults:
            rows["telemetry faults"] = "number", float(len(self.data_faults)), "at most", 0.0, False
        for test in self.tests:
            name = test.sensor
            rows[f"noise of {name}"] = (
                "NIS per component",
                test.nis,
                "at most",
                test.nis_high,
                test.is_noise_as_declared,
            )
            rows[f"whiteness of {name}"] = (
                "autocorrelation",
                test.correlation,
                "at most",
                test.max_correlation,
                test.is_white,
            )
            rows[f"outliers of {name}"] = (
                "share [%]",
                test.outlier_percentage,
                "at most",
                100.0 * MAX_OUTLIER_FRACTION,
                test.has_few_outliers,
            )
        if self.prior_tests:
            prior = min(self.prior_tests, key=lambda test: test.p)
            rows["prior"] = (
                f"p of {format_label(prior.block)}",
                prior.p,
                "at least",
                prior.significance_level,
                not prior.is_failed,
            )
        # A significant error that is not selected is impossible, or explained by a selected error.
        possible = [
            test
            for test in self.model_tests
            if test.is_selected or (test.degrees_of_freedom and test.p >= test.significance_level)
        ]
        if possible:
            model = min(
                possible, key=lambda test: (not test.is_selected, test.p / test.significance_level)
            )
            rows["unmodeled errors"] = (
                f"p of {format_label(model.name)}",
                model.p,
                "at least",
                model.significance_level,
                not model.is_selected,
            )
        columns = ["statistic", "value", "bound_type", "bound_value", "is_passed"]
        index = pd.Index(list(rows), name="test")
        return pd.DataFrame(list(rows.values()), index=index, columns=columns)

    def build_parameters(self) -> list[dict[Any, Any]]:
        """Return the rows of `build_table` as JSON-serializable dicts with additional SI values."""
        table = self.build_table()
        units, factors = zip(*map(convert_to_si, table["unit"]), strict=True)
        for name in ("estimate", "sigma", "prior_sigma"):
            table[f"{name}_si"] = table[name] * np.array(factors)
        return table.assign(unit_si=units).to_dict("records")

    def list_uncalibrated(self) -> dict[str, str]:
        """List the parameters, model errors and sensors that are not calibrated.

        The dict maps each name to the reason.
        """
        table = self.build_table().groupby("block", sort=False)[["sigma", "prior_sigma"]].max()
        ratios = table["sigma"] / table["prior_sigma"]
        considered, processes = self.suite.considered_blocks, self.suite.processes
        reasons = {}
        for block, ratio in ratios.items():
            if block in considered:
                reasons[str(block)] = "considered by the scenario, keeps its prior"
            elif block in processes:
                reasons[str(block)] = "varies with time, no constant correction"
            elif ratio > _UNOBSERVED_RATIO:
                reasons[str(block)] = (
                    f"hardly observable, {100.0 * ratio:.0f} % of the initial 1-sigma remains"
                )
        for test in self.model_tests:
            if not test.degrees_of_freedom:
                reasons[test.name] = (
                    f"not tested as an unmodeled error, because it is {test.description}"
                )
        tested = {test.sensor for test in self.tests}
        for sensor in self.scenario.sensors:
            if sensor.name not in tested:
                reasons[sensor.name] = "no usable readings"
        return reasons

    def build_sensor_test_table(self) -> pd.DataFrame:
        """Return a table of the innovation tests with one row per sensor.

        The columns are the fields of `SensorTest`.
        """
        return tabulate_tests(SensorTest, self.tests, "sensor")

    def build_prior_test_table(self) -> pd.DataFrame:
        """Return a table of the tests that compare the estimates with their prior.

        The table has one row per state block and one row for all states together. The columns are
        the fields of `PriorTest`.
        """
        return tabulate_tests(PriorTest, self.prior_tests, "block")

    def build_model_test_table(self) -> pd.DataFrame:
        """Return a table of the score tests with one row per unmodeled error.

        The columns are the fields of `ModelTest`.
        """
        return tabulate_tests(ModelTest, self.model_tests, "name")

    def build_outlier_table(self) -> pd.DataFrame:
        """Return a table of the rejected readings.

        Columns: ``time_s``, ``sensor`` and ``chi_square``.
        """
        return pd.DataFrame(list(self.outliers), columns=["time_s", "sensor", "chi_square"])

    @property
    def attitude(self) -> pd.DataFrame:
        """Table of the smoothed and the filtered attitude at every sample, with 1-sigmas.

        Columns: ``time`` [s]; smoothed quaternion ``q1`` to ``q4`` from GCRF to body and 1-sigma
        ``sigma_x`` to ``sigma_z`` about the body axes [deg]; the filtered quaternion and 1-sigma
        with the prefix ``filtered_``.

        Raises
        ------
        ValueError
            If the calibration was read from a file, which has no history.
        """
        history = self.history
        if history is None:
            raise ValueError(
                "no history of the attitude: a calibration file contains only the last sample. "
                "Repeat the calibration from telemetry"
            )
        columns = {"time": history.times}
        for name, R, sigma in (
            ("", history.smoothed_attitude, history.smoothed_sigma),
            ("filtered_", history.filtered_attitude, history.filtered_sigma),
        ):
            columns |= {f"{name}q{i + 1}": q for i, q in enumerate(quaternions_from_matrices(R).T)}
            degrees = np.degrees(sigma).T
            columns |= {f"{name}sigma_{axis}": s for axis, s in zip("xyz", degrees, strict=True)}
        return pd.DataFrame(columns)

    def to_entries(self) -> dict[str, Any]:
        """Convert the scenario, the estimates and their covariance to a JSON-serializable dict.

        A follow-up scenario can be built from this dict.
        """
        states = self.states.reshape(-1, 3)[1:].tolist()
        return {
            "scenario": self.scenario.to_dict(),
            "time_s": self.time,
            "quaternion": self.quaternion.tolist(),
            "rate_deg_s": self.rate_deg_s.tolist(),
            "states": dict(zip(self.suite.blocks[1:], states, strict=True)),
            "covariance": self.covariance.tolist(),
        }

    def build_followup_scenario(self, changes: Mapping[str, Any] | None = None) -> Scenario:
        """Return a scenario that continues from the last sample of this calibration.

        The epoch of the scenario is the last sample. Its `Scenario.prior` contains attitude, rate,
        estimates and the full covariance. A later ``epoch`` may be given in the changes: the
        covariance of the constant states then stays, the gyro bias drifts by its model, and
        attitude and rate come from ``initial``. A rate that exceeds the limit of maneuvers or
        wheels by at most the gyro noise is set to the limit.

        Parameters
        ----------
        changes : mapping, optional
            Changes of the scenario as in `Scenario.from_dict`, for example ``{"maneuvers":
            {"count": 2}}``.

        Raises
        ------
        InvalidValue
            If the calibration is not `is_consistent` and the changes lack ``{"accept_inconsistent":
            True}``, or if the scenario is invalid, for example beyond the range of the field model.
        """
        document = {**self.to_entries(), "conclusion": self.conclusion}
        return Scenario.from_dict({**(changes or {}), "after": document})

    def compare(self, plan: ManeuverPlan) -> pd.DataFrame:
        """Compare the achieved 1-sigma of each state with the 1-sigma that a plan predicted.

        Parameters
        ----------
        plan : ManeuverPlan

        Returns
        -------
        DataFrame
            Columns: ``unit`` as in `build_table`, ``predicted``, ``achieved``, and ``ratio`` of
            achieved to predicted. The prediction is the linear covariance of the plan at the last
            sample, or at the end of the plan's scenario if that is earlier; ``attrs["time_s"]`` is
            the time. ``attrs["is_nominal"]`` is true if Monte Carlo runs of the plan differ.

        Raises
        ------
        ValueError
            If the plan has other states or another epoch.
        """
        from mgeo_attitude.filter.history import run_filter
        from mgeo_attitude.view.observability.covariance import StateLabels
        from mgeo_attitude.view.summaries import format_nominal_suffix

        model, suite = plan.problem.model, self.suite
        if model.suite.blocks != suite.blocks:
            raise ValueError(
                f"the plan has the states {list(model.suite.blocks)}: expected the states of the "
                f"calibration, {list(suite.blocks)}"
            )
        if plan.scenario.epoch != self.scenario.epoch:
            raise ValueError(
                f"the plan has the epoch {plan.scenario.epoch.isoformat()}: expected the epoch of "
                f"the calibration, {self.scenario.epoch.isoformat()}"
            )
        history = run_filter(model.full_duration_model, plan.trajectory.commanded_design)
        k = int(np.argmin(np.abs(history.times - self.time)))
        each = [unit for unit in suite.units.values() for _ in "xyz"]
        factors = np.array([unit.factor for unit in each])
        predicted = history.sigma[k] * factors
        achieved = np.sqrt(np.diag(self.covariance)) * factors
        result = pd.DataFrame(
            {
                "unit": [unit.text for unit in each],
                "predicted": predicted,
                "achieved": achieved,
                "ratio": achieved / predicted,
            },
            index=pd.Index(StateLabels.from_suite(model.suite).names, name="state"),
        )
        result.attrs |= {
            "time_s": float(history.times[k]),
            "is_nominal": bool(format_nominal_suffix(plan.scenario)),
        }
        return result

    def draw_figures(self) -> dict[str, go.Figure]:
        """Return a dict of Plotly figures: ``parameters``, ``innovations`` and ``attitude``.

        A calibration that was read from a file only has the figure ``parameters``.
        """
        from mgeo_calibration.calibration.figures import draw_calibration_figures

        names, prior = [sensor.name for sensor in self.scenario.sensors], self.scenario.prior
        states = np.zeros_like(self.states) if prior is None else prior.estimates
        prior_values = [convert_block(self.suite, states, block) for block in self.suite.blocks[1:]]
        return draw_calibration_figures(
            self.build_table(), np.concatenate(prior_values), names, self.history
        )
