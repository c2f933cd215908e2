"""Functions of the command ``mgeo attitude verify``."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from mgeo_attitude.commands.files import SelectedPlan
from mgeo_attitude.commands.show import render_table
from mgeo_attitude.plan.run_folder import PROBLEM
from mgeo_attitude.plan.tables import TABLES

from mgeo.terminal import Output, build_titled_table, escape_text, format_note, to_records
from mgeo_calibration.commands.fly import limited
from mgeo_calibration.flight.as_flown import told
from mgeo_calibration.verification import (
    LEVEL,
    Verification,
    conclusion,
    findings,
    power,
    remedies,
)

#: Short column names for the terminal.
_SHORT = {"rms / predicted [-]": "/ predicted", "rms / claimed [-]": "/ claimed"}


def print_verification(picked: SelectedPlan, found: Verification, output: Output) -> None:
    """Print the errors of Monte Carlo runs with their prediction, and suggestions."""
    plan = picked.plan
    shown = found.table.iloc[:, :5].rename(columns=_SHORT)
    output.print(
        escape_text(picked.summary, "bold"),
        *(escape_text(f"violated constraint: {line}", "bold") for line in plan.list_violations()),
        escape_text(conclusion(found), "bold"),
        *picked.list_warnings(),
    )
    if ways := list(remedies(plan, found)):
        output.print(escape_text("suggestions", "bold"), *(escape_text(f"  {way}") for way in ways))
    output.print(
        *build_titled_table(
            f"{found.n_runs} Monte Carlo runs, errors at {plan.t_end:.6g} s", shown
        ),
        format_note(f"NEES per state {found.nees:.3f}; {power(found)}"),
    )
    output.print(*render_table(TABLES["promises"], plan))
    if len(found.path_limits):
        output.print(
            *build_titled_table("path limits broken", found.path_limits),
            format_note(
                "steered: attitude control with the estimate; open loop: exact rates of the plan"
            ),
        )
    if len(found.ends):
        output.print(
            *build_titled_table("Monte Carlo runs with gyro-based guidance", limited(found.ends)),
            *(format_note(line) for line in told(found.ends)),
        )


def verification_document(picked: SelectedPlan, found: Verification, seed: int) -> dict[str, Any]:
    """Return the verification with problem and design as a JSON-compatible mapping."""
    plan = picked.plan
    table = found.table.reset_index()
    lines = [
        *(f"violated constraint: {line}" for line in plan.list_violations()),
        conclusion(found),
        f"NEES per state {found.nees:.3f}",
        power(found),
        *_describe_constraints(found),
        *told(found.ends),
    ]
    return {
        "title": f"{found.n_runs} Monte Carlo runs of the plan with t_end {plan.t_end:.6g} s and "
        f"trace {plan.trace:.5g}, seed {seed}",
        "conclusion": "; ".join(lines),
        "seed": seed,
        "findings": [] if found.achieved else findings(found),
        "remedies": list(remedies(plan, found)),
        "level": LEVEL,
        "detectable": found.detectable,
        "columns": [str(name) for name in table.columns],
        "rows": table.to_numpy(object).tolist(),
        "solution": picked.solution,
        "answer": plan.summary,
        "problem": PROBLEM,
        "options": plan.problem.to_options(),
        "design": list(plan.design),
        "achieved": bool(found.achieved),
        "violations": plan.list_violations(),
        "path_limits": to_records(found.path_limits),
        "ends": to_records(found.ends),
        "promises": to_records(plan.compare_with_monte_carlo()),
    }


def result_file(source: Path, picked: SelectedPlan, seed: int) -> Path | None:
    """Return the result file of a solution in its run folder, or None for a plan."""
    number = picked.solution
    return None if number is None else source / f"verification-solution{number}-seed{seed}.json"


def _describe_constraints(found: Verification) -> Iterator[str]:
    for name, row in found.path_limits.iterrows():
        ways = ", ".join(
            f"{row[f'{way}: flights [%]']:.3g} % of flights ({row[f'{way}: time [%]']:.3g} % of "
            f"the time) {way}"
            for way in ("steered", "open loop")
        )
        yield f"{name} broken in {ways}"
