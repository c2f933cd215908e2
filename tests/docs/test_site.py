"""The site: built without a warning, complete, and shown by a browser without a network."""

import json
import os
import re
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import nbformat
import pytest
from sphinx.util.inventory import InventoryFile

from mgeo.studies import read_study

from ..browser import find_browser
from ..test_notebooks import FIGURES, NOTEBOOKS
from .test_reference import MODULES

ROOT = Path(__file__).parents[2]
SOURCES = (ROOT / "mgeo", ROOT / "problems" / "attitude" / "mgeo_attitude")

#: Numbers of equations by label; code and pages cite them as numbers.
NUMBERS = {
    "state": 1,
    "model": 2,
    "predict": 3,
    "update": 4,
    "objectives": 5,
    "converged": 6,
    "discretization": 7,
    "cholesky": 8,
    "step": 9,
    "rank": 10,
    "indicators": 11,
    "ramp": 12,
    "criterion": 13,
    "clearance": 14,
    "triad": 15,
    "pointing-rate": 16,
    "budget": 17,
    "disturbance": 18,
    "share": 19,
    "all-else-known": 20,
    "fill": 21,
    "inertial": 22,
    "traces": 23,
    "mean": 24,
    "drift": 25,
    "bias": 26,
    "ending": 27,
    "alike": 28,
    "follow": 29,
}

pytestmark = pytest.mark.slow


