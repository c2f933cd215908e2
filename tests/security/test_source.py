"""Nothing in the sources unpickles or evaluates, but for what is named here."""

import ast
import re
from pathlib import Path

ROOT = Path(__file__).parents[2]
SOURCES = [*ROOT.glob("mgeo/**/*.py"), *ROOT.glob("problems/*/mgeo_*/**/*.py")]
MODULES = {"pickle", "cPickle", "dill", "cloudpickle", "marshal", "shelve", "yaml", "subprocess"}
CALLS = {"eval", "exec", "compile", "__import__", "joblib.load", "np.fromfile", "os.system",
         "os.popen", "np.load", "pd.read_pickle", "input"}  # fmt: skip
SUSPECT = re.compile(
    "|".join(rf"\b{re.escape(each)}\b" for each in MODULES | CALLS | {"allow_pickle"})
)

#: The one module that runs code made here, of a sensor suite, never of a file's text; and checks
#: of whether a problem and an algorithm can be sent to other processes, which unpickle their own.
ALLOWED = {
    ("mgeo_attitude/filter/kernel.py", "exec"),
    ("mgeo_attitude/filter/kernel.py", "compile"),
    ("mgeo/testing/problem.py", "pickle"),
    ("mgeo/testing/algorithm.py", "pickle"),
}


def called(function):
    """Return the name of a function, or of an attribute of a module."""
    if isinstance(function, ast.Attribute) and isinstance(function.value, ast.Name):
        return f"{function.value.id}.{function.attr}"
    return getattr(function, "id", "")


def found(tree):
    """Imports and calls that could run what a file says."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (a.name for a in node.names if a.name.split(".")[0] in MODULES)
        elif isinstance(node, ast.ImportFrom) and (node.module or "").split(".")[0] in MODULES:
            yield node.module
        elif isinstance(node, ast.Call):
            name = called(node.func)
            given = [k.value for k in node.keywords if k.arg == "allow_pickle"]
            safe = [ast.unparse(value) for value in given] == ["False"]
            if name in CALLS and not (name == "np.load" and safe):
                yield name
            if given and not safe:
                yield "allow_pickle"


def test_nothing_unpickles_or_evaluates():
    assert len(SOURCES) > 100
    seen = {
        ("/".join(path.parts[-3:]), name)
        for path in SOURCES
        if SUSPECT.search(text := path.read_text(encoding="utf-8"))
        for name in found(ast.parse(text))
    }
    assert seen == ALLOWED
