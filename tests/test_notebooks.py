"""Text and stored outputs of the notebooks; `tests/docs/test_site.py` executes their code."""

import re
import runpy
from pathlib import Path

import nbformat
import pytest

FOLDER = Path(__file__).parents[1] / "notebooks"
PATHS = sorted(FOLDER.glob("*.ipynb"))
MAX_SIZE = 300_000  # bytes


@pytest.fixture(params=PATHS, ids=lambda path: path.stem)
def path(request):
    """Path of one notebook."""
    return request.param


@pytest.fixture
def notebook(path):
    """Content of the notebook."""
    return nbformat.read(path, as_version=4)


@pytest.fixture(scope="module")
def compute_code_digest():
    """Function of `notebooks/execute.py`."""
    pytest.importorskip("nbclient", reason='pip install ".[docs]"')
    return runpy.run_path(str(FOLDER / "execute.py"))["compute_code_digest"]


def test_outputs_belong_to_the_code(notebook, compute_code_digest):
    """If the code changes, `python notebooks/execute.py` must follow."""
    nbformat.validate(notebook)
    assert notebook.metadata.executed_code == compute_code_digest(notebook)
    code_cells = [cell for cell in notebook.cells if cell.cell_type == "code"]
    assert [cell.execution_count for cell in code_cells] == list(range(1, len(code_cells) + 1))


def test_outputs_are_small_and_without_warnings(notebook, path):
    outputs = [output for cell in notebook.cells for output in cell.get("outputs", ())]
    assert {output.output_type for output in outputs} <= {
        "display_data",
        "execute_result",
        "stream",
    }
    assert all(output.get("name") != "stderr" for output in outputs)
    assert any("image/png" in output.get("data", {}) for output in outputs)
    assert path.stat().st_size < MAX_SIZE


@pytest.mark.parametrize("number", range(1, 6))
def test_title_has_the_number_of_the_file_and_a_message(number):
    (path,) = FOLDER.glob(f"{number}_*.ipynb")
    title, message = nbformat.read(path, as_version=4).cells[0].source.split("\n\n")[:2]
    assert title.startswith(f"# {number}. ")
    assert re.fullmatch(r"\*\*[^*]+\.\*\*", message)


def test_links_refer_to_existing_files(notebook):
    text = "\n".join(cell.source for cell in notebook.cells if cell.cell_type == "markdown")
    targets = re.findall(r"\]\((?!https?://)([^)#]+)", text)
    assert targets
    assert [target for target in targets if not (FOLDER / target).is_file()] == []
