"""Data of the explorer: table of solutions, evaluation of designs, and saved files."""

import json

import numpy as np
import plotly.graph_objects as go
import pytest

from mgeo.explore import Explorer
from mgeo.explore.figures import is_logarithmic, select_rows
from mgeo.store.run_folder import read_run


def test_table_has_objectives_and_quick_metrics(folder):
    explorer = Explorer(folder)
    F = read_run(folder).outcome.F
    assert list(explorer.table) == ["mass [kg]", "deflection [m]", "deflection [mm]"]
    np.testing.assert_allclose(explorer.table.to_numpy(), np.column_stack([F, 1e3 * F[:, 1]]))


def test_problem_without_a_view_has_objectives_and_variables(solved):
    explorer = Explorer(solved(problem="zdt1"))
    assert list(explorer.table) == [*explorer.objectives, *explorer.names]
    metrics, margins = explorer.evaluate(np.full(30, 0.25))
    g = 1.0 + 9.0 * 0.25  # auxiliary function of ZDT1
    assert metrics["f1"] == 0.25
    assert metrics["f2"] == pytest.approx(g * (1.0 - np.sqrt(0.25 / g)))
    assert margins == []
    assert explorer.build_figures(np.full(30, 0.25)) == {}


def test_modified_design_is_evaluated(folder):
    metrics, (length,) = Explorer(folder).evaluate([0.02, 0.75])
    assert metrics["mass [kg]"] == pytest.approx(7800.0 * np.pi / 4 * 0.02**2 * 0.75)
    assert not length.is_satisfied
    assert length.margin == -0.25


def test_animated_figures_are_left_out(folder, monkeypatch):
    from stand_in import CantileverView

    figures = {
        "static": go.Figure(),
        "animated": go.Figure(layout={"meta": {"motion": {"end": 1}}}),
    }
    monkeypatch.setattr(CantileverView, "solution_figures", lambda self: [figures])
    assert list(Explorer(folder).build_figures([0.02, 0.5])) == ["static"]


def test_rows_within_the_ranges_of_all_axes_are_selected(folder):
    table = Explorer(folder).table
    mass, deflection = table["mass [kg]"].to_numpy(), table["deflection [mm]"].to_numpy()
    low, middle, high = np.quantile(deflection, [0.1, 0.3, 0.9])
    scale = np.log10 if is_logarithmic(table["deflection [mm]"]) else np.asarray
    ranges = scale([[deflection.min(), low], [middle, high]]).tolist()
    dimensions = [
        {"name": "mass [kg]"},
        {"name": "deflection [mm]", "constraintrange": ranges},
    ]
    expected = (deflection <= low) | ((middle <= deflection) & (deflection <= high))
    assert select_rows(table, dimensions) == np.flatnonzero(expected).tolist()
    assert select_rows(table, dimensions[:1]) == list(range(len(mass)))


def test_design_is_saved_into_a_new_file(folder, tmp_path):
    explorer = Explorer(folder, save=tmp_path / "beam.json")
    assert (explorer.folder, explorer.file_name) == (tmp_path, "beam.json")
    path = explorer.save([0.02, 0.5], "beam.json")
    with pytest.raises(FileExistsError, match=r"beam\.json exists"):
        explorer.save([0.03, 0.5], "beam.json")
    assert json.loads(path.read_text())["design"] == [0.02, 0.5]


@pytest.mark.parametrize("name", ["run.json", "../plan.json", "plan.txt", ""])
def test_no_other_files_are_written(folder, name):
    before = (folder / "run.json").read_text()
    with pytest.raises((ValueError, FileExistsError), match="name"):
        Explorer(folder).save([0.02, 0.5], name)
    assert (folder / "run.json").read_text() == before
