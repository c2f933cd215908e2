"""Runs that are killed at random moments; a script for `test_survival`.

``python -m tests.survivor FOLDER SEED KILLS`` forks the runs from one process, so that everything
is imported and compiled once, and prints as JSON what became of each.
"""

import dataclasses
import json
import os
import signal
import sys
import time
from pathlib import Path

import numpy as np
from mgeo_attitude import AttitudeManeuverProblem, Scenario
from pymoo.core.callback import Callback, CallbackCollection
from pymoo.optimize import minimize

from mgeo import Checkpoint, MGEOReal, Recorder, read_record, resume

GENERATIONS = 16
SCENARIO = dataclasses.replace(Scenario.paper(), duration=4000.0)
PROBLEM = AttitudeManeuverProblem(SCENARIO, threads=1)


class AfterEach(Callback):
    """Calls a function after every generation."""

    def __init__(self, function):
        super().__init__()
        self.function = function

    def update(self, algorithm):
        self.function()


def run(folder, *callbacks):
    """Begin, or go on if there is a checkpoint; the front as it is at the end."""
    path = folder / "run.checkpoint"
    begun = path.exists()
    callback = CallbackCollection(
        *callbacks,
        Recorder(folder / "evaluations", every_seconds=0.0, chunk_rows=400, overwrite=not begun),
        Checkpoint(path, every_seconds=None, every_generations=1),
    )
    if begun:
        return resume(path, PROBLEM, callback=callback).run()
    algorithm = MGEOReal(1.0, n_walkers=4, perturbation="range")
    return minimize(PROBLEM, algorithm, ("n_gen", GENERATIONS), seed=7, callback=callback)


def killed_after(folder, generations, delay):
    """Whether a run could be killed so many seconds after its first so many generations.

    They are counted, not timed: on a busy machine the moments are spread over the run, too.
    """
    told, tell = os.pipe()
    child = os.fork()
    if child == 0:
        run(folder, AfterEach(lambda: os.write(tell, b".")))
        os._exit(0)
    os.close(tell)
    for _ in range(generations):
        os.read(told, 1)
    time.sleep(delay)
    os.kill(child, signal.SIGKILL)
    os.close(told)
    _, status = os.waitpid(child, 0)
    return os.WIFSIGNALED(status)


def fate(folder, expected, generations, delay):
    """A run that is killed and goes on, compared with one that was not killed."""
    folder.mkdir()
    killed = killed_after(folder, generations, delay)
    path = folder / "run.checkpoint"
    kept = resume(path, PROBLEM).n_generations if path.exists() else 0
    recorded = len(read_record(folder / "evaluations")) if kept else 0
    result = run(folder)
    return {
        "killed": killed,
        "generations": kept,
        "recorded": recorded,
        "same front": all(
            np.array_equal(getattr(result, key), getattr(expected, key)) for key in ("X", "F")
        ),
        "same candidates": np.array_equal(result.pop.get("X"), expected.pop.get("X")),
        "same record": read_record(folder / "evaluations").equals(
            read_record(folder.parent / "whole" / "evaluations")
        ),
        "left over": sorted(path.name for path in set(folder.rglob("*.*")) - set(known(folder))),
    }


def known(folder):
    """The files that belong to a run."""
    return folder / "run.checkpoint", folder / "evaluations" / "record.sqlite"


def main(folder, seed, kills):
    """Kill as many runs, at moments uniform over the time a run takes."""
    whole = folder / "whole"
    whole.mkdir()
    run(whole)  # once without looking at the clock: it may compile
    again = folder / "again"
    again.mkdir()
    moments = [time.monotonic()]
    expected = run(again, AfterEach(lambda: moments.append(time.monotonic())))
    generator = np.random.default_rng(seed)
    fates = []
    while sum(each["killed"] for each in fates) < kills and len(fates) < 3 * kills:
        generations = int(generator.integers(GENERATIONS))
        delay = generator.uniform(0.0, moments[generations + 1] - moments[generations])
        fates.append(fate(folder / str(len(fates)), expected, generations, delay))
    print(json.dumps({"points": len(expected.F), "fates": fates}))


if __name__ == "__main__":
    main(Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3]))
