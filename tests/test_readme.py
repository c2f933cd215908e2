"""Code of the README, and its translation."""

import re
from pathlib import Path

import plotly.graph_objects as go
import pytest
from mgeo_attitude import AttitudeManeuverProblem
from pymoo.optimize import minimize

from mgeo import MGEOReal

ROOT = Path(__file__).parents[1]
ENGLISH, PORTUGUESE = (
    (ROOT / name).read_text(encoding="utf-8") for name in ("README.md", "README.pt-BR.md")
)


def list_code_blocks(text):
    """Return the language and the code of each code block of a Markdown text."""
    return re.findall(r"```(\w+)\n(.*?)```", text, re.DOTALL)


@pytest.mark.slow
def test_python_code_prints_plans_and_shows_front(monkeypatch, capsys):
    (code,) = (code for language, code in list_code_blocks(ENGLISH) if language == "python")
    assert "20_000" in code
    figures = []
    monkeypatch.setattr(go.Figure, "show", lambda figure: figures.append(figure))
    exec(code.replace("20_000", "1_080"), {})
    head, *rows = capsys.readouterr().out.splitlines()
    (output,) = (text for language, text in list_code_blocks(ENGLISH) if language == "text")
    assert head.split() == output.splitlines()[0].split()
    assert rows
    assert len(figures) == 1


def test_translation_has_equal_code_blocks():
    """`.ci/run` executes the first two commands."""
    assert list_code_blocks(PORTUGUESE) == list_code_blocks(ENGLISH)
    commands = [code for language, code in list_code_blocks(ENGLISH) if language == "sh"]
    assert "mgeo solve attitude" in commands[0]
    assert "/bin/pytest" in commands[1]


@pytest.mark.parametrize("text", [ENGLISH, PORTUGUESE], ids=["english", "portuguese"])
def test_links_refer_to_existing_files(text):
    targets = re.findall(r"\]\((?!https?://)([^)#]+)", text)
    assert len(targets) >= 5
    assert [target for target in targets if not (ROOT / target).exists()] == []


def test_equal_seeds_give_equal_fronts_on_any_number_of_threads():
    first = minimize(AttitudeManeuverProblem(), MGEOReal(sigma=1.0), ("n_gen", 3), seed=1)
    second = minimize(AttitudeManeuverProblem(threads=1), MGEOReal(sigma=1.0), ("n_gen", 3), seed=1)
    assert first.F.tolist() == second.F.tolist()
    assert first.X.tolist() == second.X.tolist()
    assert first.algorithm.evaluator.n_eval == 3 * 360
    assert pytest.approx(AttitudeManeuverProblem().evaluate(first.X), rel=0) == first.F
