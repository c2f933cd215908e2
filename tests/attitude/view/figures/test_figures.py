"""The set of figures as a whole."""

import json

import plotly.graph_objects as go
import pytest
from mgeo_attitude import AttitudeManeuverProblem

from mgeo.evaluation.dominance import front_rows
from mgeo.runs.answer import default_solution


@pytest.mark.parametrize("n", [1, 7, pytest.param(300, marks=pytest.mark.slow)])
def test_all_figures_serialize(problem, X, n):
    figures = problem.view(X[:n]).figures()
    assert list(figures) == ["front", "maneuvers", "convergence"]
    for figure in figures.values():
        assert "<html>" in figure.to_html(include_plotlyjs="cdn")
        assert go.Figure(json.loads(figure.to_json())).layout.title == figure.layout.title
        assert figure.layout.template.layout.plot_bgcolor == "white"


@pytest.mark.parametrize("objectives", [None, ["trace", "angle"]])
def test_the_knee_is_that_of_reports(problem, X, objectives):
    """Of what was minimized, whatever it was."""
    other = AttitudeManeuverProblem(objectives=objectives)
    other.__dict__["model"] = problem.model
    rows = X[front_rows(F := other.evaluate(X[:60], return_values_of=["F"]))]
    expected = default_solution(other, F[front_rows(F)])
    assert expected.label == "knee"
    names = {trace.name for trace in other.view(rows).figures()["convergence"].data}
    assert {name for name in names if "knee" in name} == {f"solution {expected.row} (knee)"}
