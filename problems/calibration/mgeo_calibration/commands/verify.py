"""``mgeo attitude verify``."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from mgeo_attitude.commands.files import Picked
from mgeo_attitude.commands.show import render_table
from mgeo_attitude.plan.run_folder import PROBLEM
from mgeo_attitude.plan.tables import TABLES

from mgeo.terminal import Output, note, plain, rows, titled
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

#: Columns of the table as they fit a terminal.
_SHORT = {"rms / predicted [-]": "/ predicted", "rms / claimed [-]": "/ claimed"}


def print_verification(picked: Picked, found: Verification, output: Output) -> None:
    """Print errors of simulated flights against their prediction, and suggestions."""
    plan = picked.plan
    shown = found.table.iloc[:, :5].rename(columns=_SHORT)
    output.print(
        plain(picked.answer, "bold"),
        *(plain(f"breaks a limit: {line}", "bold") for line in plan.violations()),
        plain(conclusion(found), "bold"),
        *picked.doubts(),
    )
    if ways := list(remedies(plan, found)):
        output.print(plain("what to try", "bold"), *(plain(f"  {way}") for way in ways))
    output.print(
        *titled(f"{found.n_runs} simulated flights, errors after {plan.t_end:.6g} s", shown),
        note(f"NEES per state {found.nees:.3f}; {power(found)}"),
    )
    output.print(*render_table(TABLES["promises"], plan))
    if len(found.path_limits):
        output.print(
            *titled("path limits broken", found.path_limits),
            note("steered by the estimate, and flown open loop, of all flights"),
        )
    if len(found.ends):
        output.print(
            *titled("Flights that are turned by what their gyro says", limited(found.ends)),
            *(note(line) for line in told(found.ends)),
        )


def verification_document(picked: Picked, found: Verification, seed: int) -> dict[str, Any]:
    """Return the result as JSON values, with problem and design."""
    plan = picked.plan
    table = found.table.reset_index()
    lines = [
        *(f"breaks a limit: {line}" for line in plan.violations()),
        conclusion(found),
        f"NEES per state {found.nees:.3f}",
        power(found),
        *_limits(found),
        *told(found.ends),
    ]
    return {
        "title": f"{found.n_runs} simulated flights of the plan with t_end {plan.t_end:.6g} s and "
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
        "answer": plan.answer,
        "problem": PROBLEM,
        "options": plan.problem.options(),
        "design": list(plan.design),
        "achieved": bool(found.achieved),
        "violations": plan.violations(),
        "path_limits": rows(found.path_limits),
        "ends": rows(found.ends),
        "promises": rows(plan.promises()),
    }


def result_file(source: Path, picked: Picked, seed: int) -> Path | None:
    """Return the file for the result of a run's solution, for `mgeo report`; None for a plan."""
    number = picked.solution
    return None if number is None else source / f"verification-solution{number}-seed{seed}.json"


def _limits(found: Verification) -> Iterator[str]:
    """Say how often each path limit was broken."""
    for name, row in found.path_limits.iterrows():
        ways = ", ".join(
            f"{row[f'{way}: flights [%]']:.3g} % of flights ({row[f'{way}: time [%]']:.3g} % of "
            f"the time) {way}"
            for way in ("steered", "open loop")
        )
        yield f"{name} broken in {ways}"
