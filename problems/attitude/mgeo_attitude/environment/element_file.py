"""Reader of element sets: mean-elements messages (OMM of CCSDS 502.0-B) and two-line sets.

Messages may be in KVN, XML, JSON or CSV.
"""

from __future__ import annotations

import io
import itertools
import json
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any

from mgeo_attitude.environment.element_set import MeanElements, TLEOrbit, parse_epoch
from mgeo_attitude.settings.errors import InvalidValue

Fields = Mapping[str, Any]

#: Supported values of metadata. Tables of elements omit most of the keys.
_SUPPORTED = {
    "CENTER_NAME": ("EARTH",),
    "REF_FRAME": ("TEME",),
    "TIME_SYSTEM": ("UTC",),
    "MEAN_ELEMENT_THEORY": ("SGP4", "SGP", "SGP/SGP4", "SGP4/SGP"),
    "EPHEMERIS_TYPE": ("0", "2", "SGP", "SGP4"),
}
#: Keywords of a message by field of `MeanElements`.
_KEYWORDS = {
    "mean_motion_rev_day": "MEAN_MOTION",
    "eccentricity": "ECCENTRICITY",
    "inclination_deg": "INCLINATION",
    "raan_deg": "RA_OF_ASC_NODE",
    "argument_of_perigee_deg": "ARG_OF_PERICENTER",
    "mean_anomaly_deg": "MEAN_ANOMALY",
    "bstar": "BSTAR",
}
_MAX_LISTED = 10  # largest number of objects in an error message


@dataclass(frozen=True)
class Entry:
    """An unchecked element set of a file, with its object and epoch."""

    name: str
    designator: str
    number: str
    epoch: datetime
    content: Fields

    def __str__(self) -> str:
        return " ".join(filter(None, (self.name, self.designator, self.number)))

    def matches_object(self, object_name: str) -> bool:
        """Return whether a name, designator or catalog number matches; empty matches any."""
        written = self.content.get("line1", "")[2:7]  # may contain a letter (Alpha-5)
        names = ("", self.name, self.designator, self.number, written)
        same = object_name.casefold() in {name.casefold() for name in names}
        return same or object_name.lstrip("0") == self.number.lstrip("0")


def read_element_set(
    text: str, object_name: str, epoch: datetime, file: str
) -> TLEOrbit | MeanElements | None:
    """Return the element set closest to an epoch from the text of a file.

    Parameters
    ----------
    text : str
    object_name : str
        Name, international designator or catalog number of the object; empty for a file of one
        object.
    epoch : datetime with UTC offset
    file : str
        Name of the file, for the element set's ``source``.

    Returns
    -------
    TLEOrbit, MeanElements or None
        None if the text contains no element sets.

    Raises
    ------
    ValueError
        If an entry is invalid, or if several objects match.
    """
    try:
        entries = [_build_entry(fields) for fields in _parse_messages(text)] or _parse_line_pairs(
            text
        )
    except Exception as error:  # the package raises many kinds for invalid text
        raise ValueError(
            f"expected mean-elements messages (OMM) or pairs of lines: {error}"
        ) from error
    if not entries:
        return None
    fitting = [entry for entry in entries if entry.matches_object(object_name)]
    if len({entry.number or entry.designator or entry.name for entry in fitting}) != 1:
        names = list(dict.fromkeys(map(str, fitting or entries)))
        more = f" and {len(names) - _MAX_LISTED} more" if len(names) > _MAX_LISTED else ""
        raise ValueError(
            f"object = {object_name!r} matches {len(fitting)} entries: expected the name or number of "
            f"one of {', '.join(names[:_MAX_LISTED])}{more}"
        )
    entry = min(fitting, key=lambda each: abs(each.epoch - epoch))
    source = f"{file}, {entry}"
    try:
        if "line1" in entry.content:
            return TLEOrbit(source=source, **entry.content)
        return _build_mean_elements(entry.content, source)
    except ValueError as error:
        raise ValueError(f"{entry}: {error}") from None


def _parse_messages(text: str) -> list[Fields]:
    """Return the fields of each message in a text by keyword; empty without messages."""
    from sgp4 import omm

    start = text.lstrip()[:1]
    if start == "<" and "MEAN_MOTION" in text:
        return list(omm.parse_xml(io.StringIO(text)))
    if start and start in "[{":
        data = json.loads(text)
        return data if isinstance(data, list) else [data]
    if "CCSDS_OMM_VERS" in text:
        return [_parse_kvn(part) for part in text.split("CCSDS_OMM_VERS")[1:]]
    if "MEAN_MOTION" in text.partition("\n")[0]:
        return list(omm.parse_csv(text.splitlines()))
    return []


def _parse_kvn(text: str) -> Fields:
    """Return the fields of a message in KVN, without units in brackets."""
    pairs = (line.partition("=") for line in text.splitlines()[1:] if "=" in line)
    return {key.strip(): value.partition("[")[0].strip() for key, _, value in pairs}


def _build_entry(fields: Fields) -> Entry:
    name, designator, number, epoch = (
        str(fields.get(key) or "") for key in ("OBJECT_NAME", "OBJECT_ID", "NORAD_CAT_ID", "EPOCH")
    )
    return Entry(name, designator, number, _parse_utc(epoch), fields)


def _parse_utc(stamp: str) -> datetime:
    return datetime.fromisoformat(stamp).replace(tzinfo=UTC)


def _parse_line_pairs(text: str) -> list[Entry]:
    """Return the pairs of lines, each optionally preceded by a line with the object's name."""
    from sgp4.alpha5 import from_alpha5

    lines = [line.rstrip() for line in text.splitlines()]
    entries = []
    for k, (line1, line2) in enumerate(itertools.pairwise(lines)):
        if not (line1.startswith("1 ") and line2.startswith("2 ")):
            continue
        above = lines[k - 1] if k else ""
        name = "" if above.startswith(("1 ", "2 ", "#")) else above.removeprefix("0 ").strip()
        launch = line1[9:17].strip()
        designator = f"{19 + (launch[:2] < '57')}{launch[:2]}-{launch[2:]}" if launch else ""
        content = {"line1": line1, "line2": line2}
        number = str(from_alpha5(line1[2:7].strip()))
        entries.append(Entry(name, designator, number, parse_epoch(line1), content))
    return entries


def _build_mean_elements(fields: Fields, source: str) -> MeanElements:
    """Return the element set of a message.

    Raises
    ------
    ValueError
        If theory, frame or time system is not supported, or if a number is invalid.
    """
    for key, supported in _SUPPORTED.items():
        value = str(fields.get(key) or supported[0])
        if value.upper() not in supported:
            raise ValueError(f"{key} = {value!r:.60}: expected {' or '.join(supported)}")
    numbers = {}
    for name, key in _KEYWORDS.items():
        try:
            numbers[name] = float(fields[key])
        except (KeyError, TypeError, ValueError):
            raise ValueError(f"{key} = {fields.get(key)!r:.60}: expected a number") from None
    try:
        return MeanElements(source=source, epoch=_parse_utc(fields["EPOCH"]), **numbers)
    except InvalidValue as error:
        key = _KEYWORDS.get(error.key, error.key)
        raise ValueError(f"{key} = {error.value!r}: {error.expected}") from None
