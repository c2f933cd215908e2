"""Tables of a calibration for people, as shown in the terminal and in the HTML report."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pandas as pd
from mgeo_attitude.sensors.photodiode import Photodiode

from mgeo._text import format_duration, format_two_digits
from mgeo.plugins.review import Section, format_bounds
from mgeo_calibration.calibration.calibration import Calibration
from mgeo_calibration.calibration.consistency_tests import SIGNIFICANCE
from mgeo_calibration.calibration.corrections import format_label
from mgeo_calibration.calibration.recalibration import compare_calibrations, describe_noise

#: Largest number of outliers in a table. The JSON file contains all outliers.
_MAX_OUTLIERS = 20
#: Number of decimals beyond which a value is shown with an exponent.
_MAX_DECIMALS = 6
#: Largest number of sensors of which the first page shows every test.
_MAX_SENSORS = 3
#: Formats of the test statistics; p-values have two significant digits.
_STATISTIC_FORMATS = {
    "NIS per component": "{:.3f}",
    "autocorrelation": "{:.3f}",
    "share [%]": "{:.1f}",
}


def build_summary_sections(
    calibration: Calibration, predicted: pd.DataFrame | None = None
) -> list[Section]:
    """Return the sections on the first page of a report, such as parameters and tests.

    Sections without content are omitted.

    Parameters
    ----------
    predicted : DataFrame, optional
        Comparison with the prediction of a plan; see `Calibration.compare`.
    """
    table = calibration.build_table()
    table = table[~table["block"].isin(calibration.suite.uncalibrated_blocks)]
    valid = "" if calibration.is_consistent else ", not to be used"
    notes = ["1-sigma and initial 1-sigma: worst axis, after and before the calibration."]
    if not valid:
        notes += _describe_corrections(calibration)
    sections = [
        Section(
            f"Calibration parameters{valid}",
            table=_build_parameter_table(table),
            note="\n".join(notes),
        ),
        *_build_requirement_sections(calibration),
    ]
    if predicted is not None:
        sections.append(build_prediction_section(predicted, by_axis=False))
    tests = calibration.build_test_table()
    selected = _select_tests(tests) if len(calibration.tests) > _MAX_SENSORS else tests
    title = (
        "Tests" if selected is tests else "Tests; of each kind, the sensor closest to its threshold"
    )
    note = _describe_tests(calibration)
    sections.append(Section(title, table=_format_tests(selected), note=note))
    failures = calibration.failures
    findings = {
        "Other causes that cannot be distinguished from the likely cause": [
            text for failure in failures[:1] for text in failure.list_alternatives()
        ],
        "Other failed tests, often with the same cause": [
            ": ".join(filter(None, (failure.cause, failure.action))) for failure in failures[1:]
        ],
    }
    for title, texts in findings.items():
        if texts:
            sections.append(Section(title, lines=tuple(f"- {text}." for text in texts)))
    if reasons := calibration.list_uncalibrated():
        names_by_reason: dict[str, list[str]] = {}
        for name, reason in reasons.items():
            names_by_reason.setdefault(reason, []).append(format_label(name))
        lines = [f"- {', '.join(names)}: {reason}." for reason, names in names_by_reason.items()]
        sections.append(Section("Not calibrated or not tested", lines=tuple(lines)))
    if calibration.notes:
        sections.append(Section("Notes", lines=tuple(f"- {note}." for note in calibration.notes)))
    return sections


def build_detail_sections(
    calibration: Calibration, predicted: pd.DataFrame | None = None
) -> list[Section]:
    """Return the detailed sections after the first page of a report, such as residuals and
    outliers.

    Parameters
    ----------
    predicted : DataFrame, optional
        Comparison with the prediction of a plan; see `Calibration.compare`.
    """
    rows = [
        (format_label(f"{row['block']} {row['axis']}"), row["unit"], *_format_row(row))
        for row in calibration.build_table().to_dict("records")
    ]
    columns = ["parameter", "unit", "estimate", "1-sigma", "initial 1-sigma"]
    sections = [
        Section("Parameters of each axis", table=pd.DataFrame(rows, columns=columns)),
        Section(
            "Residuals of the readings",
            table=_build_residual_table(calibration),
            note="Root mean square (rms) per component: noise of the scenario, and residuals "
            "before and after the correction with the calibration parameters.",
        ),
    ]
    if len(calibration.tests) > _MAX_SENSORS:
        table = _format_tests(calibration.build_test_table())
        sections.append(Section("Tests of every sensor", table=table))
    if predicted is not None:
        sections.append(build_prediction_section(predicted, by_axis=True))
    if calibration.prior_tests:
        sections.append(
            Section(
                "Agreement of the estimates with their prior",
                table=_build_prior_table(calibration),
                note="Distance: largest difference from the prior of an axis, in initial 1-sigmas. "
                "A test is passed if p is at least min p.",
            )
        )
    if calibration.model_tests:
        sections.append(
            Section(
                "Errors that the scenario does not model",
                table=_build_model_table(calibration),
                note="\n".join(
                    [
                        "An error is found if p is below min p and no other error explains the "
                        "data better. Chi-squares are divided by the ratio of the actual to the "
                        "declared variance of the readings. Estimate of each error, if it were the "
                        "only one:",
                        *(
                            f"- {test.description}"
                            + (f"; {test.alternatives}." if test.alternatives else ".")
                            for test in calibration.model_tests
                            if test.degrees_of_freedom
                        ),
                    ]
                ),
            )
        )
    outliers = calibration.build_outlier_table()
    if len(outliers):
        more = f", the first {_MAX_OUTLIERS}" if len(outliers) > _MAX_OUTLIERS else ""
        titles = {"time_s": "time [s]", "chi_square": "chi-square"}
        sections.append(
            Section(
                f"{len(outliers)} rejected readings{more}",
                table=outliers[:_MAX_OUTLIERS].rename(columns=titles),
                note="Chi-square: squared difference between the reading and its prediction from "
                "all other readings, divided by its variance. Valid readings have about the number "
                "of their components.",
            )
        )
    return sections


def build_prediction_section(predicted: pd.DataFrame, *, by_axis: bool) -> Section:
    """Return a section that compares the predicted with the achieved 1-sigmas.

    The rows are all axes or, if `by_axis` is false, the worst axis of each quantity.

    Parameters
    ----------
    predicted : DataFrame
        Result of `Calibration.compare`.
    by_axis : bool
    """
    table, title = predicted, "Predicted and achieved 1-sigma of each axis"
    if not by_axis:
        title = "Predicted and achieved 1-sigma, worst axis"
        table = table.groupby(lambda name: name.rpartition(" ")[0], sort=False).max()
        table["ratio"] = table["achieved"] / table["predicted"]
    shown = pd.DataFrame(
        {
            "unit": table["unit"],
            "predicted": table["predicted"].map(format_two_digits),
            "achieved": table["achieved"].map(format_two_digits),
            "achieved / predicted": table["ratio"].map("{:.2f}".format),
        }
    )
    shown = shown.rename(format_label).rename_axis("quantity")
    run = " in its nominal run" if predicted.attrs["is_nominal"] else ""
    note = (
        f"Predicted: by the plan{run}, for {format_duration(predicted.attrs['time_s'])} after the "
        "epoch. Achieved: by this calibration."
    )
    return Section(title, table=shown, note=note)


def build_recalibration_section(first: Calibration, second: Calibration) -> Section:
    """Return a section that compares a repeated calibration with the first calibration."""
    rows = []
    for row in compare_calibrations(first, second).reset_index().to_dict("records"):
        old, sigma = row["estimate before"], row["sigma"]
        rows.append(
            (
                format_label(f"{row['block']} {row['axis']}"),
                row["unit"],
                "" if np.isnan(old) else format_with_decimals(old, sigma),
                format_with_decimals(row["estimate"], sigma),
                format_two_digits(sigma),
                f"{row['change / sigma [-]']:.1f}",
            )
        )
    columns = ["parameter", "unit", "first estimate", "repeated estimate", "1-sigma"]
    return Section(
        "Comparison of the repeated calibration with the first calibration",
        table=pd.DataFrame(rows, columns=[*columns, "change [1-sigma]"]),
        lines=(
            f"First calibration: {first.conclusion}",
            f"Sensor noise in the repeated calibration: {describe_noise(second)}.",
        ),
    )


def format_with_decimals(value: float, sigma: float) -> str:
    """Round an estimate to the second significant digit of its 1-sigma, and format it as text."""
    decimals = 1 - math.floor(math.log10(sigma)) if sigma > 0.0 else _MAX_DECIMALS
    if decimals > _MAX_DECIMALS:
        return f"{value:.2e}"
    return f"{round(value, decimals) + 0.0:.{max(decimals, 0)}f}"  # No minus sign at zero.


def _format_row(row: dict[Any, Any]) -> tuple[str, str, str]:
    value = format_with_decimals(row["estimate"], row["sigma"])
    return value, format_two_digits(row["sigma"]), format_two_digits(row["prior_sigma"])


def _build_parameter_table(table: pd.DataFrame) -> pd.DataFrame:
    rows = []
    for block, axes in table.groupby("block", sort=False):
        sigma = axes["sigma"].max()
        values = [format_with_decimals(value, sigma) for value in axes["estimate"]]
        sigmas = map(format_two_digits, (sigma, axes["prior_sigma"].max()))
        rows.append((format_label(str(block)), axes["unit"].iloc[0], *values, *sigmas))
    columns = ["parameter", "unit", "x", "y", "z", "1-sigma", "initial 1-sigma"]
    return pd.DataFrame(rows, columns=columns)


def _describe_corrections(calibration: Calibration) -> tuple[str, ...]:
    """Return lines of text with the equations that correct readings.

    The last line states where the file of the calibration contains the numbers.
    """
    blocks = calibration.suite.blocks
    states = {state for owner, _, state in (b.partition(".") for b in blocks) if owner != "gyro"}
    lines = ["Corrected rate = reported rate - gyro bias."] if "gyro.bias" in blocks else []
    reading = "(reading - bias)" if "bias" in states else "reading"
    if {"scale_factor", "nonorthogonality"} & states:
        lines.append(
            f"Corrected vector in body axes = C {reading}, with the matrix C of the sensor's "
            "misalignment, scale factors and nonorthogonality."
        )
    elif "misalignment" in states:
        lines.append(
            f"Corrected vector in body axes = Rᵀ {reading}. R = exp([θ×]) transforms vectors from "
            "body to sensor axes, which coincide for a misalignment θ = 0 rad."
        )
    elif "bias" in states:
        lines.append(f"Corrected vector = {reading}.")
    if any(isinstance(sensor, Photodiode) for sensor in calibration.scenario.sensors):
        lines.append(
            "Sensitivity of a photodiode: relative error of its gain (z), and tilt of its normal "
            "(x, y) [rad]."
        )
    lines.append(
        'Corrections to upload: "corrections" in calibration.json, which --out DIR writes. They '
        "contain the matrices, and the biases in the units of the readings."
    )
    return tuple(lines)


def describe_requirements(calibration: Calibration) -> str:
    """Return a sentence on whether the calibration satisfies the required 1-sigmas.

    The text is empty without requirements or if the calibration is inconsistent.
    """
    table = calibration.build_requirement_table()
    if table.empty or not calibration.is_consistent:
        return ""
    violated = table[~table["satisfied"]]
    if violated.empty:
        return "All required 1-sigmas are satisfied."
    names, verb = (
        ", ".join(map(format_label, violated.index)),
        "is" if len(violated) == 1 else "are",
    )
    return (
        f"{len(violated)} of {len(table)} required 1-sigmas {verb} violated: {names}. Plan further "
        "maneuvers."
    )


def _build_requirement_sections(calibration: Calibration) -> list[Section]:
    table = calibration.build_requirement_table()
    if table.empty:
        return []
    results = {True: "satisfied", False: "VIOLATED"}
    shown = pd.DataFrame(
        {
            "unit": table["unit"],
            "required": table["required"].map("{:.3g}".format),
            "achieved": table["achieved"].map(format_two_digits),
            "result": table["satisfied"].map(results) if calibration.is_consistent else "not valid",
        }
    )
    shown = shown.rename(format_label).rename_axis("quantity")
    return [Section("Required 1-sigma, worst axis", table=shown)]


def _select_tests(table: pd.DataFrame) -> pd.DataFrame:
    """Select all failed tests and, for each kind of test, the one closest to its bound."""
    ratio = table["value"] / table["bound_value"]
    closest = ratio.groupby(lambda name: name.partition(" of ")[0]).idxmax()
    return table[~table["is_passed"] | table.index.isin(closest)]


def _describe_tests(calibration: Calibration) -> str:
    n_errors = sum(test.degrees_of_freedom > 0 for test in calibration.model_tests)
    lines = [
        "- Noise: mean normalized innovation squared (NIS); 1 if noise is as declared.",
        "- Whiteness: largest correlation of innovations; 0 if all errors are modeled.",
        "- Outliers: share of readings rejected as too far from the fit to all others.",
        "- Prior: p-value of the parameter that is farthest from its initial value.",
        f"- Unmodeled errors: p-value of the most significant of {n_errors} possible errors.",
        f"Probability of a false alarm, all tests together: {100.0 * SIGNIFICANCE:.0f} %.",
    ]
    return "\n".join(lines if n_errors else [*lines[:-2], lines[-1]])


def _format_tests(table: pd.DataFrame) -> pd.DataFrame:
    formats = [_STATISTIC_FORMATS.get(name, "{:.2g}") for name in table["statistic"]]
    values, bounds = (
        [text.format(value) for text, value in zip(formats, table[name], strict=True)]
        for name in ("value", "bound_value")
    )
    return pd.DataFrame(
        {
            "statistic": table["statistic"],
            "value": values,
            "threshold": format_bounds(table["bound_type"], bounds),
            "result": ["passed" if is_passed else "FAILED" for is_passed in table["is_passed"]],
        },
        index=table.index,
    )


def _build_residual_table(calibration: Calibration) -> pd.DataFrame:
    names = {
        "unit": "unit",
        "n_readings": "readings",
        "n_outliers": "outliers",
        "rms_noise": "declared noise",
        "rms_before": "rms before",
        "rms_after": "rms after",
    }
    table = calibration.build_sensor_test_table()
    return table[list(names)].rename(columns=names)


def _build_prior_table(calibration: Calibration) -> pd.DataFrame:
    rows = [
        (
            format_label(test.block),
            f"{test.max_deviation_sigmas:.2f}",
            *_format_chi_square(test),
            "FAILED" if test.is_failed else "passed",
        )
        for test in calibration.prior_tests
    ]
    columns = ["parameter", "distance", "chi-square", "degrees of freedom", "p", "min p"]
    return pd.DataFrame(rows, columns=[*columns, "result"])


def _build_model_table(calibration: Calibration) -> pd.DataFrame:
    rows = [
        (
            test.name,
            *(_format_chi_square(test) if test.degrees_of_freedom else ["", "", "", ""]),
            "FOUND"
            if test.is_selected
            else "not found"
            if test.degrees_of_freedom
            else "not tested",
        )
        for test in calibration.model_tests
    ]
    columns = ["error", "chi-square", "degrees of freedom", "p", "min p", "result"]
    return pd.DataFrame(rows, columns=columns)


def _format_chi_square(test: Any) -> list[str]:
    return [
        f"{test.chi_square:.3g}",
        str(test.degrees_of_freedom),
        f"{test.p:.2g}",
        f"{test.significance_level:.2g}",
    ]
