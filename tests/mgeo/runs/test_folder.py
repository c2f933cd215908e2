import csv
import json
import os
import platform
from importlib.metadata import version

import numpy as np
import pandas as pd
import pytest

from mgeo.runs.prepare import PreparedRun, prepare
from mgeo.store.provenance import installed_versions
from mgeo.store.run import Run
from mgeo.store.run_folder import FIGURE_FILE, check_folder, front_table, read_run, write_run
from tests.disk import room

pytestmark = pytest.mark.usefixtures("stand_in")


@pytest.fixture
def run(stand_in):
    prepared = prepare(
        "cantilever",
        algorithm="mgeo-real",
        parameters={"sigma": 0.05, "n_walkers": 4},
        evaluations=400,
        seed=2,
    )
    return Run(prepared.configuration, prepared.solve(), installed_versions("cantilever"))


def replaced(outcome, **values):
    return outcome.model_copy(update=values)


def contents(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def test_what_is_written_is_read_back_exactly(run, tmp_path):
    write_run(tmp_path / "a" / "b", run)
    read = read_run(tmp_path / "a" / "b")
    assert read.configuration == run.configuration
    assert read.versions == run.versions
    assert np.array_equal(read.outcome.X, run.outcome.X)
    assert np.array_equal(read.outcome.F, run.outcome.F)
    for name in ("variables", "objectives", "status", "evaluations", "hypervolume", "started"):
        assert getattr(read.outcome, name) == getattr(run.outcome, name)
    assert read.outcome.wall_time_s == run.outcome.wall_time_s


def test_the_front_is_a_table_any_program_reads_exactly(run, tmp_path):
    write_run(tmp_path, run)
    with (tmp_path / "front.csv").open(newline="") as file:
        header, *rows = csv.reader(file)
    assert header == ["diameter [m]", "length [m]", "mass [kg]", "deflection [m]"]
    values = np.array([[float(cell) for cell in row] for row in rows])
    assert np.array_equal(values, np.hstack([run.outcome.X, run.outcome.F]))
    assert np.all(np.diff(values[:, 2]) >= 0)  # ordered by the first objective


def test_a_run_read_back_can_be_made_again(run, tmp_path):
    write_run(tmp_path, run)
    again = PreparedRun.of(read_run(tmp_path).configuration).solve()
    assert np.array_equal(again.X, run.outcome.X)
    assert np.array_equal(again.F, run.outcome.F)
    assert again.hypervolume == run.outcome.hypervolume


def test_the_versions_are_those_installed(run):
    assert run.versions == {
        "python": platform.python_version(),
        "mgeo": version("mgeo"),
        "pymoo": version("pymoo"),
        "numpy": np.__version__,
        "stand-in": "1.2.3",
    }


def test_special_numbers_and_an_empty_front_survive(run, tmp_path):
    X = np.array([[0.1 + 0.2, -0.0], [5e-324, 1.7976931348623157e308]])
    F = np.array([[-1e-300, 1.0], [1 / 3, 1e22]])
    odd = Run(run.configuration, replaced(run.outcome, X=X, F=F), run.versions)
    write_run(tmp_path / "odd", odd)
    read = read_run(tmp_path / "odd").outcome
    assert read.X.tobytes() == X.tobytes()
    assert read.F.tobytes() == F.tobytes()
    none = replaced(run.outcome, X=X[:0], F=F[:0], hypervolume=None)
    write_run(tmp_path / "none", Run(run.configuration, none, run.versions))
    read = read_run(tmp_path / "none").outcome
    assert (read.X.shape, read.F.shape, read.hypervolume) == ((0, 2), (0, 2), None)


def test_a_front_of_other_than_finite_numbers_is_refused(run, tmp_path):
    F = run.outcome.F.copy()
    F[1, 0] = np.nan
    write_run(tmp_path, Run(run.configuration, replaced(run.outcome, F=F), run.versions))
    with pytest.raises(
        ValueError, match=r"front\.csv: row 2, mass \[kg\] = 'nan': expected a finite"
    ):
        read_run(tmp_path)


def test_a_folder_in_use_is_refused_unless_told(run, tmp_path):
    write_run(tmp_path, run)
    before = contents(tmp_path)
    with pytest.raises(FileExistsError, match="is not empty"):
        write_run(tmp_path, run)
    with pytest.raises(FileExistsError, match="is not empty"):
        check_folder(tmp_path)
    assert contents(tmp_path) == before


def test_overwriting_replaces_the_run_and_its_figure_and_nothing_else(run, tmp_path):
    write_run(tmp_path, run)
    (tmp_path / FIGURE_FILE).write_text("<p>old</p>")
    (tmp_path / "notes.txt").write_text("mine")
    for name in ("front.csv", "run.json", "front.html"):  # of a process that was killed meanwhile
        (tmp_path / f".{name}.0123456789abcdef.tmp").write_text("half")
    shorter = replaced(run.outcome, X=run.outcome.X[:3], F=run.outcome.F[:3])
    write_run(tmp_path, Run(run.configuration, shorter, run.versions), overwrite=True)
    assert sorted(contents(tmp_path)) == ["front.csv", "notes.txt", "run.json"]
    assert len(read_run(tmp_path).outcome.F) == 3


def test_a_front_is_never_read_with_the_configuration_of_another_run(run, tmp_path, monkeypatch):
    other = Run(run.configuration.model_copy(update={"seed": 3}), run.outcome, run.versions)
    write_run(tmp_path, run)
    with monkeypatch.context() as during:  # who reads is overtaken by who writes

        def late(path):
            write_run(tmp_path, other, overwrite=True)
            return pd.read_csv(path)

        during.setattr("mgeo.store.run_folder.read_numbers", late)
        with pytest.raises(ValueError, match=r"run\.json was written anew while"):
            read_run(tmp_path)
    assert read_run(tmp_path).configuration.seed == 3
    with monkeypatch.context() as during:  # who writes is killed after the first file

        def killed(source, target, replace=os.replace):
            replace(source, target)
            raise KeyboardInterrupt

        during.setattr(os, "replace", killed)
        with pytest.raises(KeyboardInterrupt):
            write_run(tmp_path, run, overwrite=True)
    with pytest.raises(FileNotFoundError, match="holds no run"):
        read_run(tmp_path)


def test_a_file_in_place_of_the_folder_is_refused(run, tmp_path):
    (tmp_path / "a").write_text("")
    with pytest.raises(FileExistsError, match="is a file"):
        check_folder(tmp_path / "a", overwrite=True)


@pytest.mark.slow
def test_a_disk_error_leaves_the_run_that_was_there(run, tmp_path):
    write_run(tmp_path, run)
    before = contents(tmp_path)
    large = np.tile(run.outcome.X, (20_000, 1)), np.tile(run.outcome.F, (20_000, 1))
    larger = Run(run.configuration, replaced(run.outcome, X=large[0], F=large[1]), run.versions)
    with room(1 << 20), pytest.raises(OSError, match="too large"):
        write_run(tmp_path, larger, overwrite=True)
    assert contents(tmp_path) == before


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"format": 1}, "run.json: format = 1: this version of mgeo reads format 2"),
        ({"status": "lost"}, "status = 'lost'"),
        ({"solutions": 1}, r"front\.csv has .* rows .*expected 1 rows"),
        ({"variables": ["diameter [m]", "width [m]"]}, r"front\.csv has .*width"),
        ({"configuration": {}}, "problem is missing"),
    ],
)
def test_a_damaged_folder_is_refused_naming_file_and_key(run, tmp_path, change, message):
    write_run(tmp_path, run)
    data = json.loads((tmp_path / "run.json").read_text())
    (tmp_path / "run.json").write_text(json.dumps(data | change))
    with pytest.raises(ValueError, match=message):
        read_run(tmp_path)


def test_a_missing_key_or_file_is_named(run, tmp_path):
    with pytest.raises(FileNotFoundError, match="holds no run"):
        read_run(tmp_path)
    write_run(tmp_path, run)
    data = json.loads((tmp_path / "run.json").read_text())
    del data["started"]
    (tmp_path / "run.json").write_text(json.dumps(data))
    with pytest.raises(ValueError, match=r"run\.json: started is missing"):
        read_run(tmp_path)
    (tmp_path / "run.json").write_text("{")
    with pytest.raises(ValueError, match=r"run\.json: Expecting"):
        read_run(tmp_path)


def test_the_table_has_names_and_rows(run):
    table = front_table(run.outcome)
    assert list(table.columns) == [*run.outcome.variables, *run.outcome.objectives]
    assert np.array_equal(table["mass [kg]"], run.outcome.F[:, 0])
