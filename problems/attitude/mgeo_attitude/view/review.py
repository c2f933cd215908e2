"""A plan as a document for a review: satellite, sensors, limits, timeline, budget, alternatives."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from mgeo.plugins.shown import Review, Section
from mgeo_attitude.environment.times import utc_texts
from mgeo_attitude.filter.history import filter_history
from mgeo_attitude.maneuvers.motion import Phase
from mgeo_attitude.sensors.suite import block_units
from mgeo_attitude.settings.base import annotation_of
from mgeo_attitude.settings.types import Unit
from mgeo_attitude.view import at_best, satellite
from mgeo_attitude.view.describe import exactly
from mgeo_attitude.view.observability import alternatives, budget
from mgeo_attitude.view.observability.alternatives import AS_IT_IS
from mgeo_attitude.view.plans import MOST_SAMPLES, Plans

if TYPE_CHECKING:
    from mgeo_attitude._typing import Floats
    from mgeo_attitude.filter.history import FilterHistory
    from mgeo_attitude.filter.model import FilterModel
    from mgeo_attitude.scenario.scenario import Scenario

_SECONDS = 19  # characters of a date and time to the second
_WITH_UNIT = re.compile(r"_(deg|nt|arcsec)(_per_.*)?$")


def review(plans: Plans) -> Review:
    """The document about the only plan of a view; some seconds."""
    problem, design = plans.problem, plans.X[0]
    scenario, model = problem.scenario, problem.model
    (answer,) = plans.answers()
    history = filter_history(model, design)
    trajectory = plans.trajectory(0)
    known = budget.budget(model, design, history)
    changes = alternatives.remedies(model, design, history.t_end, scenario.maneuvers.max_rate_deg_s)
    why = budget.reasons(model, known, changes, history, at_best.known_limit(problem))
    phases, (limits,) = trajectory.phases, plans.limits()
    calibration = [phase for phase in phases if phase.end <= history.t_end]
    others = alternatives.without_optimizer(scenario, calibration)
    compared = alternatives.compare(problem, {"this plan": design, **others}, history.t_end)
    edges = np.array([*(phase.start for phase in phases), trajectory.end])
    stamps = utc_texts(scenario.epoch, edges)
    facts = satellite.facts(problem)
    sections = [
        Section("Satellite", table=pd.DataFrame({"": facts.values()}, index=list(facts))),
        Section("Gyro and sensors", table=_instruments(scenario)),
        Section("Limits", table=limits.assign(kept=limits["margin"] >= 0.0))
        if len(limits)
        else Section("Limits", ("None beside the rates and durations of maneuvers.",)),
        Section(
            "Timeline",
            table=_timeline(model, list(stamps[:-1]), history, phases, design),
            note="rates about body axes; bought: the phase's part of the fall of the trace's "
            "logarithm; then: 1-sigma of the worst body axis at its end",
        ),
        Section(
            "Why it is no smaller",
            tuple(why),
            known,
            "error budget: 1-sigma of the worst body axis by its sources, whose squares add up"
            + exactly(scenario),
        ),
        Section(
            "What would help",
            table=_worth(changes),
            note="1-sigma of the worst body axis, each by a run of the filter; changes that make "
            "some smaller by 2 %; limits are not looked at",
        ),
        Section(
            "How long sensors measure",
            table=budget.sensor_use(model, calibration, design, history),
        ),
        Section(
            "Objectives of the plan (promised), and kept by " + MOST_SAMPLES, table=promised(plans)
        ),
        Section(
            f"Beside plans that need no optimizer, after {history.t_end:.6g} s",
            table=compared.T,
            note="turns at the greatest rate, as long in all as this plan's; limits are not looked "
            "at",
        ),
    ]
    start, end = stamps[0][:_SECONDS], stamps[-1][:_SECONDS]
    title = f"{scenario.name}: calibration maneuvers, {start} to {end} UTC"
    return Review(title, answer, tuple(sections))


def _worth(changes: pd.DataFrame) -> pd.DataFrame:
    better = (changes < 0.98 * changes.loc[AS_IT_IS]).any(axis=1)
    return changes[better | (changes.index == AS_IT_IS)]


def _timeline(
    model: FilterModel,
    stamps: list[str],
    history: FilterHistory,
    phases: tuple[Phase, ...],
    design: Floats,
) -> pd.DataFrame:
    """Each command in UTC, with what it buys: the trace's fall, and what is required or asked."""
    table = pd.DataFrame(
        {
            "start UTC": [text.removesuffix(".000000") for text in stamps],
            "for [s]": [phase.duration for phase in phases],
            **{
                f"{axis} [deg/s]": [phase.rates_deg_s[i] for phase in phases]
                for i, axis in enumerate("xyz")
            },
            "turned [deg]": [phase.swept_deg for phase in phases],
        },
        index=pd.Index([phase.label for phase in phases], name="phase"),
    )
    bought = budget.contributions(model, design, history).iloc[1:]
    shown = {"bought [%]": bought["contribution [%]"]}
    steps = np.rint(bought["time [s]"] / model.step).astype(np.int64)
    sigma = history.sigma[steps].reshape(len(steps), -1, 3).max(axis=2)
    asked = [b for b in range(sigma.shape[1]) if np.isfinite(model.required_sigma[3 * b])]
    for block in sorted({0, *asked}):
        unit = block_units(model.suite)[block]
        values = pd.Series(sigma[:, block] * unit.factor, index=bought.index)
        shown[f"then {unit.label} [{unit.unit}]"] = values
    for name, column in shown.items():  # what follows teaches nothing that is told
        table[name] = column.reindex(table.index)
    return table


