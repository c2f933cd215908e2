"""A run of the satellite problem survives being killed at any moment."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

KILLS, SEED = 10, 20120
CANDIDATES = 48


@pytest.mark.slow
@pytest.mark.campaign  # one kill of each kind of run is among the others
@pytest.mark.skipif(not hasattr(os, "fork"), reason="the runs are forked")
def test_a_run_killed_at_random_moments_ends_as_if_it_had_not_been(tmp_path):
    done = subprocess.run(
        [sys.executable, "-m", "tests.survivor", tmp_path, str(SEED), str(KILLS)],
        cwd=Path(__file__).parents[1],
        capture_output=True,
        text=True,
        check=False,
        timeout=300,
    )
    assert done.returncode == 0, done.stderr
    seen = json.loads(done.stdout.splitlines()[-1])
    assert seen["points"] > 10
    fates = seen["fates"]
    assert sum(fate["killed"] for fate in fates) == KILLS
    generations = {fate["generations"] for fate in fates}
    assert len(generations) > KILLS / 3  # the moments are spread over the run
    for fate in fates:
        assert fate["same front"], fate
        assert fate["same candidates"], fate
        assert fate["same record"], fate
        # what was kept before the kill is whole, and no file of the killed process is left
        assert fate["recorded"] >= fate["generations"] * CANDIDATES, fate
        assert fate["left over"] == [], fate
