"""Compare optimized plans with single-axis sequences, for the table of docs/how-to/better-plans.md.

Run ``python -m tests.benchmarks.baselines`` in the root of the repository. It solves two scenarios,
which takes one to two minutes each.
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
from .pages import DOCS, format_table, write_table

PRESETS, SEED = ("paper", "cubesat_6u"), 1
PICKS = ("min-time", "knee", "min-trace")
SEQUENCES = ("x, y, z sequence", "x, y, z sequence, both directions")

#: Baselines with nearly the same result as rotations about z.
OMITTED_BASELINES = ("x only", "y only")
#: Total maneuver times of the single-axis sequences [s].
SEQUENCE_DURATIONS = (300.0, 600.0, 900.0, 1200.0, 1800.0, 2400.0, 3600.0, 6000.0)


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
        parts.append(
            "\n\n".join([heading, compare_at_equal_durations(front), compare_with_front(front)])
        )
    print(*parts, sep="\n\n")
    write_table(DOCS / "how-to/better-plans.md", "baselines", parts[0])


def compare_at_equal_durations(front: Front) -> str:
    """Return a table that compares plans of the front with baselines of the same maneuver time."""
    plans = [front.select_plan(pick) for pick in PICKS]
    tables = [plan.compare_with_designs() for plan in plans]
    columns = [f"{pick}, {plan.t_end:.0f} s" for pick, plan in zip(PICKS, plans, strict=True)]
    rows = [
        [name, *(_format_ratio(table.loc[name, "trace [-]"], table) for table in tables)]
        for name in tables[0].index
        if name not in OMITTED_BASELINES
    ]
    return format_table(["trace, or ratio to the trace of the plan", *columns], rows)


def compare_with_front(front: Front) -> str:
    """Return a sentence that compares single-axis sequences with the front."""
    problem = front.problem
    ratios, better = [], []
    for time in SEQUENCE_DURATIONS:
        designs = build_baselines(problem.scenario, time)
        for name in SEQUENCES:
            result = evaluate(problem.model, np.array([designs[name]]))
            t_end, trace = result.t_end[0], result.trace[0]
            front_traces = front.F[front.F[:, 0] <= t_end, 1]
            best = front_traces.min() if front_traces.size else np.inf
            ratios.append(trace / best)
            if best > trace:
                better.append(f"{name} for {time:.0f} s")
    n_worse = len(ratios) - len(better)
    shortest, longest = min(SEQUENCE_DURATIONS), max(SEQUENCE_DURATIONS)
    return (
        "The table compares maneuvers at the t_end of a plan. A sequence has a t_end of its own by "
        f"the rule `trace`. At this time, {n_worse} of {len(ratios)} sequences of "
        f"{shortest:.0f} to {longest:.0f} s have a larger trace than the front. "
        f"The ratio of the traces is {min(ratios):.2f} to {max(ratios):.2f}."
        + (f" Better than the front: {', '.join(better)}." if better else "")
    )


def _format_ratio(trace: float, table: object) -> str:
    """Format the trace of the plan itself, or the ratio of another trace to this trace."""
    ratio = trace / table.loc["plan", "trace [-]"]  # type: ignore[attr-defined]
    return f"{trace:.2e}" if ratio == 1.0 else f"{float(f'{ratio:.3g}'):g} ×"


if __name__ == "__main__":
    main()
