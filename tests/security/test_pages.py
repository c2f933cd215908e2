"""Pages of studies, plans and calibrations show hostile texts, and their elements stay the same."""

import dataclasses
import json

import pytest
from mgeo_attitude.plan import read_json, write_plan
from mgeo_calibration.calibration import read_json as read_calibration
from mgeo_calibration.calibration import report_html
from typer.testing import CliRunner

from mgeo.cli import app

from ..test_old_files import OLD
from .test_report import HOSTILE, Handlers

# on one line, and no place of a label where something is put in
EVIL = " ".join(text for text in HOSTILE if text.isprintable() and "{" not in text)
TEXTS = ("harmless", EVIL)
STUDY = """
title = {text}
evaluations = 40
seeds = [1, 2]
[[problems]]
name = "pymoo:zdt1"
label = {text}
[[problems]]
name = "pymoo:zdt2"
[[algorithms]]
name = "mgeo-real"
n_walkers = 2
label = {text}
[[algorithms]]
name = "mgeo-real"
n_walkers = 3
"""


class Elements(Handlers):
    """The elements of a page, in their order, with the names of their attributes."""

    def __init__(self, html):
        super().__init__()
        self.found = []
        self.feed(html)
        self.close()
        assert self.seen == []

    def handle_starttag(self, tag, attributes):
        super().handle_starttag(tag, attributes)
        self.found.append((tag, *(name for name, _ in attributes)))


def check_same(pages):
    """Of a page with harmless texts and one with hostile ones."""
    harmless, hostile = pages
    assert "owned" in hostile
    assert Elements(harmless).found == Elements(hostile).found


def mgeo(*arguments):
    done = CliRunner().invoke(app, [str(each) for each in arguments])
    assert done.exit_code == 0, done.output


def test_elements_are_seen_where_scripts_end():
    assert Elements("<script>a</script><script>'</script><b id=1>").found == [
        ("script",), ("script",), ("b", "id"),
    ]  # fmt: skip


@pytest.mark.slow
def test_studies(tmp_path):
    made = []
    for number, text in enumerate(TEXTS):
        file, out = tmp_path / f"{number}.toml", tmp_path / f"{number}"
        file.write_text(STUDY.format(text=json.dumps(text)))
        mgeo("study", file, "--out", out, "--jobs", 1, "-q")
        found = list(out.rglob("*.html"))
        of_both = [path for path in found if path.parent == out]
        of_zdt2 = [path for path in found if path.parent.name == "zdt2"]
        (of_the_other,) = set(found) - {*of_both, *of_zdt2}
        made.append([*of_both, *of_zdt2, of_the_other])
    for pages in zip(*made, strict=True):
        check_same([path.read_text(encoding="utf-8") for path in pages])


@pytest.mark.slow
def test_plans(tmp_path):
    plan = read_json(OLD / "0.1" / "plan.json")
    pages = []
    for number, text in enumerate(TEXTS):
        named = dataclasses.replace(plan, scenario=dataclasses.replace(plan.scenario, name=text))
        write_plan(named, tmp_path / f"{number}.json")
        page = tmp_path / f"{number}.html"
        mgeo("attitude", "show", tmp_path / f"{number}.json", "--html", page)
        pages.append(page.read_text(encoding="utf-8"))
    check_same(pages)


def test_calibrations():
    calibration = read_calibration(OLD / "0.1" / "calibration.json")
    named = [
        dataclasses.replace(
            calibration,
            scenario=dataclasses.replace(calibration.scenario, name=text),
            notes=(text, text),
            tests=tuple(dataclasses.replace(test, sensor=text) for test in calibration.tests),
        )
        for text in TEXTS
    ]
    check_same([report_html(each) for each in named])
