"""The front of a small run of the paper's algorithm on the paper's preset, stored."""

from pathlib import Path

import pandas as pd

from mgeo.runs.prepare import prepare_run

KEPT = Path(__file__).parent / "reference" / "paper-front.csv"


def test_the_front_of_a_small_run_of_the_papers_preset_has_not_changed():
    run = prepare_run(
        "attitude",
        {"preset": "paper"},
        algorithm="mgeo-real",
        evaluations=1200,
        initial_designs=None,
        refine=None,
    )
    found = run.solve()
    columns = [*found.variables, *found.objectives]
    front = pd.DataFrame([[*x, *f] for x, f in zip(found.X, found.F, strict=True)], columns=columns)
    kept = pd.read_csv(KEPT, dtype=str).map(float)  # exact, with any pandas
    # traces may differ in the last digits from processor to processor
    pd.testing.assert_frame_equal(front[columns[:-1]], kept[columns[:-1]], check_exact=True)
    pd.testing.assert_series_equal(front[columns[-1]], kept[columns[-1]], rtol=1e-9)
    assert list(kept) == columns
