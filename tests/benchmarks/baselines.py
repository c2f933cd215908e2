"""Compare optimized plans with single-axis sequences, for the table of docs/plans.md.

    python -m tests.benchmarks.baselines

Run it in the repository's root; it solves two scenarios, which takes a minute or two each.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from mgeo_attitude import AttitudeManeuverProblem, evaluate
from mgeo_attitude.plan import Front
from mgeo_attitude.view.observability.improvements import build_baselines

from mgeo.runs.prepare import prepare_run
from mgeo.runs.registry import DEFAULT_ALGORITHM

from ..three import three
from .pages import DOCS, markdown, write_table

PRESETS, SEED = ("paper", "cubesat_6u"), 1
PICKS = ("fastest", "knee", "best")
SWEEPS = ("x, y, z sequence", "x, y, z sequence, both directions")

#: Turns about one axis that leave as much as those about z.
ALIKE = ("x only", "y only")
#: Times for all maneuvers of a sweep [s].
SWEEP_TIMES = (300.0, 600.0, 900.0, 1200.0, 1800.0, 2400.0, 3600.0, 6000.0)


def main() -> None:
    parts = []
    for name in PRESETS:
        problem = AttitudeManeuverProblem(three(name))
        outcome = prepare_run(
            "attitude", problem.to_options(), algorithm=DEFAULT_ALGORITHM, seed=SEED
        ).solve()
        front = Front(Path(name), problem, outcome.X, outcome.F)
        heading = (
            f"**`{name}`**: {len(outcome.F)} plans of {DEFAULT_ALGORITHM}, seed {SEED}, "
            f"{outcome.n_evaluations:,} evaluations."
        )
        parts.append("\n\n".join([heading, same_time(front), on_its_own_terms(front)]))
    print(*parts, sep="\n\n")
    write_table(DOCS / "plans.md", "measured tables", parts[0])


def same_time(front: Front) -> str:
    """Plans of the front beside baselines with as long maneuvers, after the plan's own time."""
    plans = [front.select_plan(pick) for pick in PICKS]
    tables = [plan.compare_with_designs() for plan in plans]
    columns = [f"{pick}, {plan.t_end:.0f} s" for pick, plan in zip(PICKS, plans, strict=True)]
    rows = [
        [name, *(_compared(table.loc[name, "trace [-]"], table) for table in tables)]
        for name in tables[0].index
        if name not in ALIKE
    ]
    return markdown(["trace, or times that of the plan", *columns], rows)


def on_its_own_terms(front: Front) -> str:
    """Sweeps as points (t_end, trace), and the best that the front has by that time."""
    problem = front.problem
    ratios, better = [], []
    for time in SWEEP_TIMES:
        designs = build_baselines(problem.scenario, time)
        for name in SWEEPS:
            result = evaluate(problem.model, np.array([designs[name]]))
            t_end, trace = result.t_end[0], result.trace[0]
            sooner = front.F[front.F[:, 0] <= t_end, 1]
            best = sooner.min() if sooner.size else np.inf
            ratios.append(trace / best)
            if best > trace:
                better.append(f"{name} for {time:.0f} s")
    return (
        f"Of {len(ratios)} sweeps of {SWEEP_TIMES[0]:.0f} to {SWEEP_TIMES[-1]:.0f} s, each at its "
        f"own t_end, the front has a smaller trace by then than {len(ratios) - len(better)}; they "
        f"leave {min(ratios):.2f} to {max(ratios):.2f} times its trace."
        + (f" Better than the front: {', '.join(better)}." if better else "")
    )


def _compared(trace: float, table: object) -> str:
    ratio = trace / table.loc["plan", "trace [-]"]  # type: ignore[attr-defined]
    return f"{trace:.2e}" if ratio == 1.0 else f"{float(f'{ratio:.3g}'):g} ×"


if __name__ == "__main__":
    main()
