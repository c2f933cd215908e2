"""How the site is built: ``sphinx-build -W docs docs/_build``. Nothing in it needs a network.

The notebooks of ``../notebooks`` are pages of it, through the link ``docs/tutorials/notebooks``.
"""

import gc
import os
import re
import sys
from importlib.metadata import version as installed
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parent / "_extensions"))

from content import digest
from jupyter_cache import get_cache

# Trees of pages are full of cycles and live to the end: looked through at the usual times for
# garbage, they take a quarter of the time.
gc.set_threshold(1_000_000)

project = "mgeo"
author = "mgeo developers"
release = version = installed("mgeo")

extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx.ext.viewcode",
    "docstrings",
    "algorithms",
    "documents",
    "export_formats",
    "keys",
    "objectives",
    "mathml",
    "plotly_figures",
    "study_data",
]
exclude_patterns = ["_build", "_extensions", "_static", "jupyter_execute"]

# Notebooks and pages with code are run once: the cache knows them by their text, and its folder by
# all else that they show. MGEO_NOTEBOOK_SMALL makes the notebooks short, and kernels begin so.
if "MGEO_NOTEBOOK_SMALL" in os.environ:
    os.environ["PYTHONSTARTUP"] = str(Path(__file__).parent / "_extensions" / "few_flights.py")
nb_execution_mode = "cache"
nb_execution_cache_path = str(
    Path(__file__).parent / "_build" / "executed" / digest(Path(__file__).parents[1])
)
# The cache's tables are made here: of two processes that begin with an empty cache one would fail.
get_cache(nb_execution_cache_path).list_cache_records()
nb_execution_raise_on_error = True
nb_execution_timeout = 600
nb_merge_streams = True
nb_output_stderr = "remove"  # where a kernel is compiled it says so; the tests see to the rest
nb_render_markdown_format = "myst"

myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 3

default_role = "code"  # single backquotes in docstrings
autodoc_member_order = "bysource"
autodoc_typehints = "none"  # signatures stay short; docstrings give types, shapes and units
autodoc_preserve_defaults = True
python_use_unqualified_type_names = True
napoleon_use_rtype = False
napoleon_use_ivar = True

html_theme = "furo"
html_title = "mgeo"
html_math_renderer = "mathml"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_copy_source = False
html_show_sourcelink = False
html_show_copyright = False
pygments_style = "default"  # of contrast 4.5 and more


#: Of the pages that take seconds those that end the second of two processes with the first.
_LAST = ("studies/results", "explanation/paper")


def setup(app: Any) -> None:
    """Read first what runs longest, so that two processes (``-j 2``) end together."""
    app.connect("env-before-read-docs", lambda app, env, names: names.sort(key=_turn))
    app.connect("source-read", _adapt_notebook_links)


def _turn(name: str) -> int:
    return (name in _LAST) - (name == "tutorials/attitude-control")


def _adapt_notebook_links(app: Any, name: str, source: list[str]) -> None:
    """Let links of notebooks start from ``docs``: Sphinx follows the symbolic link to their folder,
    which is outside of ``docs``.
    """
    if name.startswith("tutorials/notebooks/"):
        text = source[0].replace("](../docs/", "](/")
        notebook_link = r"\[([^][\n]+)\]\((\w+)\.ipynb\)"
        source[0] = re.sub(notebook_link, r"{doc}`\1 </tutorials/notebooks/\2>`", text)
