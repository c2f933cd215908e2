"""mgeo never imports a plugin, and the attitude plugin never imports mgeo."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
MGEO = ROOT / "mgeo"
ATTITUDE = ROOT / "problems" / "attitude" / "mgeo_attitude"


def imported(package):
    """Top-level names of all absolute imports below a folder, wherever they stand."""
    names = set()
    for path in package.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import):
                names |= {alias.name.partition(".")[0] for alias in node.names}
            elif isinstance(node, ast.ImportFrom) and node.level == 0:
                names.add(node.module.partition(".")[0])
    return names


def test_sources_do_not_import_each_other():
    assert "pymoo" in imported(MGEO) & imported(ATTITUDE)  # the search finds what is there
    assert "mgeo_attitude" not in imported(MGEO)
    assert "mgeo" not in imported(ATTITUDE)


@pytest.mark.parametrize(
    ("module", "absent"), [("mgeo", "mgeo_attitude"), ("mgeo_attitude", "mgeo")]
)
def test_importing_one_does_not_load_the_other(module, absent):
    loaded = f"[m for m in sys.modules if m.partition('.')[0] == '{absent}']"
    code = f"import sys, {module}; print({loaded})"
    result = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=120
    )
    assert result.stdout.strip() == "[]"
