"""The same comparison on a Dask cluster of two worker processes, one of which dies."""

import os
import signal
import sys
import threading
import time
import types
from pathlib import Path

import joblib
import pytest
from pymoo.algorithms.moo.nsga2 import NSGA2
from pymoo.problems.multi import ZDT1
from typer.testing import CliRunner

from mgeo import MGEOReal, compare
from mgeo.cli.app import app
from mgeo.studies.dispatch import WorkerError

PROBLEM = ZDT1(n_var=6)
ALGORITHMS = {
    "MGEO": MGEOReal(sigma=0.3, n_walkers=5, perturbation="range"),
    "NSGA-II": NSGA2(pop_size=20),
}
STUDY = {"n_eval": 2000, "seeds": 5, "grid": 4}


@pytest.fixture
def client():
    distributed = pytest.importorskip(
        "distributed", reason="needs the extra: pip install 'mgeo[distributed]'"
    )
    # pytest turns warnings into errors, and Dask's are about this machine's memory and ports
    cluster = distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, dashboard_address=None, silence_logs=50
    )
    with cluster, distributed.Client(cluster) as connected:
        yield connected


@pytest.mark.slow
@pytest.mark.filterwarnings("default")
def test_a_worker_that_dies_costs_time_and_nothing_else(client, tmp_path):
    serial = compare(PROBLEM, ALGORITHMS, **STUDY)
    before = set(client.run(os.getpid).values())
    assert len(before) == 2
    assert os.getpid() not in before
    victim = min(before)
    killed = []

    def kill():
        while len(list(tmp_path.glob("*.npz"))) < 2:
            time.sleep(0.01)
        os.kill(victim, signal.SIGKILL)
        killed.append(len(list(tmp_path.glob("*.npz"))))

    killer = threading.Thread(target=kill)
    killer.start()
    with joblib.parallel_config("dask"):
        spread = compare(PROBLEM, ALGORITHMS, **STUDY, folder=tmp_path)
    killer.join()
    assert killed[0] < 10  # it died with runs still to be made
    after = set(client.run(os.getpid).values())
    assert victim not in after
    assert spread.runs["status"].tolist() == ["finished"] * 10
    assert spread.table.equals(serial.table)


FILE = """
title = "distributed"
evaluations = 300
seeds = 3
grid = 2
[[problems]]
name = "pymoo:zdt1"
[[algorithms]]
name = ["nsga2", "random"]
"""


@pytest.mark.campaign
@pytest.mark.slow
@pytest.mark.filterwarnings("default")
def test_the_command_runs_a_study_on_a_cluster(client, tmp_path):
    (tmp_path / "study.toml").write_text(FILE)
    arguments = ["study", str(tmp_path / "study.toml"), "--quiet"]
    address = client.scheduler_info()["address"]
    for name, options in (("here", ["--jobs", "1"]), ("there", ["--cluster", address])):
        out = ["--out", str(tmp_path / name)]
        done = CliRunner().invoke(app, [*arguments, *options, *out])
        assert done.exit_code == 0, done.output
    there = (tmp_path / "there" / "table.csv").read_text()
    assert there == (tmp_path / "here" / "table.csv").read_text()
    assert len(there.splitlines()) == 1 + 2 * 3 * 2


MODULE = """
from pymoo.algorithms.moo.nsga2 import NSGA2
{more}
class Mine(NSGA2):
    def __init__(self, pop_size=10):
        super().__init__(pop_size=pop_size)
"""


@pytest.fixture
def beside_the_study(tmp_path, monkeypatch):
    """Writes modules where the study is, which the workers, started before, know nothing of."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", [*sys.path])
    Path("study.toml").write_text(FILE.replace('"random"', '"of_mine.search:Mine", "my_file:Mine"'))
    Path("of_mine").mkdir()
    Path("of_mine/__init__.py").touch()
    Path("of_mine/search.py").write_text(MODULE.format(more=""))
    yield
    for name in ("of_mine", "of_mine.search", "my_file", "my_helper"):
        sys.modules.pop(name, None)


def study_on(client, *more):
    address = client.scheduler_info()["address"]
    arguments = ["study", "study.toml", "--quiet", "--cluster", address, *more]
    return CliRunner().invoke(app, arguments)


@pytest.mark.campaign
@pytest.mark.slow
@pytest.mark.filterwarnings("default")
@pytest.mark.usefixtures("beside_the_study")
def test_modules_beside_the_study_are_sent_along(client):
    Path("my_helper.py").write_text("x = 1")
    Path("my_file.py").write_text(MODULE.format(more="import my_helper"))
    done = study_on(client)
    assert done.exit_code == 0, done.output
    rows = Path("studies/study/runs.csv").read_text()
    assert rows.count("finished") == 9


@pytest.mark.campaign
@pytest.mark.slow
@pytest.mark.filterwarnings("default")
@pytest.mark.usefixtures("beside_the_study")
def test_a_worker_that_cannot_load_a_module_is_named(client):
    Path("my_file.py").write_text(
        MODULE.format(more=f"import os\nassert os.getpid() == {os.getpid()}")
    )
    began = time.monotonic()
    done = study_on(client)
    assert done.exit_code == 2, done.output
    (line,) = [line for line in done.stderr.splitlines() if line.startswith("Error: ")]
    workers = client.scheduler_info()["workers"]
    assert any(line.startswith(f"Error: worker {worker} cannot load ") for worker in workers)
    assert "AssertionError" in line
    assert time.monotonic() - began < 60


class Elsewhere(NSGA2):
    """Of a module that is nowhere."""


Elsewhere.__module__ = "nowhere"


@pytest.mark.campaign
@pytest.mark.slow
@pytest.mark.filterwarnings("default")
def test_a_module_that_is_nowhere_is_named(client, monkeypatch):
    made = types.ModuleType("nowhere")
    made.Elsewhere = Elsewhere
    monkeypatch.setitem(sys.modules, "nowhere", made)
    message = r"^worker tcp://\S+ cannot load nowhere: ModuleNotFoundError: .*; expected the same"
    with joblib.parallel_config("dask"), pytest.raises(WorkerError, match=message):
        compare(PROBLEM, [Elsewhere(pop_size=10)], 40, seeds=2)
