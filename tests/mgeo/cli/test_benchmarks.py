"""Test problems on the command line, named as in studies."""

from pathlib import Path

import pytest

from mgeo.store.run_folder import read_run

SHORT = ("--evaluations", "60", "--runs", "2", "-q")


@pytest.mark.cases(2)
@pytest.mark.parametrize(
    ("name", "folder"),
    [
        ("pymoo:zdt1", "pymoo-zdt1-mgeo-directed-seed1"),
        ("shifted:zdt1", "shifted-zdt1-mgeo-directed-seed1"),
        ("coco:bbob-biobj/f12/d5/i3", "coco-bbob-biobj-f12-d5-i3-mgeo-directed-seed1"),
    ],
)
def test_they_are_solved_and_reported(mgeo, name, folder):
    done = mgeo("solve", name, *SHORT)
    assert done.exit_code == 0, done.output
    run = read_run(Path("runs") / folder)
    assert run.configuration.problem == name
    assert ("coco-experiment" in run.versions) == name.startswith("coco:")
    assert mgeo("report", f"runs/{folder}").exit_code == 0


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("pymoo:nope", "pymoo has no problem 'nope'"),
        ("shifted:nope", "pymoo has no problem 'nope'"),
        ("coco:bbob-biobj/f1-3/d5/i1", "expected one function, one dimension and one instance"),
    ],
)
def test_what_is_not_there_is_said_in_a_line(mgeo, name, message):
    done = mgeo("solve", name)
    assert (done.exit_code, done.stderr.count("\n")) == (2, 1)
    assert message in done.stderr
