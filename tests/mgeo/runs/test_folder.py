import csv
import json

import numpy as np
import pytest

from mgeo.runs.prepare import prepare_run
from mgeo.store.provenance import list_problem_versions
from mgeo.store.run import Run
from mgeo.store.run_folder import FIGURE_FILE, read_run, write_arrays, write_run

pytestmark = pytest.mark.usefixtures("stand_in")


@pytest.fixture
def run(stand_in):
    prepared = prepare_run(
        "cantilever",
        algorithm="mgeo-real",
        parameters={"sigma": 0.05, "n_walkers": 4},
        evaluations=400,
        seed=2,
    )
    return Run(prepared.configuration, prepared.solve(), list_problem_versions("cantilever"))


def replace_values(outcome, **values):
    return outcome.model_copy(update=values)


def read_contents(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def test_run_is_read_back_exactly(run, tmp_path):
    write_run(tmp_path / "a" / "b", run)
    read = read_run(tmp_path / "a" / "b")
    assert read.configuration == run.configuration
    assert read.versions == run.versions
    with (tmp_path / "a" / "b" / "front.csv").open(newline="") as file:
        header, *rows = csv.reader(file)
    assert header == ["diameter [m]", "length [m]", "mass [kg]", "deflection [m]"]
    values = np.array(rows, dtype=float)
    assert np.array_equal(values, np.hstack([run.outcome.X, run.outcome.F]))
    assert np.all(np.diff(values[:, 2]) >= 0)  # Solutions are sorted by the first objective.
    for name in (
        "variables",
        "objectives",
        "stop_reason",
        "n_evaluations",
        "hypervolume",
        "start_time",
    ):
        assert getattr(read.outcome, name) == getattr(run.outcome, name)
    assert read.outcome.wall_time_s == run.outcome.wall_time_s


def test_constraints_and_further_arrays_are_stored(run, tmp_path):
    n = len(run.outcome.F)
    values = np.random.default_rng(1).normal(size=(n, 3))
    outcome = replace_values(run.outcome, G=values, arrays={"accuracy": values[:, :1]})
    write_run(tmp_path, Run(run.configuration, outcome, run.versions))
    read = read_run(tmp_path).outcome
    assert np.array_equal(read.G, values)
    assert read.H.shape == (n, 0)
    assert np.array_equal(read.arrays["accuracy"], values[:, :1])
    write_arrays(tmp_path, outcome, {"accuracy": values[1:]})
    with pytest.raises(ValueError, match=rf"front\.npz: accuracy of shape .*: expected {n} rows"):
        read_run(tmp_path)


def test_special_numbers_and_empty_front_are_read_back_exactly(run, tmp_path):
    X = np.array([[0.1 + 0.2, -0.0], [5e-324, 1.7976931348623157e308]])
    F = np.array([[-1e-300, 1.0], [1 / 3, 1e22]])
    values = {"X": X, "F": F, "G": X[:, :0], "H": X[:, :0]}
    special = Run(run.configuration, replace_values(run.outcome, **values), run.versions)
    write_run(tmp_path / "special", special)
    read = read_run(tmp_path / "special").outcome
    assert read.X.tobytes() == X.tobytes()
    assert read.F.tobytes() == F.tobytes()
    values = {name: array[:0] for name, array in values.items()}
    empty = replace_values(run.outcome, **values, hypervolume=None)
    write_run(tmp_path / "empty", Run(run.configuration, empty, run.versions))
    read = read_run(tmp_path / "empty").outcome
    assert (read.X.shape, read.F.shape, read.hypervolume) == ((0, 2), (0, 2), None)


def test_overwriting_replaces_files_of_the_run_only(run, tmp_path):
    write_run(tmp_path, run)
    (tmp_path / FIGURE_FILE).write_text("<p>old</p>")
    (tmp_path / "notes.txt").write_text("mine")
    shorter = replace_values(run.outcome, **{k: getattr(run.outcome, k)[:3] for k in "XFGH"})
    write_run(tmp_path, Run(run.configuration, shorter, run.versions), overwrite=True)
    assert sorted(read_contents(tmp_path)) == ["front.csv", "front.npz", "notes.txt", "run.json"]
    assert len(read_run(tmp_path).outcome.F) == 3


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"format": 1}, "run.json: format = 1: this version of mgeo reads format 3"),
        ({"stop_reason": "lost"}, "stop_reason = 'lost'"),
        ({"n_solutions": 1}, r"front\.csv: .* rows .*expected 1 rows"),
        ({"variables": ["diameter [m]", "width [m]"]}, r"front\.csv: .*width"),
        ({"configuration": {}}, "problem is missing"),
    ],
)
def test_damaged_folder_is_rejected_with_file_and_key(run, tmp_path, change, message):
    write_run(tmp_path, run)
    data = json.loads((tmp_path / "run.json").read_text())
    (tmp_path / "run.json").write_text(json.dumps(data | change))
    with pytest.raises(ValueError, match=message):
        read_run(tmp_path)


def test_missing_key_or_file_is_named(run, tmp_path):
    with pytest.raises(FileNotFoundError, match="holds no run"):
        read_run(tmp_path)
    write_run(tmp_path, run)
    data = json.loads((tmp_path / "run.json").read_text())
    del data["start_time"]
    (tmp_path / "run.json").write_text(json.dumps(data))
    with pytest.raises(ValueError, match=r"run\.json: start_time is missing"):
        read_run(tmp_path)
    (tmp_path / "run.json").write_text("{")
    with pytest.raises(ValueError, match=r"run\.json: not valid JSON: Expecting"):
        read_run(tmp_path)
