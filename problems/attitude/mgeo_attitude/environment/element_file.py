"""Reader of element sets: mean-elements messages (OMM of CCSDS 502.0-B) and two-line element sets.

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

#: Supported values of metadata. Files with many objects omit most of the keys.
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
#: Largest number of objects that an error message lists.
_MAX_LISTED = 10


@dataclass(frozen=True)
class Entry:
    """Element set as read from a file, before validation.

    The object has a name, an international designator and a catalog number.
    """

    name: str
    designator: str
    number: str
    epoch: datetime
    content: Fields

    def __str__(self) -> str:
        return " ".join(filter(None, (self.name, self.designator, self.number)))

    def matches_object(self, object_name: str) -> bool:
        """Return True if a name, designator or catalog number identifies the object.

        An empty name matches every object.
        """
        printed_number = self.content.get("line1", "")[
            2:7
        ]  # The number may contain a letter (Alpha-5).
        names = ("", self.name, self.designator, self.number, printed_number)
        is_equal = object_name.casefold() in {name.casefold() for name in names}
        return is_equal or object_name.lstrip("0") == self.number.lstrip("0")


def read_element_set(
    text: str, object_name: str, epoch: datetime, file: str
) -> TLEOrbit | MeanElements | None:
    """Return the element set of an object from the text of a file.

    If the file contains several element sets of the object, the one with the epoch closest to
    `epoch` is returned.

    Parameters
    ----------
    text : str
    object_name : str
        Name, international designator or catalog number of the object; empty for a file of one
        object.
    epoch : datetime with UTC offset
    file : str
        Name of the file, which becomes part of the element set's ``source``.

    Returns
    -------
    TLEOrbit, MeanElements or None
        None if the text contains no element sets.

    Raises
    ------
    ValueError
        If an entry is invalid, if no object matches, or if several objects match.
    """
    try:
        entries = [_build_entry(fields) for fields in _parse_messages(text)] or _parse_line_pairs(
            text
        )
    except Exception as error:  # The package raises many kinds of exceptions for invalid text.
        raise ValueError(
            f"expected mean-elements messages (OMM) or pairs of lines: {error}"
        ) from error
    if not entries:
        return None
    matches = [entry for entry in entries if entry.matches_object(object_name)]
    if len({entry.number or entry.designator or entry.name for entry in matches}) != 1:
        names = list(dict.fromkeys(map(str, matches or entries)))
        more = f" and {len(names) - _MAX_LISTED} more" if len(names) > _MAX_LISTED else ""
        raise ValueError(
            f"object = {object_name!r} matches {len(matches)} entries: expected the name or number "
            f"of one of {', '.join(names[:_MAX_LISTED])}{more}"
        )
    entry = min(matches, key=lambda each: abs(each.epoch - epoch))
    source = f"{file}, {entry}"
    try:
        if "line1" in entry.content:
            return TLEOrbit(source=source, **entry.content)
        return _build_mean_elements(entry.content, source)
    except ValueError as error:
        raise ValueError(f"{entry}: {error}") from None


def _parse_messages(text: str) -> list[Fields]:
    """Parse each mean-elements message in a text into a dict that maps keywords to values.

    The list is empty if the text contains no messages.
    """
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
    """Parse a message in KVN notation (lines ``KEY = value``) into a dict, without units in
    brackets.
    """
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
    """Return an `Entry` for each two-line element set in a text.

    The line before each pair of lines may contain the object's name.
    """
    from sgp4.alpha5 import from_alpha5

    lines = [line.rstrip() for line in text.splitlines()]
    entries = []
    for k, (line1, line2) in enumerate(itertools.pairwise(lines)):
        if not (line1.startswith("1 ") and line2.startswith("2 ")):
            continue
        previous_line = lines[k - 1] if k else ""
        name = (
            ""
            if previous_line.startswith(("1 ", "2 ", "#"))
            else previous_line.removeprefix("0 ").strip()
        )
        launch = line1[9:17].strip()
        designator = f"{19 + (launch[:2] < '57')}{launch[:2]}-{launch[2:]}" if launch else ""
        content = {"line1": line1, "line2": line2}
        number = str(from_alpha5(line1[2:7].strip()))
        entries.append(Entry(name, designator, number, parse_epoch(line1), content))
    return entries


def _build_mean_elements(fields: Fields, source: str) -> MeanElements:
    """Build `MeanElements` from the fields of a mean-elements message.

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
