"""CSV that reads back exactly, and CSV that somebody has touched."""

import csv
import io

import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mgeo_attitude.plan import ManeuverPlan, from_csv, read_csv, to_csv, write_csv


@pytest.fixture(scope="module")
def text(plan):
    return to_csv(plan)


def test_round_trip(plan, text, tmp_path):
    path = tmp_path / "plan.csv"
    write_csv(plan, path)
    pd.testing.assert_frame_equal(read_csv(path), plan.timeline(), check_exact=True)
    assert path.read_text(encoding="utf-8") == text


@settings(deadline=None, max_examples=10)
@given(st.data())
def test_any_plan_round_trips(problem, data):
    bounds = zip(problem.xl, problem.xu, strict=True)
    design = data.draw(st.tuples(*(st.floats(low, high) for low, high in bounds)))
    plan = ManeuverPlan.from_design(problem, design)
    pd.testing.assert_frame_equal(from_csv(to_csv(plan)), plan.timeline(), check_exact=True)


@settings(deadline=None, max_examples=100)
@given(st.data())
def test_truncated_anywhere_it_is_refused(text, data):
    with pytest.raises(ValueError):  # noqa: PT011 - which message depends on the place
        from_csv(text[: data.draw(st.integers(0, len(text) - 1))])


def changed(text, row, column, value):
    rows = list(csv.reader(io.StringIO(text)))
    rows[row][rows[0].index(column)] = value
    out = io.StringIO()
    csv.writer(out, lineterminator="\n").writerows(rows)
    return out.getvalue()


@pytest.mark.parametrize(
    ("row", "column", "value"),
    [
        (1, "row", "1/4"),
        (1, "phase", "maneuver 0"),
        (2, "phase", "__import__('os')"),
        (1, "start [s]", "1.0"),
        (1, "end [s]", "-5.0"),
        (2, "end [s]", "180.0"),
        (2, "duration [s]", "81.5"),
        (2, "rate x [deg/s]", "0.31"),
        (3, "rate z [deg/s]", "nan"),
        (3, "rate z [deg/s]", "fast"),
        (1, "swept [deg]", "inf"),
        (1, "swept [deg]", "114.0"),
        (1, "start q1", "0.1"),
        (2, "start qc", "0.5"),
        (3, "end q2", "0.0"),
        (1, "start UTC", "yesterday"),
        (1, "start UTC", "2018-06-05T00:00:01.000000"),
        (2, "end UTC", "2018-06-05T00:03:02.000000"),
    ],
)
def test_what_was_changed_is_named(text, row, column, value):
    with pytest.raises(ValueError, match=r"row \d, ") as error:
        from_csv(changed(text, row, column, value))
    if value in ("nan", "inf", "fast", "yesterday"):
        assert f"row {row}, {column} = {value!r}" in str(error.value)


def test_rows_and_columns(text, tmp_path):
    lines = text.splitlines(keepends=True)
    for shorter in (lines[:1] + lines[2:], lines[:2] + lines[3:], lines[:3]):
        with pytest.raises(ValueError, match=r"row 1, row = '\d/3': expected 1/2"):
            from_csv("".join(shorter))
    with pytest.raises(ValueError, match="columns"):
        from_csv("".join(lines[1:]))
    with pytest.raises(ValueError, match="at least one row"):
        from_csv(lines[0])
    with pytest.raises(ValueError, match="row 2 has 20 values: expected 19"):
        from_csv(lines[0] + lines[1] + lines[2][:-1] + ",1\n")
    with pytest.raises(ValueError, match="no CSV"):
        from_csv(lines[0] + '"1/3\n')
    path = tmp_path / "plan.csv"
    path.write_text(lines[0], encoding="utf-8")
    with pytest.raises(ValueError, match=r"plan\.csv: expected at least one row"):
        read_csv(path)
