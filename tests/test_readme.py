"""What the README shows works as it stands there."""

import re
from pathlib import Path

import plotly.graph_objects as go
import pytest

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")


def blocks(language):
    return re.findall(rf"```{language}\n(.*?)```", README, re.DOTALL)


def test_there_are_exactly_two_commands_of_one_line_each():
    commands = blocks("sh")
    assert [command.count("\n") for command in commands] == [1, 1]
    assert "mgeo solve attitude" in commands[0]
    assert "/bin/pytest" in commands[1]


def test_the_python_code_runs(monkeypatch, capsys):
    (code,) = blocks("python")
    assert len(code.splitlines()) <= 10
    assert "20_000" in code  # at this size it is for people; a few generations will do here
    shown = []
    monkeypatch.setattr(go.Figure, "show", lambda figure: shown.append(figure))
    exec(code.replace("20_000", "1_080"), {})
    assert "t_end [s]" in capsys.readouterr().out
    assert len(shown) == 1


def test_links_into_the_repository_lead_somewhere():
    targets = re.findall(r"\]\((?!https?://)([^)#]+)\)", README)
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
