"""Where Python has no POSIX, as on Windows, the packages are imported and used all the same."""

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]

#: Every module, in alphabetical order, but those of extras that are not installed.
IMPORTS = """
import tests.without_posix
import pkgutil
from importlib import import_module
from pathlib import Path

folders = [Path("mgeo"), *Path("problems").glob("*/mgeo_*")]
count = 0
for folder in folders:
    for module in pkgutil.walk_packages([str(folder)], f"{folder.name}."):
        if not module.name.endswith("__main__") and ".kernels." not in module.name:
            try:
                import_module(module.name)
                count += 1
            except ImportError as error:
                if error.name in ("fcntl", *tests.without_posix.MODULES):
                    raise
print(count)
"""

#: A search, more of it, its report, a plan, a study, and who comes second.
USE = """
import tests.without_posix
from pathlib import Path
from typer.testing import CliRunner
from mgeo.cli.app import app
from mgeo.store.atomic import lock

def mgeo(line, code=0):
    done = CliRunner().invoke(app, line.split())
    assert done.exit_code == code, done.output
    return done.output

mgeo("solve attitude --seed 1 --evaluations 200 --out run -q")
mgeo("resume run --evaluations 300 -q")
mgeo("report run")
mgeo("attitude show run")
Path("study.toml").write_text('''
title = "short"
seeds = [1, 2]
evaluations = 60
[[problems]]
name = "pymoo:zdt1"
[[algorithms]]
name = "mgeo-real"
''')
mgeo("study study.toml --out study --jobs 2 -q")
with lock(Path("run")):
    assert "is in use" in mgeo("resume run --evaluations 400 -q", 2)
assert not list(Path().rglob(".mgeo-lock"))
print(len(tests.without_posix.calls))
"""


def run(code, folder):
    done = subprocess.run(
        [sys.executable, "-c", f"import sys; sys.path.insert(0, {str(ROOT)!r})\n{code}"],
        capture_output=True,
        text=True,
        timeout=300,
        cwd=folder,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return int(done.stdout.split()[-1])


@pytest.mark.campaign
@pytest.mark.slow
def test_all_is_imported():
    assert run(IMPORTS, ROOT) > 300


@pytest.mark.campaign
@pytest.mark.slow
def test_it_searches_studies_reports_and_locks(tmp_path):
    # of solve, resume, a study's claim and its tables, the one held and the one refused
    assert run(USE, tmp_path) == 6


def test_what_is_absent_is_absent():
    code = "import tests.without_posix, sys, mgeo.store\nfrom mgeo.store import lock\n"
    code += "used = sys.modules['mgeo.store.atomic']\n"
    with pytest.raises(AssertionError, match="has no attribute 'fcntl'"):
        run(f"{code}print(used.fcntl)", ROOT)
    with pytest.raises(AssertionError, match="has no attribute 'O_NOFOLLOW'"):
        run(f"{code}print(used.os.O_NOFOLLOW)", ROOT)
