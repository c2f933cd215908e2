"""The last table of the tutorial: what both of its flights were good for."""

import json
from pathlib import Path

import pandas as pd
from mgeo_attitude.plan import ManeuverPlan, read_json
from mgeo_calibration.calibration.document import read_json as read_calibration


def came_out(plan: ManeuverPlan) -> pd.DataFrame:
    """Largest 1-sigma of each block: initial, then predicted and achieved by each flight.

    Parameters
    ----------
    plan : the first one; the files of both flights are in the current folder.
    """
    first, second = _flight("", "plan.json"), _flight("second-", "second.json")
    accuracy = plan.build_accuracy_table().iloc[3:]
    return (
        pd.DataFrame(
            {
                "unit": accuracy["unit"],
                "initial": accuracy["before"],
                "predicted": first["predicted"],
                "achieved": first["achieved"],
                "predicted again": second["predicted"],
                "achieved again": second["achieved"],
                "error / 1-sigma": second["error"],
            }
        )
        .groupby(first["block"], sort=False)
        .max()
        .rename_axis(None)
        .map(lambda value: value if isinstance(value, str) else f"{value:.3g}")
    )


def _flight(name: str, plan: str) -> pd.DataFrame:
    """Predicted and achieved 1-sigma of each error, and the true error over it."""
    found = read_calibration(f"{name}calibration/calibration.json")
    true = pd.DataFrame(json.loads(Path(f"{name}truth.json").read_text())["parameters"])
    estimates, sigma = found.build_table(), found.compare(read_json(plan)).iloc[3:]
    error = (estimates["estimate"] - true["value"]).abs() / estimates["sigma"]
    return sigma.assign(block=estimates["block"].to_numpy(), error=error.to_numpy())
