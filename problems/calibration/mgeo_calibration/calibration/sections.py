"""Tables of a calibration for people, as shown in the terminal and in the HTML report."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pandas as pd

from mgeo._text import format_two_digits
from mgeo.plugins.review import Section
from mgeo_calibration.calibration.calibration import Calibration
from mgeo_calibration.calibration.consistency_tests import ALL_STATES, SIGNIFICANCE
from mgeo_calibration.calibration.corrections import format_label
from mgeo_calibration.calibration.recalibration import compare_calibrations, describe_noise

#: Largest number of outliers in a table. The JSON file contains all outliers.
MAX_OUTLIERS = 100
#: Number of decimals beyond which a value is shown with an exponent.
_MAX_DECIMALS = 6
#: Largest number of sensors of which the first page shows every test.
_MAX_SENSORS = 3
#: Meaning of the tests.
_TEST_NOTE = (
    "Noise: normalized innovations squared (NIS), 1 if readings scatter as declared. Whiteness: "
    "correlation of successive innovations, 0 if the model omits no time-varying error. Prior: "
    "smallest p-value of the estimates, given the initial 1-sigmas. Unmodeled errors: p-value of "
    "the most significant error that the scenario omits. Correct telemetry fails at least one of "
    f"the tests with a probability of {100.0 * SIGNIFICANCE:.0f} %."
)


def build_summary_sections(
    calibration: Calibration, predicted: pd.DataFrame | None = None
) -> list[Section]:
    """Return the sections of the first page: parameters, comparison with a plan, tests, further
    findings, and what is not calibrated. Sections without content are omitted.

    Parameters
    ----------
    predicted : DataFrame, optional
        Comparison with the prediction of a plan; see `Calibration.compare`.
    """
    table = calibration.build_table()
    table = table[~table["block"].isin(calibration.suite.uncalibrated_blocks)]
    sections = [
        Section(
            "Calibration parameters"
            if calibration.is_consistent
            else "Calibration parameters, not to be used",
            table=_build_parameter_table(table),
            note="\n".join(
                [
                    "1-sigma and initial 1-sigma: worst axis of each parameter.",
                    *_describe_corrections(calibration),
                ]
            ),
        )
    ]
    if predicted is not None:
        sections.append(build_prediction_section(predicted, by_axis=False))
    tests = calibration.build_test_table()
    selected = _select_tests(tests) if len(calibration.tests) > _MAX_SENSORS else tests
    title = "Tests" if selected is tests else "Tests, those of the worst sensors"
    sections.append(Section(title, table=_format_tests(selected), note=_TEST_NOTE))
    failures = calibration.failures
    findings = {
        "Other causes that cannot be distinguished from the likely cause": [
            text for failure in failures[:1] for text in failure.list_alternatives()
        ],
        "Further findings, which may have the same cause": [
            failure.summary for failure in failures[1:]
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
        sections.append(Section("Not calibrated", lines=tuple(lines)))
    if calibration.notes:
        sections.append(Section("Notes", lines=tuple(f"- {note}." for note in calibration.notes)))
    return sections


def build_detail_sections(
    calibration: Calibration, predicted: pd.DataFrame | None = None
) -> list[Section]:
    """Return the sections after the first page: every axis, residuals, and each test of the prior
    and of unmodeled errors, and the outliers.

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
            note="rms per component, before and after the correction with the calibration "
            "parameters",
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
                note="distance: largest difference from the prior in initial 1-sigmas",
            )
        )
    if calibration.model_tests:
        sections.append(
            Section(
                "Errors that the scenario does not model",
                table=_build_model_table(calibration),
                note="\n".join(
                    [
                        "An error is found if p is below the bound and no other error explains the "
                        "data better. Estimates if the error existed:",
                        *(
                            f"- {test.name}: {test.description}"
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
        more = f", the first {MAX_OUTLIERS}" if len(outliers) > MAX_OUTLIERS else ""
        titles = {"time_s": "time [s]", "chi_square": "chi-square"}
        table = outliers[:MAX_OUTLIERS].rename(columns=titles)
        sections.append(Section(f"{len(outliers)} rejected readings{more}", table=table))
    return sections


def build_prediction_section(predicted: pd.DataFrame, *, by_axis: bool) -> Section:
    """Return the comparison of predicted and achieved 1-sigmas, for every axis or for the worst
    axis of each quantity.

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
            "ratio": table["ratio"].map("{:.2f}".format),
        }
    )
    shown = shown.rename(format_label).rename_axis("quantity")
    note = (
        f"Predicted: by the plan{predicted.attrs['motion']}, {predicted.attrs['time_s']:.6g} s "
        "after the epoch. Achieved: by the filter with the telemetry. Ratio: achieved / predicted."
    )
    return Section(title, table=shown, note=note)


def build_recalibration_section(first: Calibration, second: Calibration) -> Section:
    """Return the comparison of a calibration with its repetition with more states or with
    estimated noise.
    """
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
                f"{row['change / sigma [-]']:.2f}",
            )
        )
    columns = ["parameter", "unit", "first estimate", "repeated estimate", "1-sigma"]
    return Section(
        "Comparison of the repeated calibration with the first calibration",
        table=pd.DataFrame(rows, columns=[*columns, "change [1-sigma]"]),
        lines=(f"Noise: {describe_noise(second)}.", f"First calibration: {first.conclusion}"),
    )


def format_with_decimals(value: float, sigma: float) -> str:
    """Format an estimate with the decimals of the second significant digit of its 1-sigma."""
    decimals = 1 - math.floor(math.log10(sigma)) if sigma > 0.0 else _MAX_DECIMALS
    if decimals > _MAX_DECIMALS:
        return f"{value:.2e}"
    return f"{round(value, decimals) + 0.0:.{max(decimals, 0)}f}"  # No minus sign at zero.


def _format_bound(bound: float) -> str:
    return f"{bound:.3g}" if bound >= 0.01 else f"{bound:.2g}"


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
    """Return the equations that correct readings with the estimated parameters."""
    blocks = calibration.suite.blocks
    states = {state for owner, _, state in (b.partition(".") for b in blocks) if owner != "gyro"}
    lines = ["Corrected rate = reported rate - gyro bias."] if "gyro.bias" in blocks else []
    errors = [name for name in ("scale_factor", "nonorthogonality") if name in states]
    stretch = " + ".join(["I", *(name.replace("_", " ") for name in errors)])
    factors = [f"({stretch})⁻¹"] if errors else []
    factors += ["Rᵀ"] if "misalignment" in states else []
    reading = "(reading - bias)" if "bias" in states else "reading"
    if factors or "bias" in states:
        where = (
            "; R = exp[misalignment ×] (a rotation vector) transforms body to sensor axes"
            if "misalignment" in states
            else ""
        )
        lines.append(f"Corrected vector in body axes = {' '.join([*factors, reading])}{where}.")
        lines.append('The matrices of each sensor are under "corrections" in calibration.json.')
    return tuple(lines)


def _select_tests(table: pd.DataFrame) -> pd.DataFrame:
    """Return the failed tests, and the test of each kind that is closest to its bound."""
    ratio = table["value"] / table["bound_value"]
    closest = ratio.groupby(lambda name: name.partition(" of ")[0]).idxmax()
    return table[~table["is_passed"] | table.index.isin(closest)]


def _format_tests(table: pd.DataFrame) -> pd.DataFrame:
    bounds = zip(table["bound_type"], table["bound_value"], strict=True)
    return pd.DataFrame(
        {
            "statistic": table["statistic"],
            "value": table["value"].map("{:.3g}".format),
            "threshold": [f"{kind} {_format_bound(bound)}" for kind, bound in bounds],
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
            "all parameters" if test.block == ALL_STATES else format_label(test.block),
            f"{test.max_deviation_sigmas:.2f}",
            *_format_chi_square(test),
            "FAILED" if test.is_failed else "passed",
        )
        for test in calibration.prior_tests
    ]
    columns = ["parameter", "distance", "chi-square", "degrees of freedom", "p", "bound of p"]
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
    columns = ["error", "chi-square", "degrees of freedom", "p", "bound of p", "result"]
    return pd.DataFrame(rows, columns=columns)


def _format_chi_square(test: Any) -> list[str]:
    return [
        f"{test.chi_square:.4g}",
        str(test.degrees_of_freedom),
        f"{test.p:.2g}",
        f"{test.significance_level:.2g}",
    ]
