"""Output and result document of the command ``mgeo attitude verify``."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import pandas as pd
from mgeo_attitude.commands.files import SelectedPlan
from mgeo_attitude.plan.plan import ManeuverPlan
from mgeo_attitude.plan.run_folder import PROBLEM
from mgeo_attitude.plan.summary import list_warnings
from mgeo_attitude.plan.tables import SECTIONS
from mgeo_attitude.view.summaries import describe_ends

from mgeo._text import format_duration, format_two_digits
from mgeo.plugins.review import Section, build_records, format_bounds
from mgeo.terminal import Output
from mgeo_calibration.calibration.corrections import format_label
from mgeo_calibration.simulators.plan_comparison import VIOLATED_COLUMN, format_gyro_guidance
from mgeo_calibration.verification import (
    FILTER_RATIO,
    PREDICTED_RATIO,
    SIGNIFICANCE_LEVEL,
    Verification,
    describe_failures,
    describe_power,
    format_conclusion,
    list_suggestions,
)

if TYPE_CHECKING:
    from mgeo_calibration.documents import VerificationDocument


#: Titles of columns in reports, where they differ from those of `Verification.table`.
_COLUMN_TITLES = {
    "predicted": "predicted 1-sigma",
    "rms": "rms error",
    "p, predicted": "p-value (predicted)",
    "p, filter": "p-value (filter)",
}


def print_verification(
    picked: SelectedPlan,
    verification: Verification,
    target: Path | None,
    output: Output,
    *,
    has_all_axes: bool,
) -> None:
    """Print the conclusion, suggestions and tables of a verification, and the written file.

    Parameters
    ----------
    picked : SelectedPlan
    verification : Verification
    target : Path, optional
        Written file.
    output : Output
    has_all_axes : bool
        Whether to print every axis in place of the worst axis of each quantity.
    """
    plan = picked.plan
    output.print_title(format_conclusion(verification))
    violations = plan.list_violations()
    if violations:
        output.print_title(
            f"The plan violates constraints of its scenario: {'; '.join(violations)}."
        )
    (end,) = describe_ends(plan.view)
    name = f"{picked.name[0].upper()}{picked.name[1:]}"
    output.print_text(f"{name}, scenario {plan.scenario.name}. {end}.")
    output.print_warnings(list_warnings(plan))
    suggestions = tuple(f"- {line}" for line in list_suggestions(plan, verification))
    sections = [Section("Suggestions", suggestions)] if suggestions else []
    output.print("")
    output.print_sections(*sections, *build_sections(plan, verification, has_all_axes=has_all_axes))
    output.print_files({str(target): "result, which `mgeo report` shows"} if target else {})


def build_sections(
    plan: ManeuverPlan, verification: Verification, *, has_all_axes: bool
) -> list[Section]:
    """Return tables of estimation errors, path constraints and gyro-based guidance.

    Parameters
    ----------
    plan : ManeuverPlan
    verification : Verification
    has_all_axes : bool
        Whether the errors are those of every axis, or of the worst axis of each quantity.
    """
    n_runs, guidance = verification.n_runs, verification.gyro_guidance
    states = verification.table.index if has_all_axes else verification.find_worst_axes()
    axes = (
        "" if has_all_axes else " The axis with the largest ratio is shown; --all shows all axes."
    )
    sections = [
        Section(
            f"Estimation errors after {format_duration(plan.t_end)}, in {n_runs} Monte Carlo runs",
            table=_build_error_table(verification, list(states)),
            note="rms error: root mean square over the runs. Filter 1-sigma: reported by the "
            f"filter in each run. Both ratios pass up to {verification.max_ratio:.2f}.{axes}\n"
            "All states together: the normalized estimation error squared (NEES) per state is "
            f"{verification.nees:.2f}; 1 is expected, and up to {verification.max_nees:.2f} "
            f"passes.\n{describe_power(verification)}",
        ),
    ]
    if len(verification.path_constraints):
        sections.append(
            Section(
                "Violations of path constraints in these runs",
                table=_build_violation_table(verification.path_constraints),
                note="Steered: a controller keeps the estimated attitude on the planned attitude. "
                "Open loop: the planned rates are executed exactly, and the initial attitude error "
                "remains.",
            )
        )
    if len(guidance):
        note = (
            "The controller knows the attitude only from integrated gyro rates, starting from an "
            "estimate with the initial attitude error. These runs have no part in the verdict. "
            f"maneuvers.max_rate_deg_s = {plan.scenario.maneuvers.max_rate_deg_s:g} limits the "
            "planned rates; the controller may exceed it."
        )
        title = f"Motion with gyro-based guidance, in {n_runs} other Monte Carlo runs"
        sections.append(Section(title, table=_build_guidance_table(guidance), note=note))
    return sections


def _build_error_table(verification: Verification, states: list[str]) -> pd.DataFrame:
    table, failed = verification.table.loc[states], verification.find_failed_states()
    return pd.DataFrame(
        {
            "quantity": [format_label(state) for state in states],
            "unit": table["unit"].to_numpy(),
            "predicted 1-sigma": [format_two_digits(value) for value in table["predicted"]],
            "rms error": [format_two_digits(value) for value in table["rms"]],
            "rms / predicted": [f"{value:.2f}" for value in table[PREDICTED_RATIO]],
            "rms / filter 1-sigma": [f"{value:.2f}" for value in table[FILTER_RATIO]],
            "result": ["FAILED" if state in failed else "passed" for state in states],
        }
    )


def _build_violation_table(table: pd.DataFrame) -> pd.DataFrame:
    """Return path-constraint violations, with one row per constraint and kind of motion."""
    rows = [
        (name, motion, row[f"{motion}: runs [%]"], row[f"{motion}: time [%]"])
        for name, row in table.iterrows()
        for motion in ("steered", "open loop")
    ]
    return pd.DataFrame(rows, columns=["constraint", "motion", "runs [%]", "time [%]"])


def _build_guidance_table(table: pd.DataFrame) -> pd.DataFrame:
    """Return the table of gyro-based guidance, without bound columns if there are no bounds."""
    shown = table.drop(columns=["bound_type", "bound_value", VIOLATED_COLUMN])
    has_bound = table["bound_type"] != ""
    if not has_bound.any():
        return shown
    bounds = format_bounds(table["bound_type"], table["bound_value"].map("{:.4g}".format))
    return shown.assign(
        **{"bound": bounds.where(has_bound, "none"), "violated [%]": table[VIOLATED_COLUMN]}
    )


def build_verification_document(
    picked: SelectedPlan, verification: Verification, seed: int
) -> VerificationDocument:
    """Return a verification as a JSON-serializable dict, including the problem and the design."""
    plan = picked.plan
    table = verification.table.reset_index()
    violations = plan.list_violations()
    sentences = [
        format_conclusion(verification),
        *(f"The plan violates a constraint: {line}." for line in violations),
        f"NEES per state {verification.nees:.3f}, threshold {verification.max_nees:.3f}.",
        describe_power(verification),
        *_describe_constraints(verification),
        *format_gyro_guidance(verification.gyro_guidance),
    ]
    return {
        "title": f"Errors after {format_duration(plan.t_end)} in {verification.n_runs} Monte Carlo "
        f"runs, seed {seed}",
        "conclusion": " ".join(sentences),
        "is_achieved": bool(verification.is_achieved),
        "failures": [] if verification.is_achieved else describe_failures(verification),
        "violations": violations,
        "suggestions": list(list_suggestions(plan, verification)),
        "t_end_s": plan.t_end,
        "n_runs": verification.n_runs,
        "seed": seed,
        "significance_level": SIGNIFICANCE_LEVEL,
        "max_ratio": verification.max_ratio,
        "nees": verification.nees,
        "max_nees": verification.max_nees,
        "detectable_ratio": verification.detectable_ratio,
        "columns": [_COLUMN_TITLES.get(str(name), str(name)) for name in table.columns],
        "rows": table.to_numpy(object).tolist(),
        "solution": picked.solution,
        "summary": plan.summary,
        "problem": PROBLEM,
        "options": plan.problem.to_options(),
        "design": list(plan.design),
        "path_constraints": build_records(verification.path_constraints),
        "gyro_guidance": build_records(verification.gyro_guidance),
        "objectives": build_records(SECTIONS["objectives"].table(plan)),
    }


def build_result_path(source: Path, picked: SelectedPlan, seed: int) -> Path | None:
    """Return the path of a verification result in the run folder, or None for a plan file."""
    number = picked.solution
    return None if number is None else source / f"verification-solution{number}-seed{seed}.json"


def _describe_constraints(verification: Verification) -> Iterator[str]:
    for name, row in verification.path_constraints.iterrows():
        ways = ", ".join(
            f"{row[f'{way}: runs [%]']:.3g} % of runs ({row[f'{way}: time [%]']:.3g} % of "
            f"the time) {way}"
            for way in ("steered", "open loop")
        )
        yield f"{name} is violated in {ways}."