def _instruments(scenario: Scenario) -> pd.DataFrame:
    """Noise, samples, and errors at the start of each."""
    suite = scenario.suite
    sigma = suite.initial_sigma(np.radians(scenario.initial.attitude_deg)).reshape(-1, 3)
    errors: dict[str, list[str]] = {}
    for name, unit, values in zip(suite.blocks, block_units(suite), sigma, strict=True):
        owner, _, error = name.rpartition(".")
        text = f"{error.replace('_', ' ')} {values.max() * unit.factor:.3g} {unit.unit}"
        errors.setdefault(owner, []).append(text.removesuffix(" -"))
    rows = {}
    parts: list[tuple[str, Any]] = [("gyro", suite.gyro)]
    parts += [(sensor.name, sensor) for sensor in suite.sensors]
    for name, part in parts:
        units = {key: annotation_of(type(part), key, Unit) for key in part.noise_parameters}
        noise = [
            f"{_WITH_UNIT.sub('', key).replace('_', ' ')} {_numbers(getattr(part, key))} "
            f"{unit.text if unit else ''}".strip()
            for key, unit in units.items()
        ]
        every = getattr(part, "sample_interval", None) or scenario.step
        rows[name] = {
            "kind": getattr(part, "kind", "gyro"),
            "noise": ", ".join(noise),
            "every [s]": f"{every:g}",
            "errors at the start, 1-sigma": ", ".join(errors.get(name, [])),
        }
    return pd.DataFrame.from_dict(rows, orient="index").rename_axis("")


def _numbers(value: float | tuple[float, ...]) -> str:
    """One for all axes, or one for each."""
    return " / ".join(f"{v:g}" for v in (value if isinstance(value, tuple) else (value,)))


def promised(plans: Plans) -> pd.DataFrame:
    """What the only plan promises and most flights keep, a row an objective; `Plans.promises`."""
    (row,) = plans.promises().to_numpy(float)
    columns = ["promised", "kept", "kept / promised [-]"]
    return pd.DataFrame(row.reshape(-1, 3), index=list(plans.problem.obj_names), columns=columns)
