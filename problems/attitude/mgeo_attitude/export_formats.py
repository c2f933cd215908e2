"""Registry of the file formats to which plans can be exported.

A new format needs only a new record here: `mgeo_attitude.plan.write_plan`, the help of ``mgeo
attitude export``, the table of the documentation and the tests use the records. The functions that
write a format are named by strings, so that help and completion need no imports.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from inspect import getfullargspec
from pathlib import Path


@dataclass(frozen=True)
class ExportFormat:
    """File format in which plans can be exported.

    Attributes
    ----------
    name : str
        Name of the format in help texts.
    suffix : str
        End of the file name. The longest matching suffix selects the format.
    description : str
        Contents of the file.
    function : str
        Function that returns the contents of a plan's file, as ``module:function`` within
        `mgeo_attitude.plan`. Its keyword-only arguments are the options of the format.
    package : str
        Additional package that the format needs, or an empty string.
    """

    name: str
    suffix: str
    description: str
    function: str
    package: str = ""

    def load(self) -> Callable[..., str | bytes]:
        """Import and return the function that converts a plan to the contents of a file."""
        module, _, name = self.function.partition(":")
        function: Callable[..., str | bytes] = getattr(
            import_module(f"mgeo_attitude.plan.{module}"), name
        )
        return function

    def list_options(self) -> list[str]:
        return getfullargspec(self.load()).kwonlyargs


FORMATS = (
    ExportFormat("JSON", ".json", "the complete plan, without loss of precision", "files:to_json"),
    ExportFormat(
        "uplink table",
        ".uplink.csv",
        "commands: start, duration and body rates to 1e-8 deg/s; a ramp belongs to the command "
        "that it leads to",
        "uplink:to_uplink_csv",
    ),
    ExportFormat("timeline", ".csv", "timeline with attitudes; each ramp is a row", "files:to_csv"),
    ExportFormat(
        "CCSDS AEM",
        ".aem",
        "Attitude Ephemeris Message, version 1.0 or 2.0 (KVN)",
        "aem:format_aem",
    ),
    ExportFormat(
        "SPICE C-kernel", ".bc", "attitudes and rates for SPICE", "spice:build_ck", "spiceypy"
    ),
    ExportFormat("SPICE clock", ".tsc", "clock kernel of the C-kernel", "spice:format_sclk"),
    ExportFormat("STK", ".a", "STK attitude file", "attitudes:format_stk"),
)


def find_format(path: Path | str) -> ExportFormat:
    """Return the export format that belongs to the suffix of a file name.

    Parameters
    ----------
    path : path

    Returns
    -------
    ExportFormat

    Raises
    ------
    ValueError
        If the name has an unknown suffix.
    """
    matches = [each for each in FORMATS if Path(path).name.endswith(each.suffix)]
    if not matches:
        suffixes = ", ".join(each.suffix for each in FORMATS)
        raise ValueError(f"{path}: expected a name that ends in {suffixes}")
    return max(matches, key=lambda each: len(each.suffix))
