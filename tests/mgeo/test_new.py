"""`mgeo new problem`: what it writes installs, passes its tests and is solved by its name."""

import importlib
import inspect
import json
import subprocess
import sys
import tomllib

import pytest
from typer.testing import CliRunner

import mgeo
from mgeo.cli.app import app
from mgeo.cli.new import problem_files, write_problem
from mgeo.plugins.problems import load_problem

NAME, MODULE, CLASS = "my-beam", "my_beam", "MyBeam"


def run(*words, code=0):
    done = CliRunner().invoke(app, list(words), prog_name="mgeo")
    assert done.exit_code == code, done.output + done.stderr
    return done


@pytest.fixture
def package(tmp_path, monkeypatch):
    """Its folder, as an editable install has it: on Python's path, with its metadata."""
    folder = tmp_path / "plugins" / NAME
    folder.parent.mkdir()
    write_problem(NAME, folder)
    project = tomllib.loads((folder / "pyproject.toml").read_text())["project"]
    info = folder / f"{project['name']}-{project['version']}.dist-info"
    info.mkdir()
    (info / "METADATA").write_text(
        f"Metadata-Version: 2.1\nName: {project['name']}\nVersion: {project['version']}\n"
    )
    (group, points), *others = project["entry-points"].items()
    assert not others
    lines = [f"[{group}]", *(f"{name} = {value}" for name, value in points.items())]
    (info / "entry_points.txt").write_text("\n".join(lines))
    monkeypatch.syspath_prepend(folder)
    monkeypatch.chdir(tmp_path)
    importlib.invalidate_caches()
    yield folder
    for module in [each for each in sys.modules if each.partition(".")[0] == MODULE]:
        del sys.modules[module]


def test_it_is_solved_by_its_name(package):
    (package.parent / "long.toml").write_text("length = 2.0\n")
    scenario = str(package.parent / "long.toml")
    found = run("solve", NAME, "--evaluations", "100", "--scenario", scenario, "--json", "-q")
    document = json.loads(found.stdout)
    assert document["configuration"]["options"] == {"length": 2.0, "load": 1000.0}
    assert document["answer"]["text"].endswith(" mm")


@pytest.mark.parametrize("key", ["sidex", "n_var", "elementwise", "lenght"])
def test_a_wrong_key_is_answered_with_keys_that_are_taken(package, key):
    """pymoo's own constructor has twenty more, which this one does not take."""
    with pytest.raises(ValueError, match=rf"unknown option '{key}' .*: expected ") as refused:
        load_problem(NAME, {key: 2})
    offered = str(refused.value).partition("expected ")[2].partition(";")[0].split(" or ")
    assert offered == ["length", "load"]
    assert load_problem(NAME, dict.fromkeys(offered, 2.0)).options() == {"length": 2.0, "load": 2.0}
    assert ("did you mean 'length'?" in str(refused.value)) == (key == "lenght")


def test_the_package_is_whole():
    files = problem_files(NAME)
    project = tomllib.loads(files["pyproject.toml"])
    assert project["project"]["dependencies"][0].startswith(f"mgeo>={mgeo.__version__},<")
    assert project["tool"]["hatch"]["build"]["targets"]["wheel"]["packages"] == [MODULE]
    assert project["project"]["entry-points"] == {"mgeo.problems": {NAME: f"{MODULE}:{CLASS}"}}
    for path, text in files.items():
        assert "{{" not in text, path
        if path.endswith(".py"):
            compile(text, path, "exec")


def test_it_is_written_whole_or_not_at_all(tmp_path, monkeypatch):
    monkeypatch.setattr("os.rename", lambda *_: (_ for _ in ()).throw(OSError("disk full")))
    with pytest.raises(OSError, match="disk full"):
        write_problem(NAME, tmp_path / NAME)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("My-Beam", "expected lower-case words"),
        ("pymoo:zdt1", "expected lower-case words"),
        ("../beam", "expected lower-case words"),
        ("class", "none of Python's own"),
        ("numpy", "a module numpy is installed"),
        ("attitude", "taken by mgeo-attitude"),
    ],
)
def test_names_that_cannot_be_had(name, said, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    refused = run("new", "problem", name, code=2)
    assert said in refused.stderr
    assert refused.stderr.count("\n") == 1
    assert not list(tmp_path.iterdir())


def test_the_command(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    said = run("new", "problem", NAME).stdout
    assert said.splitlines()[-1].startswith(f"next: pip install -e {NAME}, then mgeo solve {NAME}")
    assert len(list((tmp_path / NAME).rglob("*.*"))) == len(problem_files(NAME))
    assert "exists" in run("new", "problem", NAME, code=2).stderr
    document = json.loads(run("new", "problem", NAME, "--out", "other", "--json").stdout)
    assert document["folder"] == "other"
    assert all((tmp_path / file).is_file() for file in document["files"])


@pytest.mark.slow
def test_pytest_passes_in_its_folder(package):
    """As its README says, but for pip, which needs a network."""
    code = inspect.cleandoc(
        f"""
        import sys, pytest
        sys.path.insert(0, {str(package)!r})
        sys.exit(pytest.main(["-q", {str(package)!r}]))
        """
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=package, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "4 passed" in done.stdout
