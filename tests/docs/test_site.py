"""The site builds without a warning, its links lead somewhere, and it needs no network."""

import os
import re
import subprocess
import sys

import pytest

from ..browser import find_browser
from .pages import DOCS

ROOT = DOCS.parent
SOURCES = (*(ROOT / "mgeo").rglob("*.py"), *(ROOT / "problems").rglob("*.py"), *DOCS.rglob("*.md"))

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """The folder of the site, with short notebooks."""
    pytest.importorskip("myst_nb", reason='pip install ".[docs]"')
    pytest.importorskip("Basilisk", reason='pip install "./problems/calibration[basilisk]"')
    out = tmp_path_factory.mktemp("site")
    command = [sys.executable, "-m", "sphinx", "-W", "--keep-going", "-q", "-b", "html"]
    done = subprocess.run(
        [*command, "-d", str(out / "doctrees"), str(DOCS), str(out / "html")],
        capture_output=True,
        text=True,
        check=False,
        env=os.environ | {"MGEO_NOTEBOOK_SMALL": "1"},
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return out / "html"


def test_links_and_files_exist_and_nothing_is_loaded_from_elsewhere(site):
    texts = {path.resolve(): path.read_text(encoding="utf-8") for path in site.rglob("*.html")}
    loads = re.compile(r"<(?:script|link|img|iframe|source)\b[^>]*?\b(?:src|href)=\"([^\"#?]*)")
    n_loaded = n_links = 0
    for path, text in texts.items():
        assert str(ROOT) not in text, path
        for target in loads.findall(text):
            assert not re.match(r"(?!data:)(\w+:)?//", target), f"{path.name} loads {target}"
            if not target.startswith("data:"):
                assert (path.parent / target).exists(), f"{path.name} loads {target}"
                n_loaded += 1
        for target in re.findall(r"<a\b[^>]*?\bhref=\"([^\"]+)\"", text):
            if re.match(r"\w+:", target):
                continue
            name, _, anchor = target.partition("#")
            page = (path.parent / name).resolve() if name else path
            assert page.is_file(), f"{path.name} links to {target}"
            if anchor:
                assert f'id="{anchor}"' in texts[page], f"{path.name} links to {target}"
            n_links += 1
    assert n_loaded > 100
    assert n_links > 500
    for path in (site / "_static").rglob("*.css"):
        assert not re.search(r"(url\(|@import)\s*[\"']?(https?:)?//", path.read_text("utf-8")), path


def test_cited_equations_exist(site):
    """A citation names its page, or means the page of models and filter."""
    numbers = {}
    for path in (site / "explanation").glob("*.html"):
        text = path.read_text(encoding="utf-8")
        found = [int(number) for number in re.findall(r'<span class="eqno">\((\d+)\)', text)]
        assert found == list(range(1, len(found) + 1))
        assert text.count("<math") >= len(found)
        numbers[path.stem] = set(found)
    cited = {page: set() for page in numbers}
    citation = re.compile(
        r"[Ee]quations?\s+(\(\d+\)(?:(?:,| and| to) \(\d+\))*)"
        r"(?:(?:\s+of\s+docs/explanation/|\]\()([\w-]+)\.md)?"
    )
    for path in SOURCES:
        page = path.stem if path.parent.name == "explanation" else "models-and-filter"
        for found, named in citation.findall(path.read_text("utf-8")):
            cited[named or page] |= {int(number) for number in re.findall(r"\d+", found)}
    assert {2, 3, 4, 5} <= cited["models-and-filter"]
    for page, found in cited.items():
        assert found <= numbers[page], page


def test_a_browser_draws_the_figures_without_a_network(site, tmp_path):
    command = [
        find_browser(),
        "--headless",
        "--no-sandbox",
        "--disable-gpu",
        "--proxy-server=127.0.0.1:9",  # where nobody listens
        f"--user-data-dir={tmp_path}",
        "--virtual-time-budget=8000",
        "--dump-dom",
    ]
    for page, n_figures in (
        ("how-to/describe-your-satellite", 4),
        ("tutorials/notebooks/1_first_run", 3),
    ):
        path = (site / page).with_suffix(".html").as_uri()
        shown = subprocess.run(
            [*command, path], capture_output=True, text=True, check=True, timeout=120
        ).stdout
        assert len(re.findall(r'class="plotly-graph-div js-plotly-plot"', shown)) == n_figures


def test_the_tutorial_calibrates_twice(site):
    """Both flights reduce the uncertainty, and the errors are within 5 sigma."""
    text = (site / "tutorials" / "attitude-control.html").read_text(encoding="utf-8")
    rows = re.findall(r"<tr>\s*<th>([\w ]+) \[[^\]]+\]</th>(.*?)</tr>", text, re.DOTALL)
    table = {quantity: re.findall("<td>(.*?)</td>", row) for quantity, row in rows}
    assert {quantity.partition(" ")[0] for quantity in table} == {"gyro", "sun", "mag"}
    for quantity, (before, _, first, _, second, error) in table.items():
        assert float(first) < float(before)
        assert float(second) < float(first) or quantity == "gyro bias"  # which drifts
        assert float(error) < 5.0
