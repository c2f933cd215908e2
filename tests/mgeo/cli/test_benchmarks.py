"""Solution of COCO test problems on the command line."""

from pathlib import Path

from mgeo.store.run_folder import read_run


def test_solve_accepts_the_name_of_a_coco_problem(mgeo):
    name = "coco:bbob-biobj/f12/d5/i3"
    done = mgeo("solve", name, "--evaluations", "60", "--walkers", "2", "-q")
    assert done.exit_code == 0, done.output
    run = read_run(Path("runs/coco-bbob-biobj-f12-d5-i3-mgeo-directed-seed1"))
    assert run.configuration.problem == name
    assert "coco-experiment" in run.versions
