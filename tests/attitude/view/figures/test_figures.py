"""Serialization of all figures of a view."""

import json

import plotly.graph_objects as go


def test_all_figures_serialize(problem, X):
    figures = problem.view(X[:1]).figures()
    assert list(figures) == ["front", "maneuvers", "convergence"]
    for figure in figures.values():
        assert "<html>" in figure.to_html(include_plotlyjs="cdn")
        assert go.Figure(json.loads(figure.to_json())).layout.title == figure.layout.title
        assert figure.layout.template.layout.plot_bgcolor == "white"
