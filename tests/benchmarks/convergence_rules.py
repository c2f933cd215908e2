"""Compare convergence rules in Monte Carlo runs, for docs/validation/robustness.md.

``python -m tests.benchmarks.convergence_rules`` searches nominal plans of each preset by each
convergence rule. docs/convergence_rules.jsonl has a line for each preset and rule: CPU time, and
the ratio of the 0.9-quantile over 200 Monte Carlo runs to the predicted value, for each objective
and plan. A search that is already in the file is not repeated.
"""

from __future__ import annotations

import dataclasses
import time
from typing import Any

import numpy as np
from mgeo_attitude import AttitudeManeuverProblem
from pymoo.optimize import minimize

from mgeo import MGEODirected

from ..three import three
from .pages import DOCS, add_result, read_results
from .robust import EVALUATION_SEED, PRESETS

DATA = DOCS / "convergence_rules.jsonl"
N_EVALUATIONS, SEED = 20_000, 1
#: Number of plans of each front, evenly distributed over the front.
N_PLANS = 50
#: Required 1-sigmas of the rule "required". Most plans of a front can reach them.
REQUIRED = {
    "paper": {"attitude_deg": 0.15, "gyro.bias_deg_h": 3.0, "mag.bias_nt": 30.0},
    "cubesat_6u": {"attitude_deg": 0.4, "gyro.bias_deg_h": 6.0, "mag.bias_nt": 60.0},
}
RULES: dict[str, dict[str, Any]] = {
    "trace": {},
    "settling": {"factor": 1.25},
    "required": {},
    "end": {},
}


def build_problem(preset: str, rule: str) -> AttitudeManeuverProblem:
    """Return the problem of a preset with three maneuvers and a convergence rule."""
    scenario = three(preset)
    convergence = dataclasses.replace(scenario.convergence, rule=rule, **RULES[rule])
    required = REQUIRED[preset] if rule == "required" else scenario.required_sigma
    return AttitudeManeuverProblem(
        dataclasses.replace(scenario, convergence=convergence, required_sigma=required)
    )


def evaluate_rule(preset: str, rule: str) -> dict[str, Any]:
    """Run a search and return its result as a dict that becomes a line of the file."""
    problem = build_problem(preset, rule)
    start = time.process_time()
    X = minimize(problem, MGEODirected(), ("n_eval", N_EVALUATIONS), seed=SEED).X
    seconds = time.process_time() - start
    X = X[np.unique(np.linspace(0, len(X) - 1, N_PLANS).round().astype(int))]
    ratios = (
        problem.view(X)
        .compare_with_monte_carlo(seed=EVALUATION_SEED)
        .filter(regex="^Monte Carlo / ")
        .to_numpy()
    )
    return {
        "key": [preset, rule],
        "processor_s": round(seconds, 1),
        "t_end": ratios[:, 0].round(4).tolist(),
        "trace": ratios[:, 1].round(4).tolist(),
    }


def main() -> None:
    stored = [each["key"] for each in read_results(DATA)]
    for preset in PRESETS:
        for rule in RULES:
            if [preset, rule] not in stored:
                add_result(DATA, evaluate_rule(preset, rule))


if __name__ == "__main__":
    main()
