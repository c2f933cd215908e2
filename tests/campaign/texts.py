"""Scenarios, studies and plans: files that people write, mail and edit."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import tomlkit
from mgeo_attitude import Scenario
from mgeo_attitude.plan import read_json

from mgeo.plugins.problems import load_problem
from mgeo.runs.prepare import prepare
from mgeo.store.scenario_file import read_scenario
from mgeo.studies import read_comparison, read_study
from mgeo.studies.record import StudyRun

from .harness import Attempt, Box, kind
from .mutations import spoiled_arrays, spoiled_bytes, spoiled_table, spoiled_tree
from .run_folders import spoil_json
from .templates import STUDY, put


def spoiled_toml(box: Box, path: Path, text: str) -> None:
    """Write it spoiled: another value, or other bytes."""
    if box.chance(0.7):
        tree = _without_none(spoiled_tree(box, tomllib.loads(text)))
        text = tomlkit.dumps(tree) if isinstance(tree, dict) else str(tree)
        path.write_bytes(text.encode("utf-8", "surrogatepass"))
    else:
        path.write_bytes(spoiled_bytes(box, text.encode()))


def _without_none(tree: Any) -> Any:
    """As TOML can say it."""
    if isinstance(tree, dict):
        return {str(k): _without_none(v) for k, v in tree.items() if v is not None}
    if isinstance(tree, list):
        return [_without_none(v) for v in tree if v is not None]
    return tree


def _scenario_text(box: Box) -> str:
    preset = box.pick([Scenario.paper, Scenario.cubesat_6u])()
    text = preset.to_toml()
    if box.chance(0.3):
        text += '[wheels]\ninertia = [1.0, 1.0, 2.0]\nmax_torque = 0.1\n[[path_limits]]\n' \
                'boresight = [1, 0, 0]\nhalf_angle_deg = 20.0\n'  # fmt: skip
    return text


@kind(weight=12)
def scenario_read(box: Box) -> Attempt:
    path = Path("scenario.toml")
    spoiled_toml(box, path, _scenario_text(box))

    def sound(scenario: Scenario) -> None:
        assert Scenario.from_dict(scenario.to_dict()) == scenario
        assert Scenario.from_toml(scenario.to_toml()) == scenario

    return Attempt(lambda: Scenario.from_toml(path), ("scenario.toml",), sound=sound)


@kind(weight=4)
def scenario_solved(box: Box) -> Attempt:
    """Refused or not, it is never run: a good scenario may take hours."""
    path = Path("scenario.toml")
    spoiled_toml(box, path, _scenario_text(box))

    def action() -> Any:
        return load_problem("attitude", read_scenario("attitude", str(path)))

    return Attempt(action, sound=lambda problem: json.dumps(problem.options(), allow_nan=False))


@kind(weight=2)
def scenario_of_another_problem(box: Box) -> Attempt:
    path = Path("load.toml")
    spoiled_toml(box, path, "load = 700.0\n")
    options = ["--evaluations", "8", "--walkers", "2", "--out", "made", "-q"]
    return Attempt(["mgeo", "solve", "cantilever", "--scenario", str(path), *options],
                   writes=("work/made/*",))  # fmt: skip


@kind(weight=10)
def study_read(box: Box) -> Attempt:
    path = Path("study.toml")
    spoiled_toml(box, path, STUDY)

    def action() -> Any:
        study = read_study(path).reduced(8, None)
        return [c.build(case.build()) for case in study.problems for c in study.algorithms[:5]]

    return Attempt(action)


@kind(weight=0.3)
def study_run(box: Box) -> Attempt:
    put(box, "study", "s")
    path = Path("s/study.toml")
    spoiled_toml(box, path, STUDY)
    action = ["mgeo", "study", str(path), "--evaluations", "8", "--seeds", "1", "--jobs", "1", "-q"]
    return Attempt([*action, "--out", "o"], writes=("work/o/*",), codes=(0, 3))


@kind(weight=8)
def study_results_read(box: Box) -> Attempt:
    folder = put(box, "study") / "out"
    name = box.pick(["provenance.json", "table.csv", "runs.csv", "fronts.csv"])
    path = folder / name
    if name.endswith(".json"):
        spoil_json(box, path)
    else:
        spoil = spoiled_table if box.chance(0.75) else spoiled_bytes
        path.write_bytes(spoil(box, path.read_bytes()))

    def sound(comparison: Any) -> None:
        comparison.overview()
        comparison.to_latex()
        comparison.order()

    return Attempt(lambda: read_comparison(folder), ("out",), sound=sound)


@kind(weight=8)
def study_record_read(box: Box) -> Attempt:
    folder = put(box, "study") / "out" / "runs"
    path = box.pick(sorted(folder.iterdir()))
    if box.chance(0.7):
        with np.load(path) as archive:
            path.write_bytes(spoiled_arrays(box, dict(archive)))
    else:
        path.write_bytes(spoiled_bytes(box, path.read_bytes()))

    def sound(record: Any) -> None:
        assert record.front_F.ndim == 2
        assert np.isfinite(record.F).all()
        assert len(list(record.fronts([1, 8, 24]))) == 3

    return Attempt(lambda: StudyRun.read(path), (path.name,), sound=sound)


@kind(weight=0.3)
def study_record_used(box: Box) -> Attempt:
    folder = put(box, "study")
    path = box.pick(sorted((folder / "out" / "runs").iterdir()))
    with np.load(path) as archive:
        path.write_bytes(spoiled_arrays(box, dict(archive)))
    return Attempt(["mgeo", "study", str(folder / "study.toml"), "--out", str(folder / "out"),
                    "--resume", "--jobs", "1", "-q"], (path.name,),
                   writes=("work/study/out/*",))  # fmt: skip


@kind(weight=1)
def plan_read(box: Box) -> Attempt:
    path = put(box, "plans") / "plan.json"
    spoil_json(box, path)
    return Attempt(lambda: read_json(path), ("plan.json",), sound=lambda plan: plan.timeline())


@kind(weight=0.4)
def plan_shown(box: Box) -> Attempt:
    path = put(box, "plans") / "plan.json"
    spoil_json(box, path)
    return Attempt(["mgeo", "attitude", "show", str(path)], ("plan.json",))


@kind(weight=4)
def configuration_made(box: Box) -> Attempt:
    """Options and parameters as a program, or the parser of a command line, passes them on."""
    made = {
        "problem": box.pick(["zdt1", "cantilever"]),
        "options": {},
        "algorithm": box.pick(["mgeo-real", "mgeo-var", "mgeo-directed", "nsga2", "moead", "rvea"]),
        "parameters": {},
        "evaluations": 8,
        "seed": 1,
    }
    name = box.pick(["sigma", "tau", "n_walkers", "perturbation", "population", "bits",
                     "extreme_weights", "coupling", "widths", "restart", "patience",
                     "max_candidates"])  # fmt: skip
    made["parameters"] = {name: 1}
    tree = spoiled_tree(box, made)
    if not isinstance(tree, dict) or not isinstance(tree.get("problem"), str):
        tree = made
    problem = tree.pop("problem")
    known = {k: v for k, v in tree.items() if k in made and not (k == "evaluations" and v is None)}
    return Attempt(lambda: prepare(problem, known.pop("options", None), **known))
