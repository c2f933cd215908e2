"""Figures as JSON: what differs is kept, and nothing else twice."""

import base64
import json

import numpy as np
import plotly.graph_objects as go
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mgeo.report.solutions import HOLE, figure_json, script_json, shared, tree_json


def filled(tree, values):
    """What the page does with a common tree and the values of one solution."""
    if isinstance(tree, list):
        return [filled(entry, values) for entry in tree]
    if not isinstance(tree, dict):
        return tree
    if HOLE in tree:
        return values[tree[HOLE]]
    return {key: filled(value, values) for key, value in tree.items()}


leaves = st.none() | st.booleans() | st.integers(-3, 3) | st.text("ab", max_size=2)
trees = st.recursive(
    leaves,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text("xy"), inner, max_size=3),
    max_leaves=12,
)


@given(st.lists(trees, min_size=1, max_size=5))
def test_every_tree_comes_back(given_trees):
    common, values = shared(given_trees)
    assert [filled(common, own) for own in values] == given_trees


def test_what_is_common_is_kept_once_and_so_are_times_of_several_curves():
    def tree(n):
        curves = [{"x": [n, n + 1], "y": [n * k, 0], "name": "long " * 9} for k in (1, 2)]
        return {"data": curves}

    common, values = shared([tree(3), tree(5)])
    assert common["data"][0]["name"] == "long " * 9
    assert common["data"][0]["x"] == common["data"][1]["x"] == {HOLE: 0}
    assert values == [[[3, 4], [3, 0], [6, 0]], [[5, 6], [5, 0], [10, 0]]]


def test_floats_are_float32_and_survive():
    x = np.array([1.0, np.pi, np.nan, 1e-12])
    figure = go.Figure(go.Scatter(x=x, y=np.arange(4), customdata=np.ones((4, 2))))
    tree = figure_json(figure)
    encoded = tree["data"][0]["x"]
    assert encoded["dtype"] == "f4"
    back = np.frombuffer(base64.b64decode(encoded["bdata"]), "<f4")
    np.testing.assert_allclose(back, x, rtol=1e-7)
    assert tree["data"][0]["customdata"] == [[1.0, 1.0]] * 4
    lists = figure_json(figure, lists=True)["data"][0]
    assert lists["x"] == [1.0, float(np.float32(np.pi)), None, float(np.float32(1e-12))]
    assert lists["y"] == [0, 1, 2, 3]
    assert "template" not in tree["layout"]


def test_a_tree_is_written_as_its_figure():
    arrays = {"x": np.array([1.0, np.pi, np.nan]), "y": np.arange(3), "text": ["a", "b", None]}
    meta = {"n": np.float64(2.5), "k": np.int64(3), "on": True, "gap": float("nan")}
    far = {"x": np.array([0, 300]), "y": np.array([-70_000, 5]), "customdata": np.ones((2, 2))}
    tree = {
        "data": [{"type": "scatter", **arrays, "meta": meta}, {"type": "scatter", **far}],
        "layout": {"title": {"text": "t"}, "xaxis": {"range": (0, 1.5)}},
    }
    found, drawn = tree_json(tree), figure_json(go.Figure(tree))
    json.dumps(found, allow_nan=False)
    for kind, text in (("f4", "x"), ("i1", "y")):
        packed = found["data"][0][text]
        assert packed["dtype"] == kind
        back = np.frombuffer(base64.b64decode(packed["bdata"]), f"<{kind}")
        np.testing.assert_array_equal(back, arrays[text].astype(kind))
    assert found["data"][0]["x"] == drawn["data"][0]["x"]
    assert found["data"][0]["text"] == arrays["text"]
    assert found["data"][0]["meta"] == {"n": 2.5, "k": 3, "on": True, "gap": None}
    assert [found["data"][1][key]["dtype"] for key in "xy"] == ["i2", "i4"]
    assert found["data"][1]["customdata"] == [[1.0, 1.0]] * 2
    assert found["layout"] == drawn["layout"]
    assert tree_json(np.array([2**40, 1])) == [2**40, 1]
    with pytest.raises(TypeError, match="in a figure"):
        tree_json({"x": {1, 2}})


@pytest.mark.parametrize("text", ["</script><script>x()", "<!--", "a & b", "é\u2028"])
def test_json_in_a_script_holds_no_markup(text):
    written = script_json({text: [text]})
    assert not set("<>&\u2028") & set(written)
    assert json.loads(written) == {text: [text]}
