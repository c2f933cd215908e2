"""The examples in the docstrings of the public names."""

import doctest
import inspect
from importlib import import_module

import pytest

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


@pytest.mark.slow
def test_examples(tmp_path, monkeypatch):
    examples = {}
    for module in MODULES:
        for name in import_module(module).__all__:
            each = getattr(import_module(module), name)
            examples[f"{each.__module__}.{name}"] = inspect.getdoc(each)
    attempted = 0
    for name, text in examples.items():
        folder = tmp_path / name
        folder.mkdir()
        monkeypatch.chdir(folder)
        report = []
        runner = doctest.DocTestRunner()
        runner.run(
            doctest.DocTestParser().get_doctest(text, {}, name, None, None), out=report.append
        )
        assert runner.failures == 0, "".join(report)
        attempted += runner.tries
    assert attempted > 100
