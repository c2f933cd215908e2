"""Encoding of figures as JSON: common structure, arrays, and safety in HTML."""

import base64
import json

import numpy as np
import plotly.graph_objects as go
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mgeo.report.solutions import (
    PLACEHOLDER,
    build_figure_json,
    extract_common_structure,
    format_script_json,
)


def fill_placeholders(tree, values):
    """Reconstruct the tree of one solution, as the script of the page does."""
    if isinstance(tree, list):
        return [fill_placeholders(entry, values) for entry in tree]
    if not isinstance(tree, dict):
        return tree
    if PLACEHOLDER in tree:
        return values[tree[PLACEHOLDER]]
    return {key: fill_placeholders(value, values) for key, value in tree.items()}


leaves = st.none() | st.booleans() | st.integers(-3, 3) | st.text("ab", max_size=2)
trees = st.recursive(
    leaves,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text("xy"), inner, max_size=3),
    max_leaves=12,
)


@given(st.lists(trees, min_size=1, max_size=5))
def test_split_trees_can_be_reconstructed(given_trees):
    common, values = extract_common_structure(given_trees)
    assert [fill_placeholders(common, row) for row in values] == given_trees


def test_common_structure_and_equal_times_are_stored_once():
    def build_tree(n):
        curves = [{"x": [n, n + 1], "y": [n * k, 0], "name": "long " * 9} for k in (1, 2)]
        return {"data": curves}

    common, values = extract_common_structure([build_tree(3), build_tree(5)])
    assert common["data"][0]["name"] == "long " * 9
    assert common["data"][0]["x"] == common["data"][1]["x"] == {PLACEHOLDER: 0}
    assert values == [[[3, 4], [3, 0], [6, 0]], [[5, 6], [5, 0], [10, 0]]]


def test_floats_are_encoded_as_float32():
    x = np.array([1.0, np.pi, np.nan, 1e-12])
    figure = go.Figure(go.Scatter(x=x, y=np.arange(4), customdata=np.ones((4, 2))))
    tree = build_figure_json(figure)
    encoded = tree["data"][0]["x"]
    assert encoded["dtype"] == "f4"
    decoded = np.frombuffer(base64.b64decode(encoded["bdata"]), "<f4")
    np.testing.assert_allclose(decoded, x, rtol=1e-7)
    assert tree["data"][0]["customdata"] == [[1.0, 1.0]] * 4
    lists = build_figure_json(figure, use_lists=True)["data"][0]
    assert lists["x"] == [1.0, np.pi, None, 1e-12]
    assert lists["y"] == [0, 1, 2, 3]
    assert "template" not in tree["layout"]


@pytest.mark.parametrize("text", ["</script><script>x()", "<!--", "a & b", "é\u2028"])
def test_json_in_a_script_contains_no_markup(text):
    encoded = format_script_json({text: [text]})
    assert not set("<>&\u2028") & set(encoded)
    assert json.loads(encoded) == {text: [text]}
