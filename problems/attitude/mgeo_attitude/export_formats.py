"""Formats of plans as files, one record each.

To add one is to add a record here: `mgeo_attitude.plan.write_plan`, the help of ``mgeo attitude
export``, the table of the documentation and the tests follow. The functions are named and not
imported, so that help and completion do not wait for them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from inspect import getfullargspec
from pathlib import Path


@dataclass(frozen=True)
class ExportFormat:
    """A format of plans as files.

    Attributes
    ----------
    name : str
    suffix : str
        Ending of the file's name; of several that fit the longest counts.
    description : str
        What the file contains.
    function : str
        ``module:function`` within `mgeo_attitude.plan`, which makes the file's content of a plan;
        its keyword-only arguments are options of the format.
    package : str
        Package that the format needs beyond the requirements; empty for none.
    """

    name: str
    suffix: str
    description: str
    function: str
    package: str = ""

    def load(self) -> Callable[..., str | bytes]:
        """Import the function."""
        module, _, name = self.function.partition(":")
        function: Callable[..., str | bytes] = getattr(
            import_module(f"mgeo_attitude.plan.{module}"), name
        )
        return function

    def options(self) -> list[str]:
        """Names of the options."""
        return getfullargspec(self.load()).kwonlyargs


FORMATS = (
    ExportFormat("JSON", ".json", "the plan, which reads back exactly", "files:to_json"),
    ExportFormat(
        "uplink table",
        ".uplink.csv",
        "commands: start, duration and body rates to 1e-8 deg/s; a ramp belongs to the command "
        "it is for",
        "uplink:to_uplink_csv",
    ),
    ExportFormat("timeline", ".csv", "the timeline with attitudes", "files:to_csv"),
    ExportFormat(
        "CCSDS AEM", ".aem", "Attitude Ephemeris Message, version 1.0 or 2.0 (KVN)", "aem:aem_text"
    ),
    ExportFormat(
        "SPICE C-kernel", ".bc", "attitudes and rates for SPICE", "spice:ck_bytes", "spiceypy"
    ),
    ExportFormat("SPICE clock", ".tsc", "clock kernel of the C-kernel", "spice:sclk_text"),
    ExportFormat("STK", ".a", "STK attitude file", "attitudes:stk_text"),
)


def format_of(path: Path | str) -> ExportFormat:
    """Return the format of a file by the ending of its name.

    Raises
    ------
    ValueError
        For a name with none of the suffixes.
    """
    found = [each for each in FORMATS if Path(path).name.endswith(each.suffix)]
    if not found:
        suffixes = ", ".join(each.suffix for each in FORMATS)
        raise ValueError(f"{path}: expected a name that ends in {suffixes}")
    return max(found, key=lambda each: len(each.suffix))
