"""Test problems on the command line, named as in studies."""

from pathlib import Path

import pytest

from mgeo.store.run_folder import read_run


@pytest.mark.parametrize(
    ("name", "folder"),
    [
        ("shifted:zdt1", "shifted-zdt1-mgeo-directed-seed1"),
        ("coco:bbob-biobj/f12/d5/i3", "coco-bbob-biobj-f12-d5-i3-mgeo-directed-seed1"),
    ],
)
def test_test_problems_are_solved(mgeo, name, folder):
    done = mgeo("solve", name, "--evaluations", "60", "--walkers", "2", "-q")
    assert done.exit_code == 0, done.output
    run = read_run(Path("runs") / folder)
    assert run.configuration.problem == name
    assert ("coco-experiment" in run.versions) == name.startswith("coco:")
