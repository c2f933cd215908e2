"""Absence of calls in the source code that unpickle or evaluate texts, with few exceptions."""

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

#: Exceptions, as (file, name). The kernel module compiles code that it generates for a sensor
#: suite, never texts of files. The checks of problems and algorithms unpickle objects that they
#: have pickled themselves, to find out whether these can be sent to other processes.
ALLOWED = {
    ("mgeo_attitude/filter/kernel.py", "exec"),
    ("mgeo_attitude/filter/kernel.py", "compile"),
    ("mgeo/testing/problem.py", "pickle"),
    ("mgeo/testing/algorithm.py", "pickle"),
}


def get_name(function):
    """Return the name of a called function, such as ``eval`` or ``os.system``."""
    if isinstance(function, ast.Attribute) and isinstance(function.value, ast.Name):
        return f"{function.value.id}.{function.attr}"
    return getattr(function, "id", "")


def list_suspects(tree):
    """Yield the names of imports and calls in a syntax tree that could execute content of files."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (a.name for a in node.names if a.name.split(".")[0] in MODULES)
        elif isinstance(node, ast.ImportFrom) and (node.module or "").split(".")[0] in MODULES:
            yield node.module
        elif isinstance(node, ast.Call):
            name = get_name(node.func)
            allow_pickle = [k.value for k in node.keywords if k.arg == "allow_pickle"]
            is_safe = [ast.unparse(value) for value in allow_pickle] == ["False"]
            if name in CALLS and not (name == "np.load" and is_safe):
                yield name
            if allow_pickle and not is_safe:
                yield "allow_pickle"


def test_sources_neither_unpickle_nor_evaluate():
    assert len(SOURCES) > 100
    suspects = {
        ("/".join(path.parts[-3:]), name)
        for path in SOURCES
        if SUSPECT.search(text := path.read_text(encoding="utf-8"))
        for name in list_suspects(ast.parse(text))
    }
    assert suspects == ALLOWED
