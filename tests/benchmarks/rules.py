"""``python -m tests.benchmarks.rules SEEDS``: the rules of convergence, in docs/robust.md.

For each preset and rule, plans found as if they were flown exactly, and what flights keep of them.
Run it in the repository's root.
"""

from __future__ import annotations

import dataclasses
import sys
import time
from collections.abc import Iterator

import numpy as np
from mgeo_attitude import AttitudeManeuverProblem
from mgeo_attitude.view.plans import spread
from pymoo.optimize import minimize

from mgeo import MGEODirected

from ..three import three
from .consistency_document import with_table
from .robust import JUDGES, PRESETS, ROOT

PAGE = ROOT / "docs" / "robust.md"
#: What is required, of each preset within reach of most plans of its front.
REQUIRED = {
    "paper": {"attitude_deg": 0.15, "gyro.bias_deg_h": 3.0, "mag.bias_nt": 30.0},
    "cubesat_6u": {"attitude_deg": 0.4, "gyro.bias_deg_h": 6.0, "mag.bias_nt": 60.0},
}
RULES = {
    "trace": {},
    "settling": {"rule": "settling", "factor": 1.25},
    "required": {"rule": "required"},
}


def row(preset: str, rule: str, seeds: int) -> str:
    """A row of the table: all plans of the fronts of some seeds."""
    scenario = three(preset)
    convergence = dataclasses.replace(scenario.convergence, **RULES[rule])
    if rule == "required":
        scenario = dataclasses.replace(scenario, required_sigma=REQUIRED[preset])
    problem = AttitudeManeuverProblem(dataclasses.replace(scenario, convergence=convergence))
    ratios, spent = [], 0.0
    for seed in range(1, seeds + 1):
        start = time.process_time()
        X = minimize(problem, MGEODirected(), ("n_eval", 20_000), seed=seed).X
        spent += time.process_time() - start
        X = X[spread(len(X))]
        table = problem.view(X).promises(seed=JUDGES)
        ratios.append(table["kept / promised t_end [s]"].to_numpy())
    ratio = np.concatenate(ratios)
    late = (ratio > 1.2).mean()
    return (
        f"| {preset} | `{rule}` | {np.median(ratio):.2f} | {np.quantile(ratio, 0.9):.2f} "
        f"| {ratio.max():.2f} | {100.0 * late:.0f} % "
        f"| {spent / seeds:.0f} |"
    )


def rows(seeds: int) -> Iterator[str]:
    """The table."""
    yield (
        "| preset | rule | kept / predicted t_end: median | 0.9-quantile | greatest "
        "| more than 20 % late | CPU time [s] |"
    )
    yield "| --- | --- | ---: | ---: | ---: | ---: | ---: |"
    for preset in PRESETS:
        for rule in RULES:
            yield row(preset, rule, seeds)


def main() -> None:
    """Write the table into the page."""
    lines = []
    for line in rows(int(sys.argv[1])):
        print(line, flush=True)
        lines.append(line)
    text = with_table(PAGE.read_text(encoding="utf-8"), "rules", "\n".join(lines))
    PAGE.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
