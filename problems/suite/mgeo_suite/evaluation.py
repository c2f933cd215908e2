"""Filter runs of designs with different suites: those of a form together, with one kernel."""

from __future__ import annotations

import dataclasses

import numpy as np
from mgeo_attitude._typing import Floats, Ints
from mgeo_attitude.filter.evaluator import Evaluation, evaluate

from mgeo_suite.suites import SuiteModels


def evaluated(
    suites: SuiteModels, choices: Ints, maneuvers: Floats, threads: int | None, history: bool
) -> Evaluation:
    """Runs of n choices, each with its maneuvers (n, 4 m), in their order.

    Of the states, those that all forms begin with: attitude and gyro.
    """
    if not len(choices):
        return evaluate(suites.model, maneuvers, covariance=True)
    distinct, which = np.unique(choices, axis=0, return_inverse=True)
    forms, which = suites.forms(distinct), which.reshape(-1)
    parts = []
    for number in np.unique(forms):
        same = np.flatnonzero(forms == number)
        rows = np.flatnonzero(forms[which] == number)
        form = suites.form_of(distinct[same[0]])
        result = evaluate(
            form,
            maneuvers[rows],
            threads,
            history=history,
            covariance=True,
            variants=[suites.variant(choice) for choice in distinct[same]],
            which=np.searchsorted(same, which[rows]),
        )
        parts.append((rows, _of_states(result, form.suite.n_kinematic)))
    return _joined(parts, suites, maneuvers)


def _of_states(result: Evaluation, n: int) -> Evaluation:
    """The leading states of a result alone."""
    return dataclasses.replace(
        result, covariance=result.covariance[:, :n, :n], variances=result.variances[..., :n]
    )


def _joined(
    parts: list[tuple[Ints, Evaluation]], suites: SuiteModels, maneuvers: Floats
) -> Evaluation:
    """Results of some rows each, as one."""
    order = np.argsort(np.concatenate([rows for rows, _ in parts]))
    joined = {}
    for field in dataclasses.fields(Evaluation):
        values = [getattr(result, field.name) for _, result in parts]
        if isinstance(values[0], np.ndarray):
            stacked = np.concatenate(values)
            joined[field.name] = stacked[order] if len(stacked) else stacked
    return Evaluation(**joined, plan=suites.model.schedule(maneuvers))
