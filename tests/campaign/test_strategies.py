"""What hypothesis finds: any value as a scenario, any words as a command."""

import contextlib
import os
import tempfile

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mgeo_attitude import Scenario
from typer.testing import CliRunner

from mgeo.cli.app import app
from mgeo.cli.options import parse_numbers, parse_settings

VALUES = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8),
    lambda inner: (
        st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=8), inner, max_size=3)
    ),
    max_leaves=8,
)  # fmt: skip
SECTIONS = st.sampled_from(sorted(Scenario.paper().to_dict()))
COMMANDS = ["solve", "resume", "report", "study", "problems", "show", "verify", "export"]
WORDS = st.sampled_from([*COMMANDS, "--out", "--evaluations", "-q", "--", "-"]) | st.text(
    max_size=12
)


@pytest.mark.slow
@settings(max_examples=300)
@given(section=SECTIONS, value=VALUES)
def test_a_scenario_of_any_values_is_refused_or_sound(section, value):
    _refusal({"preset": "paper", section: value})


@pytest.mark.slow
@settings(max_examples=300)
@given(section=SECTIONS, key=st.text(max_size=8), value=VALUES)
def test_a_section_with_any_key_is_refused_or_sound(section, key, value):
    table = Scenario.paper().to_dict()
    if not isinstance(table[section], dict):
        return
    keys = sorted(table[section]) or [key]
    table[section] = table[section] | {keys[len(key) % len(keys)] if len(key) % 2 else key: value}
    message = _refusal(table)
    assert not message or any(name in message for name in (section, "epoch", "duration"))


def _refusal(table):
    """Why a scenario is refused, empty if it is sound."""
    try:
        scenario = Scenario.from_dict(table)
    except (ValueError, TypeError) as error:
        return str(error)
    assert Scenario.from_dict(scenario.to_dict()) == scenario
    return ""


@pytest.mark.slow
@settings(max_examples=75)
@given(words=st.lists(WORDS, max_size=6), attitude=st.booleans())
def test_any_words_are_a_command_or_refused_in_plain_characters(words, attitude):
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        done = CliRunner().invoke(app, ["attitude", *words] if attitude else words)
        assert os.listdir(folder) == []
    assert done.exit_code in (0, 2), done.output
    assert all(character.isprintable() or character == "\n" for character in done.output)


@given(text=st.text(max_size=30))
def test_any_text_is_numbers_or_refused(text):
    with contextlib.suppress(ValueError):
        found = parse_numbers("--sigma", text)
        assert isinstance(found, float | list)
    with contextlib.suppress(ValueError):
        assert len(parse_settings([text])) == 1
