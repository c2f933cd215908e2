"""Data of an exploration: numbers of solutions, evaluation of designs, saved files."""

import json

import numpy as np
import plotly.graph_objects as go
import pytest

from mgeo.explore import Explorer
from mgeo.explore.figures import select_rows
from mgeo.store.run_folder import read_run


def test_the_table_has_the_numbers_of_the_front(folder):
    explorer = Explorer(folder)
    F = read_run(folder).outcome.F
    assert list(explorer.table) == ["mass [kg]", "deflection [m]", "deflection [mm]"]
    np.testing.assert_allclose(explorer.table.to_numpy(), np.column_stack([F, 1e3 * F[:, 1]]))


def test_a_problem_without_a_view_shows_objectives_and_variables(solved):
    explorer = Explorer(solved(problem="zdt1"))
    assert list(explorer.table) == [*explorer.objectives, *explorer.names]
    numbers, margins = explorer.evaluate(np.full(30, 0.25))
    g = 1.0 + 9.0 * 0.25  # ZDT1
    assert numbers["f1"] == 0.25
    assert numbers["f2"] == pytest.approx(g * (1.0 - np.sqrt(0.25 / g)))
    assert margins == []
    assert explorer.build_figures(np.full(30, 0.25)) == {}


def test_a_changed_design_is_evaluated(folder):
    numbers, (length,) = Explorer(folder).evaluate([0.02, 0.75])
    assert numbers["mass [kg]"] == pytest.approx(7800.0 * np.pi / 4 * 0.02**2 * 0.75)
    assert not length.is_satisfied
    assert length.margin == -0.25


def test_figures_that_move_are_left_out(folder, monkeypatch):
    from stand_in import CantileverView

    figures = {"still": go.Figure(), "moving": go.Figure(layout={"meta": {"motion": {"end": 1}}})}
    monkeypatch.setattr(CantileverView, "solution_figures", lambda self: [figures])
    assert list(Explorer(folder).build_figures([0.02, 0.5])) == ["still"]


def test_rows_pass_the_ranges_of_every_axis(folder):
    table = Explorer(folder).table
    mass, bend = table["mass [kg]"].to_numpy(), table["deflection [mm]"].to_numpy()
    low, middle, high = np.quantile(bend, [0.1, 0.3, 0.9])
    from mgeo.explore.figures import is_logarithmic

    scale = np.log10 if is_logarithmic(table["deflection [mm]"]) else np.asarray
    ranges = scale([[bend.min(), low], [middle, high]]).tolist()
    dimensions = [
        {"name": "mass [kg]"},
        {"name": "deflection [mm]", "constraintrange": ranges},
    ]
    expected = (bend <= low) | ((middle <= bend) & (bend <= high))
    assert select_rows(table, dimensions) == np.flatnonzero(expected).tolist()
    assert select_rows(table, dimensions[:1]) == list(range(len(mass)))


def test_a_design_is_saved_into_a_new_file(folder, tmp_path):
    explorer = Explorer(folder, save=tmp_path / "beam.json")
    assert (explorer.folder, explorer.file_name) == (tmp_path, "beam.json")
    path = explorer.save([0.02, 0.5], "beam.json")
    with pytest.raises(FileExistsError, match=r"beam\.json exists"):
        explorer.save([0.03, 0.5], "beam.json")
    assert json.loads(path.read_text())["design"] == [0.02, 0.5]


@pytest.mark.parametrize("name", ["run.json", "../plan.json", "plan.txt", ""])
def test_other_files_are_never_written(folder, name):
    before = (folder / "run.json").read_text()
    with pytest.raises((ValueError, FileExistsError), match="name"):
        Explorer(folder).save([0.02, 0.5], name)
    assert (folder / "run.json").read_text() == before
