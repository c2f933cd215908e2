"""Commands of the package mgeo-calibration, and the hint if the package is not installed."""

from __future__ import annotations

import importlib.util

#: Subcommands of ``mgeo attitude`` that the package adds.
COMMANDS = ("verify", "fly", "calibrate")
#: Command that installs the package from a checkout of the repository.
INSTALL_COMMAND = "pip install ./problems/calibration"


def is_calibration_installed() -> bool:
    """Return whether the package mgeo-calibration is installed."""
    return importlib.util.find_spec("mgeo_calibration") is not None


def suggest_verification(source: object) -> dict[str, str]:
    """Return the next command that verifies a plan, or the command that installs verification.

    Parameters
    ----------
    source : object
        Path of a run folder or plan file.

    Returns
    -------
    dict of str to str
        Command by its purpose.
    """
    if is_calibration_installed():
        return {"Verify by simulation": f"mgeo attitude verify {source}"}
    return {"Install verification": INSTALL_COMMAND}
