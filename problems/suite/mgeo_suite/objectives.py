"""Objectives of a sensor suite and its calibration maneuvers."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from mgeo_attitude import Evaluation, FilterModel, Scenario
from mgeo_attitude._typing import Floats
from mgeo_attitude.criteria.objectives import OBJECTIVES as PLAN_OBJECTIVES
from mgeo_attitude.criteria.objectives import attitude_accuracy_deg
from mgeo_attitude.settings.errors import InvalidValue, format_known_names

_INDICATOR_DECADES = 4.0  # decades of accuracy per unit of the indicator space
_REFERENCE_ACCURACY_DEG = 1e-3  # accuracy at the origin of the indicator space


@dataclass(frozen=True)
class SuiteObjective:
    """Objective of a sensor suite and its maneuvers, to be minimized.

    Attributes
    ----------
    label : str
        Name with unit.
    value : function of model, evaluation and resources (n, 3)
        Function that returns the values of n designs, shape (n,). Resources are price, mass and
        power.
    indicator : function of values, scenario and maximum resources (3,)
        Function that scales values to order 1, for the performance indicators of studies.
    """

    label: str
    value: Callable[[FilterModel, Evaluation, Floats], Floats]
    indicator: Callable[[Floats, Scenario, Floats], Floats]


def validate_objectives(names: Sequence[str], has_required_sigma: bool) -> tuple[str, ...]:
    """Check the names of objectives, and return them as a tuple.

    Parameters
    ----------
    names
        Names of objectives in `OBJECTIVES`.
    has_required_sigma
        Whether the scenario requires 1-sigmas of states, which "t_required" needs.

    Raises
    ------
    InvalidValue
        If a name is unknown or repeated, or needs requirements that the scenario does not have.
    """
    if isinstance(names, str) or not names:
        raise InvalidValue("objectives", names, "expected a list of at least one name")
    for i, name in enumerate(names):
        key = f"objectives[{i}]"
        if name not in OBJECTIVES:
            raise InvalidValue(
                key, name, f"unknown objective{format_known_names(name, OBJECTIVES)}"
            )
        if name in names[:i]:
            raise InvalidValue(key, name, "expected no duplicates")
        if name == "t_required" and not has_required_sigma:
            raise InvalidValue(key, name, "the scenario has no required_sigma")
    return tuple(names)


def _build_resource_objective(label: str, column: int) -> SuiteObjective:
    return SuiteObjective(
        label,
        lambda model, result, resources: resources[:, column],
        lambda values, scenario, maximum: values / maximum[column],
    )


def _build_plan_objective(name: str) -> SuiteObjective:
    objective = PLAN_OBJECTIVES[name]
    return SuiteObjective(
        objective.label,
        lambda model, result, resources: objective.value(model, result),
        lambda values, scenario, maximum: objective.indicator(values, scenario),
    )


def _compute_accuracy(model: FilterModel, result: Evaluation, resources: Floats) -> Floats:
    accuracy = attitude_accuracy_deg(result.covariance)
    return np.where(np.isnan(result.t_end), np.nan, accuracy)


#: Objectives by name.
OBJECTIVES = {
    "price": _build_resource_objective("price [kEUR]", 0),
    "mass": _build_resource_objective("mass [g]", 1),
    "power": _build_resource_objective("power [mW]", 2),
    "attitude": SuiteObjective(
        "attitude 1-sigma [deg]",
        _compute_accuracy,
        lambda values, scenario, maximum: (
            np.log10(values / _REFERENCE_ACCURACY_DEG) / _INDICATOR_DECADES
        ),
    ),
    "t_end": _build_plan_objective("t_end"),
    "t_required": _build_plan_objective("t_required"),
    "trace": _build_plan_objective("trace"),
}
