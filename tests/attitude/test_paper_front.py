"""Front of a small run of the paper's algorithm with the paper's preset, against a stored front."""

from pathlib import Path

import pandas as pd

from mgeo.runs.prepare import prepare_run

REFERENCE = Path(__file__).parent / "reference" / "paper-front.csv"


def test_front_of_small_paper_run_equals_reference():
    run = prepare_run(
        "attitude",
        {"preset": "paper"},
        algorithm="mgeo-real",
        evaluations=1200,
        initial_designs=None,
        refine=None,
    )
    outcome = run.solve()
    columns = [*outcome.variables, *outcome.objectives]
    front = pd.DataFrame(
        [[*x, *f] for x, f in zip(outcome.X, outcome.F, strict=True)], columns=columns
    )
    reference = pd.read_csv(REFERENCE, dtype=str).map(float)  # Exact with all versions of pandas.
    # The last digits of traces may depend on the processor.
    pd.testing.assert_frame_equal(front[columns[:-1]], reference[columns[:-1]], check_exact=True)
    pd.testing.assert_series_equal(front[columns[-1]], reference[columns[-1]], rtol=1e-9)
    assert list(reference) == columns
