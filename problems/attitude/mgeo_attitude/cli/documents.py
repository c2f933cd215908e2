"""Results as one JSON document, for scripts."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
import typer

from ..plan import ManeuverPlan


def print_document(document: Mapping[str, Any]) -> None:
    """Print it on stdout; numbers that JSON does not have become null."""
    typer.echo(json.dumps(_plain(document), indent=2, allow_nan=False, ensure_ascii=False))


def plan_document(plan: ManeuverPlan) -> dict[str, Any]:
    """What ``mgeo-attitude show`` tells of a plan; tables as lists of rows."""
    return {
        "scenario": plan.scenario.name,
        "converged": bool(plan.history.converged),
        "t_end_s": plan.t_end,
        "trace": plan.trace,
        "design": list(plan.design),
        "constraints": rows(plan.constraints()),
        "timeline": rows(plan.timeline()),
        "accuracy": rows(plan.accuracy()),
        "gains": rows(plan.gains()),
        "least_observable": rows(plan.least_observable(5)),
        "comparison": rows(plan.compare()),
    }


def rows(frame: pd.DataFrame) -> list[dict[str, Any]]:
    """The rows of a table, with its index unless that only counts them."""
    named = frame if isinstance(frame.index, pd.RangeIndex) else frame.reset_index()
    return [
        dict(zip(map(str, named.columns), row, strict=True))
        for row in named.to_numpy(object).tolist()
    ]


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {str(key): _plain(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(entry) for entry in value]
    if isinstance(value, np.generic):
        return _plain(value.item())
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return value if value is None or isinstance(value, bool | int | str) else str(value)
