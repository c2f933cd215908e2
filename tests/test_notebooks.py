"""The notebooks are committed without outputs, and run from top to bottom at their small size."""

from pathlib import Path

import nbformat
import pytest
from nbclient import NotebookClient

ROOT = Path(__file__).parents[1]
NOTEBOOKS = sorted((ROOT / "notebooks").glob("*.ipynb"))
FIGURES = {
    "1_first_run": 3,
    "2_the_paper": 2,
    "3_comparing_algorithms": 3,
    "4_real_limits": 2,
    "5_a_problem_plugin": 1,
    "6_which_sensors": 3,
}

every_notebook = pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)


def read(path):
    return nbformat.read(path, as_version=4)


def listing(folder):
    return {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}


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


@pytest.mark.slow
@every_notebook
def test_it_runs(path, monkeypatch):
    """Without an error, a word on stderr, or a file left behind; every figure is drawn."""
    if "basilisk" in path.read_text(encoding="utf-8"):
        pytest.importorskip(
            "Basilisk", reason='flights by Basilisk: pip install "./problems/attitude[basilisk]"'
        )
    monkeypatch.setenv("MGEO_NOTEBOOK_SMALL", "1")
    monkeypatch.setenv("PLOTLY_RENDERER", "plotly_mimetype")
    before = listing(path.parent)
    notebook = read(path)
    where = {"metadata": {"path": str(path.parent)}}
    NotebookClient(notebook, timeout=300, kernel_name="python3", resources=where).execute()
    outputs = [o for cell in notebook.cells if cell.cell_type == "code" for o in cell.outputs]
    assert [o.text for o in outputs if o.get("name") == "stderr"] == []
    figures = [
        o.data["application/vnd.plotly.v1+json"]
        for o in outputs
        if "application/vnd.plotly.v1+json" in o.get("data", {})
    ]
    assert len(figures) == FIGURES[path.stem]
    assert all(figure["data"] for figure in figures)
    assert listing(path.parent) == before
