"""Runs of a study, logged by COCO's observer for its post-processing ``cocopp``.

    python docs/studies/coco_data.py docs/studies/coco.toml studies/coco-data

from the folder above docs writes a folder for each algorithm of the study, and in it one for each
run. All problems of the study must be COCO's. Needs the extra: pip install 'mgeo[coco]'.
"""

import argparse
from itertools import product
from pathlib import Path

import cocoex
import joblib

from mgeo.benchmarks.coco import CocoProblem
from mgeo.studies.comparison_files import format_folder_names
from mgeo.studies.run import Task, record_run
from mgeo.studies.study_file import read_study


class ObservedProblem(CocoProblem):
    """A COCO function whose first `n_eval` evaluations the observer logs."""

    def __init__(self, problem, folder, algorithm, n_eval):
        super().__init__(problem.suite, problem.function, problem.n_var, problem.instance)
        self.place, self.algorithm, self.n_left = folder, algorithm, n_eval
        self._observed = None

    def _evaluate(self, X, out, *args, **kwargs):
        super()._evaluate(X, out, *args, **kwargs)
        if self._observed is None:
            self._observed = self._observe()
        for x in X[: self.n_left].astype(float):
            self._observed(x)
        self.n_left = max(0, self.n_left - len(X))
        if not self.n_left:
            self._observed.free()  # writes what is buffered

    def _observe(self):
        """Return COCO's function, observed; neither points nor the front are logged."""
        self.place.parent.mkdir(parents=True, exist_ok=True)
        self._suite = cocoex.Suite(self.suite, f"instances: {self.instance}", "")
        observer = cocoex.Observer(
            "bbob-biobj" if "biobj" in self.suite else "bbob",
            f'outer_folder: "{self.place.parent}" result_folder: "{self.place.name}" '
            f'algorithm_name: "{self.algorithm}" log_nondominated: none '
            "log_decision_variables: none",
        )
        return self._suite.get_problem_by_function_dimension_instance(
            self.function, self.n_var, self.instance, observer
        )


def log_run(problem, algorithm, label, n_eval, seed, folder):
    """Make one run and log it into a folder of its own below `folder`."""
    name = f"{problem.name().replace(' ', '-')}-seed{seed}"
    place = folder.absolute() / name
    return record_run(Task(ObservedProblem(problem, place, label, n_eval), algorithm, n_eval, seed))


def main():
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("study", type=Path, help="a study file")
    parser.add_argument("folder", type=Path, help="folder to write")
    parser.add_argument("--jobs", type=int, default=-1, help="processes; -1: one per processor")
    given = parser.parse_args()
    study = read_study(given.study)
    folders = format_folder_names(algorithm.label for algorithm in study.algorithms)
    calls = []
    for configuration in study.problems:
        problem = configuration.build()
        n_eval, _ = study.compute_budget(problem)
        for algorithm, seed in product(study.algorithms, study.seeds):
            folder = given.folder / folders[algorithm.label]
            run = problem, algorithm.build(problem), algorithm.label, n_eval, seed, folder
            calls.append(joblib.delayed(log_run)(*run))
    joblib.Parallel(given.jobs, verbose=1)(calls)


if __name__ == "__main__":
    main()
