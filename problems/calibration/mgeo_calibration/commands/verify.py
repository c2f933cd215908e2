"""Output and result document of the command ``mgeo attitude verify``."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from mgeo_attitude.commands.files import SelectedPlan
from mgeo_attitude.plan.run_folder import PROBLEM
from mgeo_attitude.plan.tables import build_sections

from mgeo.plugins.review import format_section
from mgeo.terminal import Output, build_titled_table, escape_text, format_note, to_records
from mgeo_calibration.commands.fly import format_constraints
from mgeo_calibration.simulators.plan_comparison import format_gyro_guidance
from mgeo_calibration.verification import (
    SIGNIFICANCE_LEVEL,
    Verification,
    describe_failures,
    describe_power,
    format_conclusion,
    list_suggestions,
)

#: Short column names for the terminal.
_SHORT_COLUMNS = {
    "rms / predicted [-]": "/ predicted",
    "rms / filter 1-sigma [-]": "/ filter 1-sigma",
}


def print_verification(picked: SelectedPlan, verification: Verification, output: Output) -> None:
    """Print the conclusion, suggestions, error table and constraint violations of a
    verification.
    """
    plan = picked.plan
    shown = verification.table.iloc[:, :5].rename(columns=_SHORT_COLUMNS)
    output.print(
        escape_text(picked.summary, "bold"),
        *(escape_text(f"violated constraint: {line}", "bold") for line in plan.list_violations()),
        escape_text(format_conclusion(verification), "bold"),
        *picked.list_warnings(),
    )
    if ways := list(list_suggestions(plan, verification)):
        output.print(escape_text("suggestions", "bold"), *(escape_text(f"  {way}") for way in ways))
    output.print(
        *build_titled_table(
            f"{verification.n_runs} Monte Carlo runs, errors at {plan.t_end:.6g} s", shown
        ),
        format_note(f"NEES per state {verification.nees:.3f}; {describe_power(verification)}"),
    )
    for section in build_sections(plan, ["objectives"]):
        output.print(escape_text(f"\n{section.title}", "bold"), format_section(section))
    if len(verification.path_constraints):
        output.print(
            *build_titled_table("path constraints violated", verification.path_constraints),
            format_note(
                "steered: attitude control with the estimate; open loop: exact rates of the plan"
            ),
        )
    if len(verification.gyro_guidance):
        output.print(
            *build_titled_table(
                "Monte Carlo runs with gyro-based guidance",
                format_constraints(verification.gyro_guidance),
            ),
            *(format_note(line) for line in format_gyro_guidance(verification.gyro_guidance)),
        )


def build_verification_document(
    picked: SelectedPlan, verification: Verification, seed: int
) -> dict[str, Any]:
    """Return a verification as a JSON-serializable dict, with the problem and the design of the
    verified plan.
    """
    plan = picked.plan
    table = verification.table.reset_index()
    lines = [
        *(f"violated constraint: {line}" for line in plan.list_violations()),
        format_conclusion(verification),
        f"NEES per state {verification.nees:.3f}",
        describe_power(verification),
        *_describe_constraints(verification),
        *format_gyro_guidance(verification.gyro_guidance),
    ]
    return {
        "title": f"{verification.n_runs} Monte Carlo runs of the plan with t_end "
        f"{plan.t_end:.6g} s and trace {plan.trace:.5g}, seed {seed}",
        "conclusion": "; ".join(lines),
        "seed": seed,
        "findings": [] if verification.is_achieved else describe_failures(verification),
        "suggestions": list(list_suggestions(plan, verification)),
        "level": SIGNIFICANCE_LEVEL,
        "detectable_ratio": verification.detectable_ratio,
        "columns": [str(name) for name in table.columns],
        "rows": table.to_numpy(object).tolist(),
        "solution": picked.solution,
        "summary": plan.summary,
        "problem": PROBLEM,
        "options": plan.problem.to_options(),
        "design": list(plan.design),
        "achieved": bool(verification.is_achieved),
        "violations": plan.list_violations(),
        "path_constraints": to_records(verification.path_constraints),
        "gyro_guidance": to_records(verification.gyro_guidance),
        "monte_carlo": to_records(plan.compare_with_monte_carlo()),
    }


def build_result_path(source: Path, picked: SelectedPlan, seed: int) -> Path | None:
    """Return the path of the result file of a solution in its run folder, or None for a plan that
    was not selected from a run folder.
    """
    number = picked.solution
    return None if number is None else source / f"verification-solution{number}-seed{seed}.json"


def _describe_constraints(verification: Verification) -> Iterator[str]:
    for name, row in verification.path_constraints.iterrows():
        ways = ", ".join(
            f"{row[f'{way}: runs [%]']:.3g} % of runs ({row[f'{way}: time [%]']:.3g} % of "
            f"the time) {way}"
            for way in ("steered", "open loop")
        )
        yield f"{name} violated in {ways}"
