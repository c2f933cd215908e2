"""``mgeo-attitude verify``."""

from __future__ import annotations

from rich.text import Text

from ..plan import ManeuverPlan
from ..plan.verification import Verification, verify
from .tables import console, printed


def print_verification(plan: ManeuverPlan, n_runs: int, seed: int) -> bool:
    """Fly a plan, print how it went, and return whether it achieves what it promises."""
    found = verify(plan, n_runs, seed)
    out = console()
    title = f"{n_runs} simulated flights, errors after {plan.t_end:.6g} s"
    printed(out, title, found.table)
    out.print(f"by chance no ratio exceeds {found.greatest_ratio:.3f}", style="dim")
    low, high = found.nees_bounds
    out.print(Text(f"\nNEES per state {found.nees:.3f}; expected {low:.3f} to {high:.3f}"))
    out.print(Text(_verdict(found), style="bold"))
    return found.achieved


def _verdict(found: Verification) -> str:
    if found.worse:
        return f"not achieved: worse than promised in {', '.join(found.worse)}"
    if not found.achieved:
        return "not achieved: the filter is surer than its errors allow"
    if found.nees < found.nees_bounds[0]:
        return "achieved; the filter is less sure than it might be"
    return "achieved"
