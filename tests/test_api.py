"""What is promised to stay is what the page shows, and what goes says when."""

import ast
import re
import tomllib
from importlib import import_module
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PAGE = (ROOT / "docs" / "reference" / "api.md").read_text(encoding="utf-8")
TABLE = {
    module: re.findall(r"`(\w+)`", names)
    for module, names in re.findall(r"^\| \[`([\w.]+)`\]\(\w+\.md\) \| (.+) \|$", PAGE, re.M)
}
VERSION = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["version"]
PACKAGES = [ROOT / "mgeo", *sorted(ROOT.glob("problems/*/mgeo_*"))]


@pytest.mark.parametrize("module", TABLE)
def test_the_page_shows_the_public_names(module):
    public = import_module(module).__all__
    if "." in module:  # of a room others use more than stays
        public = [name for name in public if name in TABLE[module]]
    assert TABLE[module] == public


def test_the_page_shows_every_package():
    assert {package.name for package in PACKAGES} <= TABLE.keys()


#: Of what programs use, and of what stands in files, of which the command tells.
KINDS = ("DeprecationWarning", "FutureWarning")


def deprecations():
    """Place and message of every warning that something goes."""
    for path in (path for package in PACKAGES for path in package.rglob("*.py")):
        for call in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(call, ast.Call) and (
                getattr(call.func, "id", "") == "deprecated"
                or (
                    getattr(call.func, "attr", "") == "warn"
                    and any(getattr(each, "id", "") in KINDS for each in call.args)
                )
            ):
                yield f"{path.relative_to(ROOT)}:{call.lineno}", ast.unparse(call.args[0])


def test_what_goes_says_in_which_version():
    found = dict(deprecations())
    assert len(found) >= 3
    now = [int(part) for part in VERSION.split(".")[:2]]
    for place, message in found.items():
        end = re.search(r"; gone in (\d+)\.(\d+)['\"]$", message)
        assert end, f"{place}: {message}: expected '; gone in X.Y' at its end"
        assert [int(part) for part in end.groups()] > now, f"{place}: its time has come"


def test_nothing_warns_by_another_way():
    texts = {path: path.read_text(encoding="utf-8") for p in PACKAGES for path in p.rglob("*.py")}
    places = {place.partition(":")[0] for place, _ in deprecations()}
    word = re.compile(r"DeprecationWarning|FutureWarning|import deprecated")
    found = {str(p.relative_to(ROOT)) for p, text in texts.items() if word.search(text)}
    assert found == places | {"mgeo/cli/app.py"}  # which shows them
