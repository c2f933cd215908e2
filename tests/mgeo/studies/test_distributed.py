"""A study on a Dask cluster of two worker processes."""

import pytest
from typer.testing import CliRunner

from mgeo.cli.app import app

STUDY = """
title = "distributed"
evaluations = 300
seeds = 3
grid = 2
[[problems]]
name = "pymoo:zdt1"
[[algorithms]]
name = ["nsga2", "random", "mgeo-real"]
"""


@pytest.fixture
def client():
    distributed = pytest.importorskip(
        "distributed", reason="needs the extra: pip install 'mgeo[distributed]'"
    )
    cluster = distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, dashboard_address=None, silence_logs=50
    )
    with cluster, distributed.Client(cluster) as connected:
        yield connected


@pytest.mark.slow
@pytest.mark.filterwarnings("default")  # Dask's are about this machine's memory and ports
@pytest.mark.usefixtures("quick")
def test_a_study_on_a_cluster_has_the_same_table(client, tmp_path):
    (tmp_path / "study.toml").write_text(STUDY)
    arguments = ["study", str(tmp_path / "study.toml"), "--quiet"]
    address = client.scheduler_info()["address"]
    for name, options in (("here", ["--jobs", "1"]), ("there", ["--cluster", address])):
        out = ["--out", str(tmp_path / name)]
        done = CliRunner().invoke(app, [*arguments, *options, *out])
        assert done.exit_code == 0, done.output
    there = (tmp_path / "there" / "table.csv").read_text()
    assert there == (tmp_path / "here" / "table.csv").read_text()
    assert len(there.splitlines()) == 1 + 3 * 3 * 2
