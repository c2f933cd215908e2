"""Table at the end of the attitude-control tutorial: results of both calibrations."""

import json
from pathlib import Path

import pandas as pd
from mgeo_attitude.plan import read_json
from mgeo_calibration.calibration.document import read_json as read_calibration


def tabulate_results() -> pd.DataFrame:
    """Return the largest 1-sigma of each quantity, initially and after both calibrations.

    The files of both plans, calibrations and true errors are in the current folder.
    """
    first = _read_results("calibration", "plan.json", "truth.json")
    second = _read_results("second-calibration", "second.json", "second-truth.json")
    sigmas = pd.DataFrame(
        {
            "initial": first["initial"],
            "first, predicted": first["predicted"],
            "first, achieved": first["achieved"],
            "second, predicted": second["predicted"],
            "second, achieved": second["achieved"],
            "error / 1-sigma": second["error"],
        }
    )
    quantity = (first.index.str[:-2] + " [" + first["unit"] + "]").rename(None)
    return sigmas.groupby(quantity, sort=False).max().map("{:.3g}".format)


def _read_results(calibration: str, plan: str, truth: str) -> pd.DataFrame:
    """Return initial, predicted and achieved 1-sigma of each parameter, and the actual error
    divided by the 1-sigma.
    """
    found = read_calibration(Path(calibration, "calibration.json"))
    true = pd.DataFrame(json.loads(Path(truth).read_text())["parameters"])
    estimates, sigmas = found.build_table(), found.compare(read_json(plan)).iloc[3:]
    error = (estimates["estimate"] - true["value"]).abs() / estimates["sigma"]
    return sigmas.assign(initial=estimates["prior_sigma"].to_numpy(), error=error.to_numpy())
