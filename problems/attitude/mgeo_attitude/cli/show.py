"""``mgeo-attitude show``."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
from rich.console import Console
from rich.text import Text

from ..figures.page import page
from ..files import write_text
from ..plan import ManeuverPlan
from ..plan.figures import plan_figures
from .tables import console, printed


def print_plan(plan: ManeuverPlan) -> None:
    """Print everything that fits a terminal."""
    out = console()
    _print_summary(out, plan)
    _print_constraints(out, plan)
    printed(out, "Timeline", _timeline(plan).T, digits=6)
    printed(out, "Predicted 1-sigma", plan.accuracy())
    printed(out, "What each phase bought", _gains(plan).T)
    out.print("trace and worst body axis at its end", style="dim")
    printed(out, "Least observable directions", plan.least_observable(5).iloc[:, :2], digits=3)
    out.print("remaining: 1-sigma along it over the initial one; 1 is nothing learned", style="dim")
    title = f"Beside plans that need no optimizer, after {plan.t_end:.6g} s"
    printed(out, title, _others(plan).T)
    out.print("1-sigma of the worst body axis; t_end: when each by itself converges", style="dim")


def write_figures(plan: ManeuverPlan, path: Path) -> None:
    """Write `plan_figures` as one page."""
    write_text(path, page(list(plan_figures(plan).values()), f"plan, {plan.scenario.name}"))


def _print_summary(out: Console, plan: ManeuverPlan) -> None:
    ended = "converged" if plan.history.converged else "not converged at the end of the run,"
    orbits = plan.t_end / plan.scenario.orbit.period
    out.print(
        Text(
            f"scenario {plan.scenario.name}: {ended} at {plan.t_end:.6g} s ({orbits:.3f} orbits), "
            f"trace {plan.trace:.4g}"
        )
    )


def _print_constraints(out: Console, plan: ManeuverPlan) -> None:
    table = plan.constraints()
    if len(table):
        words = table["kept"].map({True: "kept", False: "violated"})
        printed(out, "Constraints", table.assign(kept=words))


def _timeline(plan: ManeuverPlan) -> pd.DataFrame:
    table = plan.timeline().set_index("phase")
    rates = [f"rate {axis} [deg/s]" for axis in "xyz"]
    attitude = [f"end q{part}" for part in "123c"]
    names = ["start UTC", "start [s]", "duration [s]", *rates, "swept [deg]", *attitude]
    return table[names]


def _gains(plan: ManeuverPlan) -> pd.DataFrame:
    table = plan.gains()
    worst = table.iloc[:, :3].copy()
    sigmas = table.iloc[:, 3:]
    for first in range(0, sigmas.shape[1], 3):
        name = str(sigmas.columns[first]).replace(" x [", " [")
        worst[name] = np.max(sigmas.iloc[:, first : first + 3].to_numpy(float), axis=1)
    return worst


def _others(plan: ManeuverPlan) -> pd.DataFrame:
    table = plan.compare()
    short = {name: name.replace(" 1-sigma [", " [") for name in table.columns}
    return table.rename(columns=short | {"times the first [-]": "times the plan's [-]"})
