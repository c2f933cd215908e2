"""Ratio of the best plans to the lower bound, for searches with and without local refinement.

``python docs/studies/near.py PRESET RULE MODE SEED`` makes a run and adds a row to data/near.csv.
``python docs/studies/near.py`` prints the medians over seeds.

``python docs/studies/near.py PRESET RULE TIME COUNT RATE`` refines many plans for a single end time
[s] and prints the ratio of the best trace to the lower bound, and quantiles of the traces of all
plans relative to the best trace. The plans have COUNT maneuvers with rates up to RATE [deg/s], by
default ten maneuvers with the rate of the preset.
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
#: Fronts of seed 1 with the rule "end", for the figure.
FRONTS = Path(__file__).parents[1] / "fronts" / "near.csv"
#: Smallest ratio of the times of neighboring points in the figure.
DENSE = 1.02
TIMES = (300, 500, 700, 900, 1000, 1560, 2785, 4394)

#: Numbers of maneuvers, evaluations and initial designs, and whether the front is refined. The
#: first mode is the default for three maneuvers.
MODES = {
    "search": (3, 59_760, 0, False),
    "longer": (3, 160_000, 0, False),
    "three": (3, 6_000, 12, True),
    "six": (6, 6_000, 12, True),
    "ten": (10, 6_000, 12, True),
}


def compute_ratios(F, bound):
    """Return the ratio of the best trace until each time to the smallest lower bound until then.

    The lower bound can increase with time, for example in eclipse.
    """
    step, ratios, least_bound = bound.times[1], {}, np.minimum.accumulate(bound.trace_at_end)
    for time_limit in (*TIMES, F[:, 0].max()):
        earlier = F[F[:, 0] <= time_limit]
        name = "longest" if time_limit == F[:, 0].max() else str(time_limit)
        least = least_bound[round(time_limit / step)]
        ratios[name] = earlier[:, 1].min() / least if len(earlier) else np.nan
    return ratios


def measure_run(preset, rule, mode, seed):
    """Return computing times, hypervolume and ratios to the lower bound of a run, and its front."""
    count, evaluations, n_initial_designs, refine = MODES[mode]
    options = {"preset": preset, "maneuvers": {"count": count}, "convergence": {"rule": rule}}
    run = prepare_run(
        "attitude",
        options,
        evaluations=evaluations,
        seed=seed,
        initial_designs=n_initial_designs,
        refine=refine,
    )
    run.problem.evaluate(run.problem.xu[None])  # Excludes tables and compilation from the times.
    wall, cpu = time.perf_counter(), time.process_time()
    outcome = run.solve()
    times = {"cpu_s": time.process_time() - cpu, "wall_s": time.perf_counter() - wall}
    result = {"longest_s": outcome.F[:, 0].max(), "hypervolume": outcome.hypervolume}
    return times | result | compute_ratios(outcome.F, run.problem.lower_bound), outcome.F


def thin_front(F):
    """Return the points of a front that differ visibly in a figure."""
    rows = [0]
    for row in range(1, len(F)):
        if F[row, 0] >= DENSE * F[rows[-1], 0]:
            rows.append(row)
    return F[rows]


def refine_many_plans(preset, rule, time, count=10, rate=None, n_plans=300, seed=1):
    """Return the ratio of the best trace to the lower bound, and of all traces to the best one.

    The traces are those at a time [s]. With the rule "trace", the plans maneuver until one
    averaging window before the end, and the best plans end with a constant rate.
    """
    maneuvers = {"count": count} | ({} if rate is None else {"max_rate_deg_s": rate})
    options = {"preset": preset, "maneuvers": maneuvers, "convergence": {"rule": rule}}
    problem = AttitudeManeuverProblem(Scenario.from_dict(options))
    exact = build_fixed_time_evaluator(problem)
    bound = np.minimum.accumulate(problem.lower_bound.trace_at_end)
    step, longest = exact.model.step, exact.scenario.maneuvers.max_duration
    until = time - (rule == "trace") * exact.model.window_steps * step
    thinned = ThinnedSamples(exact).get_evaluator(until)
    initial = draw_initial_plans(thinned, count - (rule == "trace"), until, n_plans, seed)
    batches = np.array_split(initial, len(initial) // 40)
    plans = [descend(thinned, batch, until, 100) for batch in batches]
    plans = set_end_times(np.vstack(plans), until, longest)
    traces = np.exp(exact.evaluate_at_steps(plans, round(until / step))[0])
    best = descend(exact, plans[traces.argsort()[:6]], until, 30)
    if rule == "trace":
        F = np.vstack(
            [exact.evaluate_convergence(append_converging_rate(exact, each))[0] for each in best]
        )
        least = F[F[:, 0] <= time, 1].min(initial=np.inf)
    else:
        least = np.exp(exact.evaluate_at_steps(best, round(until / step))[0].min())
    return least / bound[round(time / step)], np.sort(traces) / traces.min()


def draw_initial_plans(evaluator, count, time, n_plans, seed):
    """Return random plans that end at a time [s], and plans of beam searches.

    Half of the random plans have the largest rate about each axis.
    """
    maneuvers = evaluator.scenario.maneuvers
    rng, max_rate = np.random.default_rng(seed), maneuvers.max_rate_deg_s
    durations = time * rng.dirichlet(np.full(count, 3.0), n_plans)
    rates = rng.uniform(-max_rate, max_rate, (n_plans, count, 3))
    rates[::2] = max_rate * np.sign(rates[::2])
    plans = [np.concatenate([rates, durations[:, :, None]], axis=2).reshape(n_plans, -1)]
    for n in range(count // 2, count + 1):
        for n_levels, width, length_ratio in ((2, 400, 1.0), (3, 100, 0.9), (3, 100, 0.8)):
            beam = beam_search(evaluator, n, time, n_levels, width, length_ratio)
            plans.append(split_maneuvers(beam[:: max(len(beam) // 8, 1)], count))
    return set_end_times(np.vstack(plans), time, maneuvers.max_duration)


def append(file, rows):
    existing = pd.read_csv(file) if file.exists() else pd.DataFrame()
    pd.concat([existing, rows]).to_csv(file, index=False, float_format="%.6g")


def table(rows):
    """Return the medians over seeds."""
    keys = ["preset", "rule", "mode"]
    return rows.drop(columns=["seed", "wall_s"]).groupby(keys).median().round(3)


def main(*given):
    if not given:
        print(table(pd.read_csv(DATA)).to_string())
        return
    preset, rule, mode, *more = given
    if mode not in MODES:
        best, ratios = refine_many_plans(
            preset, rule, float(mode), *map(int, more[:1]), *map(float, more[1:])
        )
        quantiles = np.quantile(ratios, [0.01, 0.05, 0.25, 0.5]).round(3)
        print(f"{best:.4f}, of {len(ratios)}", quantiles)
        return
    (seed,) = more
    row = {"preset": preset, "rule": rule, "mode": mode, "seed": int(seed)}
    values, F = measure_run(preset, rule, mode, int(seed))
    append(DATA, pd.DataFrame([row | values]))
    if rule == "end" and seed == "1":
        t_end, trace = thin_front(F).T
        points = {"preset": preset, "mode": mode, "t_end [s]": t_end, "trace [-]": trace}
        append(FRONTS, pd.DataFrame(points))


if __name__ == "__main__":
    main(*sys.argv[1:])
