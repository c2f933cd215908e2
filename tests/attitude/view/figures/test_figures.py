"""The set of figures as a whole."""

import dataclasses
import json

import numpy as np
import plotly.graph_objects as go
import pytest
from mgeo_attitude import AttitudeManeuverProblem, Scenario

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


@pytest.mark.slow
def test_chosen_few_are_the_same_in_both_close_looks(problem, X, F):
    figures = problem.view(X).figures()
    names = {trace.name for trace in figures["convergence"].data}
    rows = [annotation.text for annotation in figures["maneuvers"].layout.annotations]
    assert names == {row.partition(":")[0] for row in rows}
    assert rows[0].startswith(f"solution {np.lexsort((F[:, 1], F[:, 0]))[0]} (fastest")
    assert f"solution {F[:, 1].argmin()} (least trace)" in names


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


@pytest.mark.parametrize("shape", [(0, 12), (3, 8)])
def test_nothing_to_show_is_refused(problem, shape):
    with pytest.raises(ValueError, match=r"X of shape \(\d, \d+\): expected"):
        problem.view(np.zeros(shape)).figures()


def test_other_objectives_than_the_papers_have_no_picture_of_its_front(X):
    scenario = dataclasses.replace(Scenario.paper(), duration=2400.0)
    three = AttitudeManeuverProblem(scenario, objectives=["t_end", "trace", "angle"])
    assert set(three.view(X[:10]).figures()) == {"maneuvers", "convergence"}
    assert len(three.view(X[:2]).solution_figures()) == 2
