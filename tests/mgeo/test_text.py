"""Messages of others on one line: wherever one is shown, blanks within it stay."""

from mgeo._foreign import one_line
from mgeo.evaluation.failures import Failure

ELEMENTS = "1 28350U 04020A   06167.21788666  .16154492  76267-5  18678-3 0  8894"


def test_lines_become_one_and_columns_stay():
    assert one_line(f"  a\n\n\t{ELEMENTS}  \r\n    b\n") == f"a {ELEMENTS} b"


def test_the_cause_of_a_failure_quotes_what_it_quotes():
    failure = Failure.of(ValueError(f"line1 = {ELEMENTS!r}:\n  decayed"))
    assert failure.cause == f"ValueError: line1 = {ELEMENTS!r}: decayed"
