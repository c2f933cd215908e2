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
    with cluster, distributed.Client(cluster) as client_of_cluster:
        yield client_of_cluster


@pytest.mark.slow
@pytest.mark.filterwarnings("default")  # Dask warns about memory and ports.
@pytest.mark.usefixtures("without_figures")
def test_study_on_dask_cluster_has_same_table_as_local_study(client, tmp_path):
    (tmp_path / "study.toml").write_text(STUDY)
    arguments = ["study", str(tmp_path / "study.toml"), "--quiet"]
    address = client.scheduler_info()["address"]
    for name, options in (("local", ["--jobs", "1"]), ("cluster", ["--cluster", address])):
        out = ["--out", str(tmp_path / name)]
        result = CliRunner().invoke(app, [*arguments, *options, *out])
        assert result.exit_code == 0, result.output
    table = (tmp_path / "cluster" / "table.csv").read_text()
    assert table == (tmp_path / "local" / "table.csv").read_text()
    assert len(table.splitlines()) == 1 + 3 * 3 * 2
