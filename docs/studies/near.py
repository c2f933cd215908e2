"""How near fronts come to the limit: of three maneuvers by search alone, of more with a polish.

``python docs/studies/near.py PRESET RULE MODE SEED`` adds a row to data/near.csv, ``python
docs/studies/near.py`` prints medians. ``python docs/studies/near.py PRESET RULE TIME COUNT RATE``
prints how near the best of many plans of so many maneuvers up to a rate [deg/s] comes at a time
[s], each polished for it alone, and lower quantiles of what all know, of the best; of ten at the
preset's rate, if not told.
"""

import sys
import time
from pathlib import Path

import numpy as np
import pandas as pd
from mgeo_attitude import AttitudeManeuverProblem, Scenario
from mgeo_attitude.refine.descent import descend
from mgeo_attitude.refine.evaluators import build_fixed_time_evaluator, set_end_times
from mgeo_attitude.refine.initial_designs import append_converging_rate, beam_search
from mgeo_attitude.refine.splitting import split_maneuvers
from mgeo_attitude.refine.thinned_samples import ThinnedSamples

from mgeo.runs.prepare import prepare_run

DATA = Path(__file__).parent / "data" / "near.csv"
#: Fronts of seed 1 by the rule "end", for the figure.
FRONTS = Path(__file__).parents[1] / "fronts" / "near.csv"
#: Ratio of times below which one of two points of a front is enough for it.
DENSE = 1.02
TIMES = (300, 500, 700, 900, 1000, 1560, 2785, 4394)

#: Maneuvers, evaluations, starts, and whether fronts are polished. The first is the default of
#: three maneuvers.
MODES = {
    "search": (3, 59_760, 0, False),
    "longer": (3, 160_000, 0, False),
    "three": (3, 6_000, 12, True),
    "six": (6, 6_000, 12, True),
    "ten": (10, 6_000, 12, True),
}


def ratios(F, curves):
    """What the best plan over by each time knows, of the least limit until then.

    In eclipse a limit rises: less is known than before.
    """
    step, found, limit = curves.times[1], {}, np.minimum.accumulate(curves.trace_at_end)
    for at in (*TIMES, F[:, 0].max()):
        over = F[F[:, 0] <= at]
        name = "longest" if at == F[:, 0].max() else str(at)
        least = limit[round(at / step)]
        found[name] = over[:, 1].min() / least if len(over) else np.nan
    return found


def measured(preset, rule, mode, seed):
    """Seconds of the processors, hypervolume and ratios to the limit; and the front."""
    count, evaluations, starts, polish = MODES[mode]
    options = {"preset": preset, "maneuvers": {"count": count}, "convergence": {"rule": rule}}
    run = prepare_run(
        "attitude",
        options,
        evaluations=evaluations,
        seed=seed,
        initial_designs=starts,
        refine=polish,
    )
    run.problem.evaluate(run.problem.xu[None])  # tables and compiler are not counted
    wall, cpu = time.perf_counter(), time.process_time()
    found = run.solve()
    spent = {"cpu_s": time.process_time() - cpu, "wall_s": time.perf_counter() - wall}
    last = {"longest_s": found.F[:, 0].max(), "hypervolume": found.hypervolume}
    return spent | last | ratios(found.F, run.problem.lower_bound), found.F


def thinned(F):
    """Points of a front for a figure."""
    rows = [0]
    for row in range(1, len(F)):
        if F[row, 0] >= DENSE * F[rows[-1], 0]:
            rows.append(row)
    return F[rows]


def best_known(preset, rule, time, count=10, rate=None, starts=300, seed=1):
    """What the best of many plans knows at a time [s], of the limit; and all, of the best.

    By the rule "trace" they learn until a window before, and the best hold a rate until then.
    """
    maneuvers = {"count": count} | ({} if rate is None else {"max_rate_deg_s": rate})
    options = {"preset": preset, "maneuvers": maneuvers, "convergence": {"rule": rule}}
    problem = AttitudeManeuverProblem(Scenario.from_dict(options))
    exact, limit = (
        build_fixed_time_evaluator(problem),
        np.minimum.accumulate(problem.lower_bound.trace_at_end),
    )
    step, longest = exact.model.step, exact.scenario.maneuvers.max_duration
    until = time - (rule == "trace") * exact.model.window_steps * step
    at = ThinnedSamples(exact).get_evaluator(until)
    begins = begun_anyhow(at, count - (rule == "trace"), until, starts, seed)
    plans = [descend(at, some, until, 100) for some in np.array_split(begins, len(begins) // 40)]
    plans = set_end_times(np.vstack(plans), until, longest)
    known = np.exp(exact.evaluate_at_steps(plans, round(until / step))[0])
    best = descend(exact, plans[known.argsort()[:6]], until, 30)
    if rule == "trace":
        F = np.vstack(
            [exact.evaluate_convergence(append_converging_rate(exact, each))[0] for each in best]
        )
        least = F[F[:, 0] <= time, 1].min(initial=np.inf)
    else:
        least = np.exp(exact.evaluate_at_steps(best, round(until / step))[0].min())
    return least / limit[round(time / step)], np.sort(known) / known.min()


def begun_anyhow(at, count, time, number, seed):
    """So many random plans of a time [s], half of them as fast as they may be; and of beams."""
    rng, greatest = np.random.default_rng(seed), at.scenario.maneuvers.max_rate_deg_s
    durations = time * rng.dirichlet(np.full(count, 3.0), number)
    rates = rng.uniform(-greatest, greatest, (number, count, 3))
    rates[::2] = greatest * np.sign(rates[::2])
    plans = [np.concatenate([rates, durations[:, :, None]], axis=2).reshape(number, -1)]
    for n in range(count // 2, count + 1):
        for levels, width, shorter in ((2, 400, 1.0), (3, 100, 0.9), (3, 100, 0.8)):
            found = beam_search(at, n, time, levels, width, shorter)
            plans.append(split_maneuvers(found[:: max(len(found) // 8, 1)], count))
    return set_end_times(np.vstack(plans), time, at.scenario.maneuvers.max_duration)


def append(file, rows):
    known = pd.read_csv(file) if file.exists() else pd.DataFrame()
    pd.concat([known, rows]).to_csv(file, index=False, float_format="%.6g")


def table(rows):
    """Medians over seeds."""
    keys = ["preset", "rule", "mode"]
    return rows.drop(columns=["seed", "wall_s"]).groupby(keys).median().round(3)


def main(*given):
    if not given:
        print(table(pd.read_csv(DATA)).to_string())
        return
    preset, rule, mode, *more = given
    if mode not in MODES:
        best, ends = best_known(
            preset, rule, float(mode), *map(int, more[:1]), *map(float, more[1:])
        )
        print(f"{best:.4f}, of {len(ends)}", np.quantile(ends, [0.01, 0.05, 0.25, 0.5]).round(3))
        return
    (seed,) = more
    row = {"preset": preset, "rule": rule, "mode": mode, "seed": int(seed)}
    values, F = measured(preset, rule, mode, int(seed))
    append(DATA, pd.DataFrame([row | values]))
    if rule == "end" and seed == "1":
        t_end, trace = thinned(F).T
        points = {"preset": preset, "mode": mode, "t_end [s]": t_end, "trace [-]": trace}
        append(FRONTS, pd.DataFrame(points))


if __name__ == "__main__":
    main(*sys.argv[1:])
