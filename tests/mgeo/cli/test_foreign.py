"""Problems and plugins that end the program, or print, while a command is under way."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from ..plugins.test_discovery import claim

SOLVE = ("solve", "leaver", "--algorithm", "nsga2", "--evaluations", 300, "--out", "a")

MODULE = """
import ctypes, os, sys, threading
from stand_in import Cantilever, CantileverView

class Left(CantileverView):
    def describe(self):
        {in_describe}
        return super().describe()

class Leaver(Cantilever):
    def _evaluate(self, X, out, *args, **kwargs):
        super()._evaluate(X, out, *args, **kwargs)
        if {when}:
            {what}

    def view(self, X):
        return Left(self, X)
"""


@pytest.fixture
def leaver(mgeo, tmp_path, monkeypatch):
    """Makes the problem of this name do something when it is evaluated, or described."""
    monkeypatch.syspath_prepend(str(tmp_path))

    def make(what="pass", when="True", in_describe="pass", before=""):
        monkeypatch.delitem(sys.modules, "leaver", raising=False)
        text = MODULE.format(what=what, when=when, in_describe=in_describe)
        Path("leaver.py").write_text(before + text)
        claim(tmp_path, "leaving", "leaver", "leaver:Leaver")

    yield make
    sys.modules.pop("leaver", None)


def test_one_that_always_exits_is_an_error_that_says_so(mgeo, leaver):
    leaver("sys.exit(0)")
    done = mgeo(*SOLVE)
    assert done.exit_code == 2
    assert done.stderr.splitlines()[-1] == (
        "Error: all of the last 100 candidates failed, the first with "
        "ExitError: SystemExit(0) was raised"
    )


def test_one_that_exits_for_some_loses_these(mgeo, leaver):
    leaver("sys.exit(0)", when="(X[:, 0] > 0.03).any()")
    done = mgeo(*SOLVE)
    assert done.exit_code == 0, done.stderr
    assert "ExitError: SystemExit(0) was raised" in done.stdout
    found = json.loads(Path("a/run.json").read_text())
    assert sum(found["failures"].values()) > 50
    assert found["solutions"] > 1


def test_one_that_exits_when_it_is_asked_to_describe_is_named(mgeo, leaver):
    leaver(in_describe="sys.exit(0)")
    done = mgeo(*SOLVE)
    assert done.exit_code == 2
    expected = "describe of problem Leaver raised ExitError: SystemExit(0) was raised"
    assert done.stderr.splitlines()[-1] == f"Error: {expected}"


def test_one_that_exits_while_it_is_imported_hides_no_other(mgeo, leaver):
    leaver(before="raise SystemExit(0)")
    listed = json.loads(mgeo("problems", "--json").stdout)["problems"]
    errors = {each["name"]: each["error"] for each in listed}
    assert errors["leaver"] == (
        "problem 'leaver' of leaving 2.0 does not load: ExitError: SystemExit(0) was raised"
    )
    assert errors["cantilever"] is None


@pytest.mark.parametrize("what", ["raise SystemExit(0)", "raise GeneratorExit"])
def test_an_exit_in_commands_is_an_error_with_its_place(mgeo, tmp_path, monkeypatch, what):
    lines = ["import typer", "app = typer.Typer()", "@app.command()", "def go():", f"    {what}"]
    lines += ["@app.command()", "def stay(): ..."]
    Path("leaving_commands.py").write_text("\n".join(lines))
    claim(tmp_path, "leaving", "leave", "leaving_commands:app", "mgeo.commands")
    monkeypatch.syspath_prepend(str(tmp_path))
    done = mgeo("leave", "go")
    sys.modules.pop("leaving_commands", None)
    assert (done.exit_code, done.stdout) == (1, "")
    assert done.stderr.startswith("Error: ExitError: ")
    assert done.stderr.endswith("was raised (leaving_commands.py, line 5; see --debug)\n")


def test_a_keyboard_interrupt_of_the_problem_s_own_is_no_success(mgeo, leaver):
    leaver("raise KeyboardInterrupt", when="(X[:, 0] > 0.049).any()")
    done = mgeo(*SOLVE)
    assert done.exit_code == 130
    assert "interrupted after" in done.stdout


def test_what_a_problem_prints_is_not_part_of_the_document(mgeo, leaver):
    leaver('print("evaluated")', before='print("imported")')
    done = mgeo(*SOLVE, "--json")
    assert done.exit_code == 0, done.stderr
    assert json.loads(done.stdout)["solutions"] > 1
    for word in ("imported", "evaluated"):
        assert f"{word}\n" in done.stderr
    assert "evaluated" in mgeo(*SOLVE, "--overwrite").stdout  # without --json it is left alone


@pytest.mark.slow
def test_nor_what_threads_processes_and_compiled_code_print(leaver, stand_in_environment, tmp_path):
    leaver(
        """
            os.write(1, b"descriptor\\n")
            ctypes.CDLL(None).puts(b"compiled")
            thread = threading.Thread(target=print, args=("thread",))
            thread.start(); thread.join()
            os.system("echo process")"""
    )
    environment = stand_in_environment | {
        "PYTHONPATH": f"{tmp_path}:{stand_in_environment['PYTHONPATH']}"
    }
    done = subprocess.run(
        [sys.executable, "-m", "mgeo", *map(str, SOLVE), "--json"],
        cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=120,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["solutions"] > 1
    for word in ("descriptor", "compiled", "thread", "process"):
        assert f"{word}\n" in done.stderr


@pytest.mark.slow
@pytest.mark.parametrize("arguments", ["problems", "problems --json"])
def test_without_a_stdout_nothing_is_told_and_nothing_breaks(arguments):
    command = f"exec {sys.executable} -m mgeo {arguments} >&-"
    done = subprocess.run(["sh", "-c", command], capture_output=True, text=True, timeout=120)
    assert (done.returncode, done.stderr) == (0, "")


def test_nor_what_a_plugin_prints_when_its_commands_are_imported(mgeo, tmp_path, monkeypatch):
    text = "from stand_in_commands import app\nprint('imported')\n"
    Path("printing_commands.py").write_text(text)
    claim(tmp_path, "printing", "prints", "printing_commands:app", "mgeo.commands")
    monkeypatch.syspath_prepend(str(tmp_path))
    Path("beam.toml").write_text("0.5")
    done = mgeo("prints", "weigh", "beam.toml", "--json")
    sys.modules.pop("printing_commands", None)
    assert json.loads(done.stdout)["mass_kg"] == 3900.0
    assert done.stderr == "imported\n"


def test_a_command_of_a_plugin_whose_output_nobody_reads_ends_in_silence(tmp_path):
    """As `mgeo attitude show plan.json | head`: rich then ends the program by an exit."""
    script = """
import sys
from mgeo.cli.errors import ended
from mgeo._foreign import foreign
from mgeo.cli.output import Output
from types import SimpleNamespace

with ended(SimpleNamespace(meta={}, args=[])), foreign():
    for _ in range(100):
        Output().print("a line " * 1000)
"""
    process = subprocess.Popen(
        [sys.executable, "-c", script], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    process.stdout.read(10)
    process.stdout.close()
    assert "Error" not in process.stderr.read()
    assert process.wait(60) == 1
    process.stderr.close()
