"""Execute the notebooks of this folder and store their outputs, with figures as PNG.

``python notebooks/execute.py`` executes all notebooks, and ``python notebooks/execute.py FILE ...``
some of them. It needs the packages of the extra ``dev``, and Chrome or Chromium.
"""

import hashlib
import io
import os
import sys
from base64 import b64decode, b64encode
from pathlib import Path

import nbformat
from nbclient import NotebookClient
from PIL import Image


def compute_code_digest(notebook: nbformat.NotebookNode) -> str:
    """Return a digest of the code cells. Outputs with another digest are out of date."""
    code = [cell.source for cell in notebook.cells if cell.cell_type == "code"]
    return hashlib.sha256("\n".join(code).encode()).hexdigest()[:16]


def reduce_png(text: str) -> str:
    """Return a base64-encoded PNG image with 256 colors, about a quarter of its size."""
    image, file = Image.open(io.BytesIO(b64decode(text))), io.BytesIO()
    image.convert("RGB").quantize(256).save(file, "PNG", optimize=True)
    return b64encode(file.getvalue()).decode()


def execute_notebook(path: Path) -> None:
    """Execute a notebook, and write it back without warnings, times and version numbers."""
    notebook = nbformat.read(path, as_version=4)
    NotebookClient(notebook, timeout=None, record_timing=False).execute()
    for cell in notebook.cells:
        if cell.cell_type == "code":
            cell.outputs = [output for output in cell.outputs if output.get("name") != "stderr"]
            for output in cell.outputs:
                if "image/png" in output.get("data", {}):
                    output.data["image/png"] = reduce_png(output.data["image/png"])
    notebook.metadata.language_info = {"name": "python"}
    notebook.metadata.executed_code = compute_code_digest(notebook)
    nbformat.write(notebook, path)


if __name__ == "__main__":
    os.environ["PLOTLY_RENDERER"] = "png"  # Interactive figures would be megabytes.
    paths = map(Path, sys.argv[1:]) if sys.argv[1:] else Path(__file__).parent.glob("*.ipynb")
    for path in sorted(paths):
        execute_notebook(path)
        print(f"{path.name}: {path.stat().st_size / 1e3:.0f} kB")
