"""Comparison of three initial attitudes for the page on scenarios, from the stored fronts."""

from pathlib import Path

import numpy as np
import pandas as pd
from IPython.display import Markdown
from mgeo_attitude import AttitudeManeuverProblem, Scenario

DOCS = Path(__file__).parent.parent
#: Shortest plan of the comparison [s].
_MIN_TIME = 500.0


def describe_differences() -> Markdown:
    """Describe how much front and plans depend on the initial attitude."""
    problems = {
        "free": AttitudeManeuverProblem(Scenario.cubesat_6u()),
        "nadir": AttitudeManeuverProblem(Scenario.from_toml(DOCS / "scenarios/nadir.toml")),
        "sun": AttitudeManeuverProblem(Scenario.from_toml(DOCS / "scenarios/sun.toml")),
    }
    n_var = problems["free"].n_var
    fronts = {name: pd.read_csv(DOCS / f"fronts/{name}.csv").to_numpy() for name in problems}
    times = np.arange(_MIN_TIME, 6000.0, 10.0)
    traces = [
        [front[front[:, n_var] <= time, n_var + 1].min() for time in times]
        for front in fronts.values()
    ]
    difference = (np.max(traces, axis=0) / np.min(traces, axis=0)).max() - 1.0
    increases = []
    for own, front in fronts.items():
        plans = front[front[:, n_var] >= _MIN_TIME]
        for other in problems.keys() - {own}:
            F = problems[other].evaluate(plans[:, :n_var], return_values_of=["F"])
            increases.append(np.median(F[:, 1] / plans[:, n_var + 1]) - 1.0)
    increase = f"{100.0 * min(increases):.0f} to {100.0 * max(increases):.0f} %"
    return Markdown(
        f"From {_MIN_TIME:.0f} s on, the smallest traces of the three fronts differ by at most "
        f"{100.0 * difference:.0f} %. A single plan depends more on the initial attitude. If a "
        f"plan of at least {_MIN_TIME:.0f} s is executed from another of the three attitudes, its "
        f"trace increases. The median over the plans of a front is {increase}, depending on both "
        "attitudes."
    )
