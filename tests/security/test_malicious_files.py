"""Malicious files, which would run code if they were unpickled or evaluated."""

import io
import pickle
import zipfile
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from mgeo.cli.app import app
from mgeo.studies.study_run import StudyRun


class Poison:
    """Object that creates a file when it is unpickled."""

    def __init__(self, marker):
        self.marker = marker

    def __reduce__(self):
        return Path.touch, (self.marker,)


@pytest.fixture
def run(tmp_path, monkeypatch):
    """Path of a run folder with checkpoint and record, in the current folder."""
    monkeypatch.syspath_prepend(str(Path(__file__).parents[1] / "mgeo" / "stand_in"))
    monkeypatch.chdir(tmp_path)
    command = ["solve", "cantilever", "--walkers", "2", "--evaluations", "40", "--record", "-q"]
    assert CliRunner().invoke(app, [*command, "--out", "run"]).exit_code == 0
    return Path("run")


@pytest.fixture
def poison(tmp_path):
    """Path that the poison would create, and files with it: a pickle and two array files."""
    marker = tmp_path / "executed"
    array = np.empty(1, dtype=object)
    array[0] = Poison(marker)
    npy = io.BytesIO()
    np.save(npy, array, allow_pickle=True)
    archive = io.BytesIO()
    with zipfile.ZipFile(archive, "w") as members:
        for name in (
            "json",
            "X",
            "F",
            "G",
            "H",
            "columns",
            "rows",
            "evaluation_numbers",
            "front_rows",
        ):
            members.writestr(f"{name}.npy", npy.getvalue())
    return marker, [pickle.dumps(Poison(marker)), npy.getvalue(), archive.getvalue()]


def test_unpickling_the_poison_creates_the_marker(poison):
    marker, (content, *_) = poison
    pickle.loads(content)
    assert marker.exists()


@pytest.mark.slow
def test_poisoned_run_folder_executes_nothing(run, poison):
    marker, contents = poison
    files = [path for path in run.rglob("*") if path.is_file()] + [run / "verification.json"]
    originals = {path: path.read_bytes() for path in files if path.exists()}
    for path in files:
        for content in contents:
            path.write_bytes(content)
            for command in (["report", "run"], ["resume", "run", "--evaluations", "44"]):
                CliRunner().invoke(app, [*command, "-q"])
            CliRunner().invoke(app, ["attitude", "show", "run"])
            assert not marker.exists(), path
            (run / "verification.json").unlink(missing_ok=True)
            for original_path, original in originals.items():
                original_path.write_bytes(original)


def test_poisoned_run_of_a_study_executes_nothing(tmp_path, poison):
    marker, contents = poison
    for content in contents:
        path = tmp_path / "a.npz"
        path.write_bytes(content)
        with pytest.raises(ValueError, match=r"a\.npz: not a stored run"):
            StudyRun.read(path)
    assert not marker.exists()


@pytest.mark.parametrize(
    "label", ["{name.__class__}", "{sigma.__init__}", "{name:>999999999}", "{0}"]
)
def test_label_of_a_study_cannot_access_attributes(tmp_path, label):
    path = tmp_path / "s.toml"
    path.write_text(
        f'title = "t"\nevaluations = 8\nseeds = 1\n[[problems]]\nname = "pymoo:zdt1"\n'
        f'[[algorithms]]\nname = "mgeo-real"\nsigma = 1.0\nlabel = "{label}"\n'
    )
    done = CliRunner().invoke(app, ["study", str(path), "-q"])
    assert done.exit_code == 2
    assert "expected only name, sigma in braces" in done.stderr