def listing(folder):
    return {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """The site's folder; its notebooks run as they do for readers, and leave nothing behind."""
    pytest.importorskip("myst_nb", reason='the site: pip install ".[docs]"')
    if any("basilisk" in path.read_text(encoding="utf-8") for path in NOTEBOOKS):
        pytest.importorskip(
            "Basilisk", reason='flights by Basilisk: pip install "./problems/calibration[basilisk]"'
        )
    out = tmp_path_factory.mktemp("site")
    before = listing(ROOT / "notebooks")
    command = [sys.executable, "-m", "sphinx", "-W", "--keep-going", "-q", "-b", "html"]
    done = subprocess.run(
        [*command, "-d", str(out / "doctrees"), str(ROOT / "docs"), str(out / "html")],
        capture_output=True,
        text=True,
        check=False,
        env=os.environ | {"MGEO_NOTEBOOK_SMALL": "1"},
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert listing(ROOT / "notebooks") == before
    return out / "html"


@pytest.fixture(scope="module")
def executed(site):
    """The notebooks with the outputs of the build, which keeps them by what they depend on."""
    from jupyter_cache import get_cache

    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(ROOT / "docs" / "_extensions")
        patch.setenv("MGEO_NOTEBOOK_SMALL", "1")
        from content import digest

        cache = get_cache(ROOT / "docs" / "_build" / "executed" / digest(ROOT))
    sys.modules.pop("content")

    def outputs(path):
        notebook = nbformat.read(path, as_version=4)
        made = cache.get_cache_bundle(cache.match_cache_notebook(notebook).pk).nb
        return [o for cell in made.cells if cell.cell_type == "code" for o in cell.outputs]

    return outputs


@pytest.fixture(scope="module")
def browser():
    return find_browser()


def shown(browser, path, profile):
    """The page's elements after its scripts have run, without any network."""
    command = [
        browser,
        "--headless",
        "--no-sandbox",
        "--disable-gpu",
        "--disable-background-networking",
        "--disable-component-update",
        "--disable-sync",
        "--no-first-run",
        "--proxy-server=127.0.0.1:9",  # where nobody listens
        f"--user-data-dir={profile}",
        "--virtual-time-budget=8000",
        "--dump-dom",
        path.as_uri(),
    ]
    done = subprocess.run(command, capture_output=True, text=True, check=True, timeout=120)
    return done.stdout


def test_every_page_is_there(site):
    pages = {path.relative_to(ROOT / "docs") for path in (ROOT / "docs").rglob("*.md")}
    assert len(pages) > 10
    notebooks = {path.relative_to(ROOT) for path in (ROOT / "notebooks").glob("*.ipynb")}
    assert len(notebooks) == 5
    pages |= notebooks
    for path in pages:
        assert (site / path).with_suffix(".html").is_file(), path


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_runs_without_a_word_on_stderr_and_draws_its_figures(executed, path):
    """An error would have ended the build."""
    outputs = executed(path)
    said = "".join(o.text for o in outputs if o.get("name") == "stderr")
    about = r"^compil(ing the .*, once per machine \(some seconds\)|ed in .* s, kept in .*)\n"
    new = re.sub(about, "", said, flags=re.M)
    assert new == ""  # but where the kernels were not there yet
    mime = "application/vnd.plotly.v1+json"
    figures = [o.data[mime] for o in outputs if mime in o.get("data", {})]
    assert len(figures) == FIGURES[path.stem]
    assert all(figure["data"] for figure in figures)


def test_nothing_is_loaded_from_elsewhere(site):
    """Scripts, styles and images are the site's own, and exist."""
    tags = re.compile(r"<(?:script|link|img|iframe|source)\b[^>]*?\b(?:src|href)=\"([^\"#?]*)")
    loaded = 0
    for path in site.rglob("*.html"):
        for target in tags.findall(path.read_text(encoding="utf-8")):
            assert not re.match(r"(\w+:)?//", target), f"{path.name} loads {target}"
            if not target.startswith("data:"):
                assert (path.parent / target).exists(), f"{path.name} loads {target}"
                loaded += 1
    assert loaded > 100
    for path in (site / "_static").rglob("*.css"):
        assert not re.search(r"(url\(|@import)\s*[\"']?(https?:)?//", path.read_text("utf-8")), path


def test_links_between_pages_lead_somewhere(site):
    links = 0
    for path in site.rglob("*.html"):
        for target in re.findall(r"<a\b[^>]*?\bhref=\"([^\"]+)\"", path.read_text("utf-8")):
            if re.match(r"\w+:", target):
                continue
            name, _, anchor = target.partition("#")
            page = (path.parent / name) if name else path
            assert page.is_file(), f"{path.name} links to {target}"
            if anchor:
                assert f'id="{anchor}"' in page.read_text("utf-8"), f"{path.name}: {target}"
            links += 1
    assert links > 500


def test_no_page_is_heavy_and_none_tells_where_it_was_built(site):
    for path in site.rglob("*.html"):
        text = path.read_text(encoding="utf-8")
        assert len(text) < 6_000_000, path
        assert str(ROOT) not in text, path


def test_equations_have_the_numbers_that_are_cited(site):
    text = (site / "theory.html").read_text(encoding="utf-8")
    found = re.findall(r'id="equation-([\w-]+)"[^>]*>\s*<span class="eqno">\((\d+)\)', text)
    assert {label: int(number) for label, number in found} == NUMBERS
    cited = set()
    for path in [*(p for source in SOURCES for p in source.rglob("*.py")),
                 *(ROOT / "docs").rglob("*.md")]:  # fmt: skip
        for numbers in re.findall(
            r"[Ee]quations? (\(\d+\)(?:(?:,| and| to) \(\d+\))*)", path.read_text("utf-8")
        ):
            cited |= {int(number) for number in re.findall(r"\d+", numbers)}
    assert {2, 3, 4, 5} <= cited <= set(NUMBERS.values())


def test_the_pages_of_keys_have_every_table(site):
    for kind, key in (("scenario", "max_duration"), ("study", "per_variable")):
        text = (site / "reference" / f"{kind}-keys.html").read_text(encoding="utf-8")
        assert "The file’s own keys" in text
        assert f">{key}<" in text


def test_the_reference_has_every_public_name(site):
    with (site / "objects.inv").open("rb") as file:
        inventory = InventoryFile.load(file, "", lambda base, target: target)
    documented = {name for domain, names in inventory.items() if domain.startswith("py:")
                  for name in names}  # fmt: skip
    for module in MODULES:
        public = import_module(module).__all__
        missing = {
            name
            for name in public
            if not any(full.rpartition(".")[2] == name for full in documented)
        }
        assert not missing, f"{module}: {missing}"


def test_a_browser_shows_index_and_equations(site, browser, tmp_path):
    assert "Getting started" in shown(browser, site / "index.html", tmp_path)
    assert shown(browser, site / "theory.html", tmp_path).count("<math") >= len(NUMBERS)


def test_a_browser_draws_the_interactive_figure(site, browser, tmp_path):
    """Plotly replaces empty boxes by drawings: two fronts, and those of tracker and wheels."""
    before = (site / "limits.html").read_text(encoding="utf-8")
    after = shown(browser, site / "limits.html", tmp_path)
    assert "main-svg" not in before.partition("<body")[2]
    assert "main-svg" in after
    assert len(re.findall(r'<g class="trace scatter', after)) == 10


@pytest.mark.parametrize(
    ("page", "figures", "tables"),
    [
        ("notebooks/1_first_run", 3, 3),
        ("notebooks/2_comparing_algorithms", 3, 2),
        ("paper", 3, 4),
        ("studies/tuning", 1, 1),
        ("studies/results", 3, 29),
        ("studies/directed", 1, 2),
    ],
)
def test_a_browser_draws_what_code_on_a_page_shows(site, browser, tmp_path, page, figures, tables):
    after = shown(browser, site / f"{page}.html", tmp_path)
    assert after.count('<div class="plotly-box">') == figures
    drawn = re.findall(r'<div id="figure-[\d-]+" class="plotly-graph-div js-plotly-plot"', after)
    assert len(drawn) == figures
    assert after.count("<table") == tables


def test_the_tutorial_leads_to_a_second_calibration(site):
    """Figures, two tables to command, and in the last table what came out of both flights."""
    text = (site / "tutorial.html").read_text(encoding="utf-8")
    assert text.count('<div class="plotly-box">') == 3
    assert text.count("command,what,start_utc") == 2
    rows = re.findall(r"<tr>\s*<th>([\w.]+)</th>(.*?)</tr>", text, re.DOTALL)
    table = {block: re.findall("<td>(.*?)</td>", row) for block, row in rows}
    assert {block.partition(".")[0] for block in table} == {"gyro", "sun", "mag"}
    for block, (_, before, _, first, _, second, error) in table.items():
        assert float(first) < float(before)
        assert float(second) < float(first) or block == "gyro.bias"  # which drifts
        assert float(error) < 5.0


def test_the_pages_of_studies_say_how_much_of_them_is_shown(site):
    studies = ROOT / "docs" / "studies"
    sizes = {
        name: page.relative_to(ROOT / "docs").with_suffix(".html")
        for page in (ROOT / "docs").rglob("*.md")
        for name in re.findall(r'^size\("([\w-]+)"\)$', page.read_text(encoding="utf-8"), re.M)
    }
    assert len(sizes) >= 5
    for name, page in sizes.items():
        study = read_study(studies / f"{name}.toml")
        made = json.loads(next((studies / "data" / name).rglob("provenance.json")).read_text())
        text = (site / page).read_text(encoding="utf-8")
        size = (made["evaluations"], len(made["seeds"]))
        assert f"{size[0]:,} evaluations, {size[1]} seeds</strong>" in text
        reduced = size != (study.evaluations, len(study.seeds))
        assert ("Nothing follows from these numbers" in text) == reduced
