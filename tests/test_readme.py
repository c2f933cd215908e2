"""The README's code, and its translation."""

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


def blocks(text):
    """Return (language, code) of each code block."""
    return re.findall(r"```(\w+)\n(.*?)```", text, re.DOTALL)


@pytest.mark.slow
def test_python(monkeypatch, capsys):
    (code,) = (code for language, code in blocks(ENGLISH) if language == "python")
    assert "20_000" in code
    shown = []
    monkeypatch.setattr(go.Figure, "show", lambda figure: shown.append(figure))
    exec(code.replace("20_000", "1_080"), {})
    assert "deg in 9 of 10 Monte Carlo runs" in capsys.readouterr().out
    assert len(shown) == 1


def test_commands_and_code_are_those_of_the_translation():
    """`.ci/run` executes the first two commands."""
    assert blocks(PORTUGUESE) == blocks(ENGLISH)
    commands = [code for language, code in blocks(ENGLISH) if language == "sh"]
    assert "mgeo solve attitude" in commands[0]
    assert "/bin/pytest" in commands[1]


@pytest.mark.parametrize("text", [ENGLISH, PORTUGUESE], ids=["english", "portuguese"])
def test_links_lead_to_files(text):
    targets = re.findall(r"\]\((?!https?://)([^)#]+)", text)
    assert len(targets) >= 5
    assert [target for target in targets if not (ROOT / target).exists()] == []


def test_the_main_statement():
    """The same seed gives the same front on any number of threads."""
    one = minimize(AttitudeManeuverProblem(), MGEOReal(sigma=1.0), ("n_gen", 3), seed=1)
    two = minimize(AttitudeManeuverProblem(threads=1), MGEOReal(sigma=1.0), ("n_gen", 3), seed=1)
    assert one.F.tolist() == two.F.tolist()
    assert one.X.tolist() == two.X.tolist()
    assert one.algorithm.evaluator.n_eval == 3 * 360
    assert pytest.approx(AttitudeManeuverProblem().evaluate(one.X), rel=0) == one.F
