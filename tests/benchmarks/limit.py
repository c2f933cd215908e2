"""``python -m tests.benchmarks.limit PLANS [SEED [STEP]]``: random plans held against the limit.

So many plans, of 1 to 12 maneuvers, over every preset, scenario file and the hard ones of
`tests.attitude.bound.plans`, at all times. One below the limit ends it with an error. With a step
[s] of 1 the scenarios are as they are.
"""

from __future__ import annotations

import sys

import numpy as np
from mgeo_attitude import FilterModel, limit

from tests.attitude.bound.plans import (
    documented,
    hard,
    least_ratios,
    random_plans,
    without_albedo,
)

ROUNDING = 1e-9
#: Plans of a batch: their histories are in memory together.
BATCH = 240


def main(plans: int, seed: int = 1, step: float = 20.0) -> None:
    """Print the least ratios of each scenario."""
    scenarios = documented(None) if step == 1.0 else documented(step) | hard(step)
    rng = np.random.default_rng(seed)
    for name, scenario in scenarios.items():
        if name == "photodiodes.toml":  # with light from the Earth it has no limit
            scenario = without_albedo(scenario)
        model = FilterModel.from_scenario(scenario)
        found, least, done = limit(scenario, model), dict[str, float](), 0
        while done < plans / len(scenarios):
            for batch in random_plans(scenario, rng, BATCH):
                done += len(batch)
                for what, ratio in least_ratios(model, found, batch, threads=2).items():
                    least[what] = min(ratio, least.get(what, np.inf))
        nearest = min(least, key=lambda what: least[what])
        print(
            f"{name}: {done} plans, trace {least['trace']:.3f}, ending {least['ending']:.3f}, "
            f"nearest {nearest} 1 {least[nearest] - 1.0:+.1e}",
            flush=True,
        )
        below = {what: ratio for what, ratio in least.items() if not ratio >= 1.0 - ROUNDING}
        if below:
            raise SystemExit(f"{name}: below the limit: {below}")


if __name__ == "__main__":
    arguments = sys.argv[1:]
    main(*map(int, arguments[:2]), *map(float, arguments[2:]))
