"""Every public name shows by an example how it is used, and the example gives what it says."""

import doctest
import inspect
import re
from importlib import import_module

import pytest
from mgeo_attitude.settings.base import Settings

#: Modules whose public names the reference shows.
MODULES = (
    "mgeo",
    "mgeo.studies",
    "mgeo.report",
    "mgeo.testing",
    "mgeo_attitude",
    "mgeo_attitude.plan",
    "mgeo_attitude.scenario",
    "mgeo_calibration",
    "mgeo_suite",
)


def shown():
    """Public objects by name, each once, but for what is raised and warned of."""
    found = {}
    for module in MODULES:
        for name in import_module(module).__all__:
            each = getattr(import_module(module), name)
            if not (isinstance(each, type) and issubclass(each, Exception)):
                found.setdefault(id(each), (f"{module}.{name}", each))
    return dict(found.values())


def example(name, each):
    return doctest.DocTestParser().get_doctest(inspect.getdoc(each), {}, name, None, None)


def test_every_public_name_has_an_example():
    assert [name for name, each in shown().items() if not example(name, each).examples] == []


@pytest.mark.slow
def test_examples_give_what_they_say(tmp_path, monkeypatch):
    for name, each in shown().items():
        folder = tmp_path / name
        folder.mkdir()
        monkeypatch.chdir(folder)
        report = []
        runner = doctest.DocTestRunner()
        runner.run(example(name, each), out=report.append)
        assert runner.failures == 0, "".join(report)


def test_arguments_have_a_section():
    """Settings declare theirs: the page has what they declare."""
    for name, each in shown().items():
        if not (isinstance(each, type) and issubclass(each, Settings)):
            text = inspect.getdoc(each).partition("Examples\n")[0]
            assert re.search(r"^(Parameters|Attributes)$", text, re.M) or not arguments(each), name


def arguments(each):
    return [name for name in inspect.signature(each).parameters if name != "self"]
