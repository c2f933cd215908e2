"""Solutions that are saved: where, under which names, and read back by a comparison."""

import json

import numpy as np
import pytest

from mgeo.explore.explorer import Explorer
from mgeo.explore.saving import Exists, Saved
from mgeo.report import compare_html
from mgeo.store.solution_file import solution_of

X = np.array([0.03, 0.9])


def test_a_solution_is_saved_and_compared(explorer, folder):
    path = explorer.save(X, "plan.json", overwrite=False)["file"]
    assert path == str(folder / "plan.json")
    problem, options, x = solution_of(json.loads((folder / "plan.json").read_text()))
    assert (type(problem).__name__, dict(options)) == ("Cantilever", {"load": 1000.0})
    np.testing.assert_array_equal(x, X)
    html = compare_html(folder, folder / "plan.json")
    assert "run beside plan.json" in html
    assert [entry.name for entry in folder.glob(".*.tmp")] == []


def test_one_of_the_same_name_is_replaced_only_when_told_to(explorer, folder):
    explorer.save(X, "plan.json", overwrite=False)
    before = (folder / "plan.json").read_text()
    with pytest.raises(Exists, match="there already"):
        explorer.save(0.9 * X, "plan.json", overwrite=False)
    assert (folder / "plan.json").read_text() == before
    explorer.save(0.9 * X, "plan.json", overwrite=True)
    assert json.loads((folder / "plan.json").read_text())["design"] == (0.9 * X).tolist()


@pytest.mark.cases(2)
@pytest.mark.parametrize(
    "name",
    [
        *("../plan.json", "/tmp/plan.json", "a/plan.json", "..json", ".json", "plan.txt", ""),
        *("run.json", "RUN.json", "verification.json", "verification-2.json", "plan\n.json"),
    ],
)
def test_other_names_are_refused(explorer, folder, name):
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    with pytest.raises(ValueError, match="name = "):
        explorer.save(X, name, overwrite=True)
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before


def test_what_is_no_solution_is_never_replaced(explorer, folder):
    (folder / "notes.json").write_text('{"mine": 1}')
    with pytest.raises(ValueError, match="no solution's file"):
        explorer.save(X, "notes.json", overwrite=True)
    (folder / "link.json").symlink_to(folder / "run.json")
    with pytest.raises(ValueError, match="no solution's file"):
        explorer.save(X, "link.json", overwrite=True)
    assert json.loads((folder / "notes.json").read_text()) == {"mine": 1}


def test_a_user_says_another_place(folder, tmp_path):
    explorer = Explorer(folder, save=tmp_path / "mine.json")
    assert explorer.front()["save"] == {"name": "mine.json", "fixed": True}
    with pytest.raises(ValueError, match=r"expected mine\.json, as --save says"):
        explorer.save(X, "other.json", overwrite=False)
    assert explorer.save(X, "mine.json", overwrite=False)["file"] == str(tmp_path / "mine.json")
    other = tmp_path / "plans"
    other.mkdir()
    Explorer(folder, save=other).save(X, "a.json", overwrite=False)
    assert [path.name for path in other.iterdir()] == ["a.json"]


def test_a_place_that_is_none_is_refused(folder, tmp_path):
    with pytest.raises(FileNotFoundError, match="there is no folder"):
        Saved(folder, tmp_path / "none" / "plan.json")
    with pytest.raises(ValueError, match="ends in"):
        Saved(folder, tmp_path / "none")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"version": 2}, "version = 2: expected 1"),
        ({"design": [1.0]}, "design of 1 numbers: expected 2"),
        ({"problem": "os:system"}, "os:system"),
        ({"options": []}, "options"),
    ],
)
def test_a_file_of_another_form_is_refused(change, message, stand_in):
    document = {"format": "mgeo-solution", "version": 1, "problem": "cantilever", "options": {}}
    with pytest.raises((ValueError, TypeError), match=message):
        solution_of({**document, "design": [0.02, 0.5], **change})
