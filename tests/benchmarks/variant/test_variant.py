"""The experiments themselves: cut at the right evaluation, resumable, and set out rightly."""

import numpy as np
import pandas as pd
import pytest
from pymoo.problems.multi import ZDT1

from mgeo.studies.statistics import holm, mann_whitney

from . import everything, record, spaces, tables

RUN = ("zdt1", "mgeo-directed:n_walkers=3", "raw")


def test_a_run_is_recorded_once_and_the_same_again(tmp_path):
    path = tmp_path / "runs.csv"
    assert record.record(path, *RUN, [1, 2], 300, 60.0) == 2
    first = record.read(path)
    assert [(row["seed"], row["evaluations"]) for row in first] == [("1", "300"), ("2", "300")]
    assert record.record(path, *RUN, [1, 2, 3], 300, 60.0) == 1
    again = tmp_path / "again.csv"
    record.record(again, *RUN, [2], 300, 60.0)
    assert record.read(again)[0]["hypervolume"] == first[1]["hypervolume"]


@pytest.mark.parametrize("name", ["mgeo-directed", "moead"])
def test_a_longer_run_begins_as_a_shorter_one_alone(name):
    problem = spaces.Watched(ZDT1(n_var=5))
    (short,) = record.runs(name, problem, [2], 150)
    together = list(record.runs(name, problem, [1, 2], 400))
    assert short.shape == (150, 2)
    assert np.array_equal(short, together[1][:150])


class Shifted(ZDT1):
    def indicator_space(self, F):
        return F + 100.0


def test_the_indicator_form_changes_what_the_algorithm_sees_and_not_what_is_kept():
    problem = spaces.Watched(Shifted(n_var=4), "indicator")
    X = np.random.default_rng(0).random((5, 4))
    F = problem.evaluate(X)
    assert np.array_equal(F, problem.seen[0] + 100.0)
    assert np.array_equal(problem.seen[0], ZDT1(n_var=4).evaluate(X))


def test_hypervolume_of_a_known_front_is_exact():
    scale = spaces.Scale(ZDT1())
    value, points = scale.hypervolume(np.array([[0.5, 0.5], [0.6, 0.6], [0.0, 1.0]]))
    assert value == pytest.approx(0.6 * 0.6 + 0.5 * 0.1)
    assert points == 2


def test_the_better_form_of_each_rival_counts():
    rng = np.random.default_rng(1)
    rows = []
    means = {("mgeo-directed", "raw"): 0.9, ("nsga2", "raw"): 0.7, ("nsga2", "indicator"): 0.8}
    for (algorithm, space), mean in {**means, ("gde3", "raw"): 0.85}.items():
        for seed in range(8):
            value = mean + 0.01 * rng.standard_normal()
            rows.append(("attitude", algorithm, space, seed, 5000, value))
    columns = ["problem", "algorithm", "space", "seed", "evaluations", "hypervolume"]
    table = pd.DataFrame(rows, columns=columns)
    header, nsga2, gde3 = tables.against(table, 5000)
    assert header[0].startswith("mgeo-directed 0.9")
    assert (nsga2[:2], gde3[:2]) == (["nsga2", "indicator"], ["gde3", "raw"])
    ours = tables.values(table, "mgeo-directed", "raw", 5000)
    p = [
        mann_whitney(ours, tables.values(table, *form, 5000))
        for form in (("nsga2", "indicator"), ("gde3", "raw"))
    ]
    assert [float(nsga2[-1]), float(gde3[-1])] == pytest.approx(holm(p), rel=0.05)


def test_tables_stand_between_their_marks():
    text = "a\n<!-- x -->\nold\n<!-- end -->\nb\n"
    filled = tables.fill(text, {"x": r"new \1"})
    assert filled == "a\n<!-- x -->\nnew \\1\n<!-- end -->\nb\n"
    assert tables.fill(filled, {"x": r"new \1"}) == filled
    with pytest.raises(ValueError, match="y --> stands 0 times"):
        tables.fill(text, {"y": ""})


def test_every_rival_runs_on_both_forms_with_all_seeds():
    runs = [
        (each.algorithm, each.space, seed)
        for each in everything.wanted()
        if each.part == "rivals"
        for seed in each.seeds
    ]
    more = everything.MORE_SEEDS - everything.SEEDS
    assert len(runs) == len(set(runs)) == 2 * everything.SEEDS * len(tables.RIVALS) + more
