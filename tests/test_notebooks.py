"""The notebooks are committed without outputs; `tests/docs/test_site.py` runs them."""

from pathlib import Path

import nbformat
import pytest

ROOT = Path(__file__).parents[1]
NOTEBOOKS = sorted((ROOT / "notebooks").glob("*.ipynb"))
FIGURES = {
    "1_first_run": 3,
    "2_comparing_algorithms": 3,
    "3_real_limits": 2,
    "4_a_problem_plugin": 1,
    "5_which_sensors": 3,
}

every_notebook = pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)


def read(path):
    return nbformat.read(path, as_version=4)


def test_all_are_here():
    assert {path.stem for path in NOTEBOOKS} == set(FIGURES)


@every_notebook
def test_it_is_committed_without_outputs(path):
    """Nothing of a run or of a machine is in it, and saving it again changes nothing."""
    text = path.read_text(encoding="utf-8")
    notebook = read(path)
    nbformat.validate(notebook)
    assert nbformat.writes(notebook, indent=1).rstrip("\n") + "\n" == text
    assert set(notebook.metadata) <= {"kernelspec", "language_info"}
    assert set(notebook.metadata.language_info) == {"name"}
    for cell in notebook.cells:
        assert not cell.metadata
        if cell.cell_type == "code":
            assert cell.outputs == []
            assert cell.execution_count is None
    assert sum(cell.cell_type == "code" for cell in notebook.cells) >= 6
