"""What the page is told of solutions, and of designs that are none of them."""

import numpy as np
import pandas as pd
import pytest
from pymoo.core.problem import Problem

from mgeo.explore import Explorer
from mgeo.runs.prepare import prepare
from mgeo.store.run import Run
from mgeo.store.run_folder import read_run, write_run


def test_the_front_has_objectives_and_what_is_told_in_numbers(explorer, folder):
    found, outcome = explorer.front(), read_run(folder).outcome
    assert [column["name"] for column in found["columns"]] == [
        *("mass [kg]", "deflection [m]", "deflection [mm]"),
    ]
    table = np.array(found["rows"])
    np.testing.assert_array_equal(table[:, :2], outcome.F)
    np.testing.assert_array_equal(table[:, 2], 1000.0 * outcome.F[:, 1])
    np.testing.assert_array_equal(found["designs"], outcome.X)
    assert [v["name"] for v in found["variables"]] == ["diameter [m]", "length [m]"]
    assert [(v["low"], v["high"]) for v in found["variables"]] == [(0.01, 0.05), (0.2, 1.0)]
    assert found["labels"][str(found["first"])] == "knee"


def test_a_changed_design_is_evaluated_as_those_of_the_front(explorer):
    front = explorer.front()
    for place in (0, len(front["rows"]) // 2):
        assert explorer.glance(np.array(front["designs"][place]))["numbers"] == front["rows"][place]
    diameter, length = 0.03, 0.9
    found = explorer.glance(np.array([diameter, length]))
    mass = 7800.0 * np.pi / 4 * diameter**2 * length
    sag = 64 * 1000.0 * length**3 / (3 * 207e9 * np.pi * diameter**4)
    np.testing.assert_allclose(found["numbers"], [mass, sag, 1000.0 * sag], rtol=1e-12)
    (limit,) = found["limits"]
    assert (limit["name"], limit["value"], limit["limit"], limit["kept"]) == (
        *("length", 0.9, 0.5, False),
    )
    assert limit["text"] == "0.9 m, at most 0.5 m: exceeded by 0.4 m"


def test_what_is_known_at_a_glance_need_not_be_all(explorer, monkeypatch):
    """And nothing is evaluated twice that the glance has told."""
    from stand_in import CantileverView

    asked = []

    def glance(self):
        asked.append(len(self.X))
        names = ("mass [kg]", "deflection [m]")
        return pd.DataFrame(self.F, columns=names).assign(text="x", brittle=True)

    monkeypatch.setattr(CantileverView, "glance", glance, raising=False)
    monkeypatch.setattr(CantileverView, "describe", lambda self: 1 / 0)
    front = explorer.front()
    assert [column["name"] for column in front["columns"]] == ["mass [kg]", "deflection [m]"]
    assert explorer.glance(np.array(front["designs"][0]))["numbers"] == front["rows"][0]
    assert asked == [len(front["rows"]), 1]


def test_answer_review_figures_and_pictures_are_the_views(explorer):
    from stand_in import Cantilever

    x = np.array([0.03, 0.9])
    view = Cantilever().view([x])
    found = explorer.answer(x)
    assert [found["answer"]] == view.answers()
    assert dict(found["described"]) == pytest.approx(view.describe().iloc[0].to_dict(), rel=1e-6)
    assert [section["title"] for section in explorer.review(x)["sections"]] == [
        *("Solution", "Limits"),
    ]
    assert explorer.figures(x) == {"figures": {}}
    assert explorer.pictures()["front"]["layout"]["title"]["text"] == "drawn by the plugin"


@pytest.mark.parametrize(
    ("design", "message"),
    [
        ([0.02], "design of 1 numbers: expected 2"),
        ([0.02, 1.5], r"design\[1\] = 1.5: expected 0.2 to 1 for length \[m\]"),
        ([float("nan"), 0.5], r"design\[0\] = nan: expected 0.01 to 0.05"),
    ],
)
def test_what_is_no_design_is_named(explorer, design, message):
    with pytest.raises(ValueError, match=message):
        explorer.design(design)


class Steps(Problem):
    """Whole numbers."""

    def __init__(self):
        super().__init__(n_var=2, n_obj=2, xl=0, xu=9, vtype=int)

    def _evaluate(self, X, out, *args, **kwargs):
        out["F"] = np.column_stack([X.sum(axis=1), (9 - X).sum(axis=1)])


def saved(tmp_path, name):
    made = prepare(name, {}, evaluations=200)
    run = Run(made.configuration, made.solve(), {})
    (tmp_path / "run").mkdir()
    write_run(tmp_path / "run", run)
    return tmp_path / "run"


def test_whole_numbers_stay_whole_and_a_class_must_be_named(tmp_path):
    name = f"{__name__}:Steps"
    folder = saved(tmp_path, name)
    with pytest.raises(ValueError, match="Steps"):
        Explorer(folder)
    explorer = Explorer(folder, problem=name)
    assert {variable["kind"] for variable in explorer.front()["variables"]} == {"integer"}
    assert explorer.glance(explorer.design([3, 4]))["numbers"] == [7.0, 11.0]
    with pytest.raises(ValueError, match=r"design\[1\] = 4.5: expected a whole number for x2"):
        explorer.design([3, 4.5])


def test_a_folder_without_a_run_is_refused(tmp_path):
    with pytest.raises(FileNotFoundError):
        Explorer(tmp_path)
