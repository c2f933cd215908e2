"""Sphinx configuration of the site. ``sphinx-build -W docs docs/_build`` builds it without network.

The symbolic link ``docs/tutorials/notebooks`` includes the notebooks of ``../notebooks`` as pages.
"""

import gc
import os
import re
import sys
from importlib.metadata import version as installed
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parent / "_extensions"))

from content import compute_digest
from jupyter_cache import get_cache

# Document trees have many reference cycles and live until the end of the build. At the default
# thresholds, garbage collection would take a quarter of the time.
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

# Notebooks and pages with code are executed once. The key of the cache is their text, and the name
# of its folder is the digest of everything else on which they depend. MGEO_NOTEBOOK_SMALL shortens
# the notebooks: kernels then start with a small number of Monte Carlo runs.
if "MGEO_NOTEBOOK_SMALL" in os.environ:
    os.environ["PYTHONSTARTUP"] = str(Path(__file__).parent / "_extensions" / "few_runs.py")
nb_execution_mode = "cache"
nb_execution_cache_path = str(
    Path(__file__).parent / "_build" / "executed" / compute_digest(Path(__file__).parents[1])
)
# Create the tables of the cache here. If two processes started with an empty cache, one would fail.
get_cache(nb_execution_cache_path).list_cache_records()
nb_execution_raise_on_error = True
nb_execution_timeout = 600
nb_merge_streams = True
nb_output_stderr = "remove"  # messages of compiled kernels
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


#: Slow pages that are read last, so that two processes end at about the same time.
_LAST = ("studies/results", "explanation/paper")


def setup(app: Any) -> None:
    """Read the slowest page first, so that two processes (``-j 2``) end at about the same time."""
    app.connect("env-before-read-docs", lambda app, env, names: names.sort(key=_rank_page))
    app.connect("source-read", _adapt_notebook_links)


def _rank_page(name: str) -> int:
    return (name in _LAST) - (name == "tutorials/attitude-control")


def _adapt_notebook_links(app: Any, name: str, source: list[str]) -> None:
    """Make links of notebooks relative to ``docs``, because Sphinx resolves the symbolic link to
    their folder outside of ``docs``.
    """
    if name.startswith("tutorials/notebooks/"):
        text = source[0].replace("](../docs/", "](/")
        notebook_link = r"\[([^][\n]+)\]\((\w+)\.ipynb\)"
        source[0] = re.sub(notebook_link, r"{doc}`\1 </tutorials/notebooks/\2>`", text)
