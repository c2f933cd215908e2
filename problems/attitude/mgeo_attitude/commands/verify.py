"""``mgeo attitude verify``."""

from __future__ import annotations

from typing import Any

from mgeo.cli.output import Output
from mgeo.terminal import plain
from mgeo_attitude.commands.files import Picked
from mgeo_attitude.commands.show import note, promised, rows, titled
from mgeo_attitude.plan.run_folder import PROBLEM
from mgeo_attitude.plan.verification import Verification


def print_verification(picked: Picked, found: Verification, output: Output) -> None:
    """Print how simulated flights of a plan went."""
    plan = picked.plan
    output.print(
        plain(picked.answer, "bold"),
        *picked.doubts(),
        *titled(f"{found.n_runs} simulated flights, errors after {plan.t_end:.6g} s", found.table),
        note(f"by chance no ratio exceeds {found.greatest_ratio:.3f}"),
    )
    output.print(*promised(plan))
    if len(found.keep_outs):
        output.print(
            *titled("Sun inside keep-out cones", found.keep_outs),
            note("steered by the estimate, and flown open loop, of all flights"),
        )
    low, high = found.nees_bounds
    output.print(
        f"\nNEES per state {found.nees:.3f}; expected {low:.3f} to {high:.3f}",
        plain(_verdict(found), "bold"),
    )


def verification_document(picked: Picked, found: Verification, seed: int) -> dict[str, Any]:
    """The result as JSON values, with the problem and the design that it is about."""
    plan = picked.plan
    table = found.table.reset_index()
    low, high = found.nees_bounds
    return {
        "title": f"{found.n_runs} simulated flights of the plan with t_end {plan.t_end:.6g} s and "
        f"trace {plan.trace:.5g}, seed {seed}",
        "verdict": f"{_verdict(found)}; NEES per state {found.nees:.3f}, expected {low:.3f} to "
        f"{high:.3f}; by chance no ratio exceeds {found.greatest_ratio:.3f}{_cones(found)}",
        "columns": [str(name) for name in table.columns],
        "rows": table.to_numpy(object).tolist(),
        "solution": picked.solution,
        "answer": plan.answer,
        "problem": PROBLEM,
        "options": plan.problem.options(),
        "design": list(plan.design),
        "achieved": bool(found.achieved),
        "keep_outs": rows(found.keep_outs),
        "promises": rows(plan.promises()),
    }


def _cones(found: Verification) -> str:
    """How often cones were broken, in words."""
    parts = []
    for name, row in found.keep_outs.iterrows():
        ways = ", ".join(
            f"{row[f'{way}: flights [%]']:.3g} % of flights ({row[f'{way}: time [%]']:.3g} % of "
            f"the time) {way}"
            for way in ("steered", "open loop")
        )
        parts.append(f"; Sun inside {name} in {ways}")
    return "".join(parts)


def _verdict(found: Verification) -> str:
    if found.worse:
        return f"not achieved: worse than promised in {', '.join(found.worse)}"
    if not found.achieved:
        return "not achieved: the filter is surer than its errors allow"
    if found.nees < found.nees_bounds[0]:
        return "achieved; the filter is less sure than it might be"
    return "achieved"
