"""What the README shows works as it stands there."""

import re
import tomllib
from pathlib import Path

import plotly.graph_objects as go
import pytest
import yaml

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")
READMES = {"README.md", "README.pt-BR.md"}


def blocks(language):
    return re.findall(rf"```{language}\n(.*?)```", README, re.DOTALL)


def test_there_are_exactly_two_commands_of_one_line_each():
    commands = blocks("sh")
    assert [command.count("\n") for command in commands] == [1, 1]
    assert "mgeo solve attitude" in commands[0]
    assert "/bin/pytest" in commands[1]


@pytest.mark.slow
def test_the_python_code_runs(monkeypatch, capsys):
    (code,) = blocks("python")
    assert len(code.splitlines()) <= 10
    assert "20_000" in code  # at this size it is for people; a few generations will do here
    shown = []
    monkeypatch.setattr(go.Figure, "show", lambda figure: shown.append(figure))
    exec(code.replace("20_000", "1_080"), {})
    assert "9 of 10 Monte Carlo samples keep attitude" in capsys.readouterr().out
    assert len(shown) == 1


PORTUGUESE = (ROOT / "README.pt-BR.md").read_text(encoding="utf-8")


def test_the_portuguese_one_has_the_same_commands_figures_and_numbers():
    def of(text):
        prose = re.sub(r"```.*?```", "", text, flags=re.DOTALL)
        return {
            "blocks": re.findall(r"```(\w+)\n(.*?)```", text, re.DOTALL),
            "pictures": re.findall(r"!\[[^\]]*\]\(([^)]*)\)", text),
            "links": sorted(set(re.findall(r"(?<!!)\[[^\]]*\]\(([^)]*)\)", text)) - READMES),
            "code": sorted(re.findall(r"`([^`\n]+)`", prose)),
            "numbers": sorted(re.findall(r"\d[\d,.]*\d|\d", prose.replace("pt-BR", ""))),
            "headings": len(re.findall(r"^#", text, re.MULTILINE)),
            "rows": len(re.findall(r"^\|", text, re.MULTILINE)),
            "points": len(re.findall(r"^- ", text, re.MULTILINE)),
        }

    as_in_english = PORTUGUESE.replace("docs/artigo.md", "docs/paper.md")
    as_in_english = as_in_english.replace("docs/primeiros-passos.md", "docs/tutorial.md")
    as_in_english = re.sub(r"(?<=\d)\.(?=\d{3}\b)", "\0", as_in_english)  # thousands
    as_in_english = re.sub(r"(?<=\d),(?=\d)", ".", as_in_english).replace("\0", ",")
    english, portuguese = of(README), of(as_in_english)
    for part, found in english.items():
        assert portuguese[part] == found, part


def test_each_leads_to_the_other():
    assert "](README.pt-BR.md)" in README
    assert "](README.md)" in PORTUGUESE


def test_sentences_are_short():
    prose = re.sub(r"```.*?```|^\|.*$|^!.*$", "", README, flags=re.DOTALL | re.MULTILINE)
    prose = re.sub(r"\]\([^)]*\)", "]", prose)
    for paragraph in re.split(r"\n\n|\n- |\n#+ ", prose):
        for sentence in re.split(r"(?<=[.:;?!])\s", paragraph.replace("\n", " ")):
            assert len(sentence.split()) <= 25, sentence
    assert len(README.split()) <= 439  # half of what it was once


def test_the_citation_names_the_paper_and_this_version():
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert (citation["cff-version"], citation["type"]) == ("1.2.0", "software")
    assert (citation["version"], citation["license"]) == (project["version"], project["license"])
    assert citation["preferred-citation"]["journal"] == "Shock and Vibration"
    page = (ROOT / "docs" / "citing.md").read_text(encoding="utf-8")
    assert f"version = {{{project['version']}}}" in page
    for cited in (citation["preferred-citation"], *citation["references"]):
        assert " ".join(cited["title"].split()) in " ".join(page.replace("*", "").split())


@pytest.mark.parametrize("text", [README, PORTUGUESE], ids=["english", "portuguese"])
def test_links_into_the_repository_lead_somewhere(text):
    targets = re.findall(r"\]\((?!https?://)([^)#]+)", text)
    assert len(targets) >= 5
    missing = [target for target in targets if not (ROOT / target).exists()]
    assert not missing


def test_main_sentence():
    """The sentence of the design that must always work, at the size of a test."""
    from mgeo_attitude import AttitudeManeuverProblem
    from pymoo.optimize import minimize

    from mgeo import MGEOReal

    one = minimize(AttitudeManeuverProblem(), MGEOReal(sigma=1.0), ("n_gen", 3), seed=1)
    two = minimize(AttitudeManeuverProblem(threads=1), MGEOReal(sigma=1.0), ("n_gen", 3), seed=1)
    assert one.F.tolist() == two.F.tolist()
    assert one.X.tolist() == two.X.tolist()
    assert one.algorithm.evaluator.n_eval == 3 * 360
    assert pytest.approx(AttitudeManeuverProblem().evaluate(one.X), rel=0) == one.F
