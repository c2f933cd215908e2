"""The look that all figures share."""

import pytest

from mgeo.figures.style import COLORS, log_axis, symbol


@pytest.mark.parametrize(
    ("values", "dtick"),
    [([2e-3, 1.9], "D2"), ([[1.0, 5.0], [1e4, 2.0]], 1), ([1.5e-6, 1.9e-6], None)],
)
def test_the_labels_of_a_logarithmic_axis_depend_on_its_width(values, dtick):
    axis = log_axis(values)
    assert axis["type"] == "log"
    assert axis.get("dtick") == dtick  # without one plotly chooses


def test_no_two_of_many_lines_look_alike():
    assert len({(COLORS[i % len(COLORS)], symbol(i)) for i in range(49)}) == 49
