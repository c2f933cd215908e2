"""Build pages that show results of studies again if the stored results change."""

from pathlib import Path
from typing import Any

from sphinx.application import Sphinx

_STUDIES = Path(__file__).parents[1] / "studies"
_READERS = ("studies/", "explanation/paper", "explanation/algorithms", "pt/artigo")


def note_dependencies(app: Sphinx, docname: str, source: list[str]) -> None:
    if docname.startswith(_READERS):
        for path in (*_STUDIES.glob("*.py"), *_STUDIES.glob("*.toml"), *_STUDIES.rglob("*.csv")):
            app.env.note_dependency(str(path), docname=docname)


def setup(app: Sphinx) -> dict[str, Any]:
    app.connect("source-read", note_dependencies)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
