"""Files of element sets, in messages or in lines: which objects they have, and the set of one.

Messages are orbit mean-elements messages of the CCSDS (502.0-B, versions 2 and 3): KVN, XML, JSON
and CSV.
"""

from __future__ import annotations

import csv
import itertools
import json
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Any
from xml.etree import ElementTree

from mgeo_attitude.environment.element_set import MeanElements, TLEOrbit, epoch_of
from mgeo_attitude.environment.ephemeris_formats import Origin
from mgeo_attitude.environment.times import utc_of
from mgeo_attitude.settings.errors import InvalidValue

#: What is understood, of what a message says in words; a table leaves most of it out.
_UNDERSTOOD = {
    "CENTER_NAME": r"|EARTH",
    "REF_FRAME": r"|TEME",
    "TIME_SYSTEM": r"|UTC",
    "MEAN_ELEMENT_THEORY": r"|SGP4|SGP|SGP/SGP4|SGP4/SGP",
    "EPHEMERIS_TYPE": r"|0|2|SGP|SGP4",
}
#: Keys of `MeanElements`, with a message's words for them.
_ELEMENTS = {
    "mean_motion_rev_day": "MEAN_MOTION",
    "eccentricity": "ECCENTRICITY",
    "inclination_deg": "INCLINATION",
    "raan_deg": "RA_OF_ASC_NODE",
    "argument_of_perigee_deg": "ARG_OF_PERICENTER",
    "mean_anomaly_deg": "MEAN_ANOMALY",
    "bstar": "BSTAR",
}

Fields = dict[str, str]


def is_omm(text: str) -> bool:
    """Whether a file's text is of mean-elements messages, in any notation."""
    return bool(re.search(r"\b(CCSDS_OMM_VERS|MEAN_MOTION)\b", text))


def read_omm(text: str) -> list[Fields]:
    """What each message in a text says, by its keywords.

    Raises
    ------
    ValueError
        For a text that is not what its first character promises.
    """
    start = text.lstrip()[:1]
    if start == "<":
        found = list(_xml(text))
    elif start in "[{":
        found = list(_json(text))
    elif re.search(r"^[^\S\n]*(CCSDS_OMM_VERS|MEAN_MOTION)\s*=", text, re.MULTILINE):
        found = list(_kvn(text))
    else:
        found = list(_csv(text))
    return [
        {str(k): "" if v is None else str(v).strip() for k, v in fields.items()} for fields in found
    ]


def elements_of(fields: Mapping[str, str], source: str) -> MeanElements:
    """The element set of a message.

    Raises
    ------
    ValueError
        Naming the keyword, its value and what was expected.
    """
    for key, pattern in _UNDERSTOOD.items():
        value = fields.get(key, "")
        if not re.fullmatch(pattern, value, re.IGNORECASE):
            known = " or ".join(pattern.strip("|").split("|"))
            raise ValueError(f"{key} = {value!r:.60}: expected {known}, as SGP4 propagates")
    for key in ("EPOCH", *_ELEMENTS.values()):
        if not fields.get(key):
            raise ValueError(f"{key}: missing; expected the mean elements of SGP4")
    try:
        return MeanElements(
            source=source,
            epoch=utc_of(fields["EPOCH"]),
            **{name: _number(key, fields[key]) for name, key in _ELEMENTS.items()},
        )
    except InvalidValue as error:
        word = _ELEMENTS.get(error.key, error.key)
        raise ValueError(f"{word} = {error.value!r}: {error.expected}") from None


def _number(key: str, text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise ValueError(f"{key} = {text!r:.60}: expected a number") from None


def _kvn(text: str) -> Iterator[Fields]:
    """Messages one after another, each from its version on; units in brackets are dropped."""
    for message in re.split(r"^(?=[^\S\n]*CCSDS_OMM_VERS)", text, flags=re.MULTILINE):
        pairs = (line.partition("=") for line in message.splitlines() if "=" in line)
        fields = {key.strip(): _without_unit(value) for key, _, value in pairs}
        if fields:
            yield fields


def _without_unit(value: str) -> str:
    # a pattern would look for the end from every bracket
    found = value.rstrip()
    start = found.find("[", found.rfind("]", 0, -1) + 1)
    return found[:start] if found.endswith("]") and start >= 0 else found


def _csv(text: str) -> Iterator[Fields]:
    try:
        yield from csv.DictReader(text.strip().splitlines())
    except csv.Error as error:
        raise ValueError(f"not CSV: {error}") from None


def _json(text: str) -> Iterator[Fields]:
    try:
        found = json.loads(text)
    except RecursionError:
        raise ValueError("not a message: its brackets are nested too deeply") from None
    for fields in found if isinstance(found, list) else [found]:
        if not isinstance(fields, dict):
            raise ValueError(f"{fields!r:.60}: expected a message, or a list of them, in JSON")
        yield fields


def _xml(text: str) -> Iterator[dict[str, Any]]:
    try:
        root = ElementTree.fromstring(text)
    except ElementTree.ParseError as error:
        raise ValueError(f"not XML: {error}") from None
    for segment in root.iterfind(".//{*}segment"):  # in any namespace, or none
        yield {element.tag.rpartition("}")[2]: element.text for element in segment.iter()}


_LISTED = 10  # objects that an error names


@dataclass(frozen=True)
class Entry:
    """An element set as a file has it, not yet checked: whose it is, and from when."""

    name: str
    designator: str
    number: str
    epoch: datetime
    content: dict[str, str]

    def __str__(self) -> str:
        return " ".join(filter(None, (self.name, self.designator, self.number)))

    def is_of(self, wanted: str) -> bool:
        """Whether a name, an international designator or a catalog number means this object."""
        plain = wanted.strip().casefold()
        names = (self.name, self.designator, self.number, _in_digits(self.number))
        return plain in {name.casefold() for name in names} or plain.lstrip("0") == (
            _in_digits(self.number).lstrip("0") or "0"
        )


def is_element_file(text: str) -> bool:
    """Whether a file's text is of element sets: messages, or lines that begin with 1 and 2.

    A comment of an ephemeris may speak of them, too.
    """
    if re.search(r"^[^\S\n]*CCSDS_OEM_VERS\b", text, re.MULTILINE):
        return False
    lines = itertools.pairwise(filter(str.strip, text.splitlines()))
    return is_omm(text) or any(a.startswith("1 ") and b.startswith("2 ") for a, b in lines)


def element_set(text: str, wanted: str, epoch: datetime, origin: Origin) -> TLEOrbit | MeanElements:
    """The set of the wanted object, or of the only one; of several sets the nearest to an epoch.

    `wanted` is a name, an international designator or a catalog number, empty if not said.

    Raises
    ------
    ValueError
        Naming what is wrong in the set, or the objects that there are.
    """
    found = _messages(text) if is_omm(text) else _lines(text)
    fitting = [entry for entry in found if not wanted or entry.is_of(wanted)]
    others = list(dict.fromkeys(f"{entry}" for entry in (fitting or found)))
    if not fitting or len({_identity(entry) for entry in fitting}) > 1:
        said = f"no object {wanted!r}" if wanted else f"{len(others)} objects"
        if fitting and wanted:
            said = f"{len(others)} objects {wanted!r}"
        raise ValueError(f"{said}: expected object, a name or number, of {_listed(others)}")
    entry = min(fitting, key=lambda each: abs(each.epoch - epoch))
    source = origin.of(f"{entry}")
    try:
        if "line1" in entry.content:
            return TLEOrbit(source=source, **entry.content)
        return elements_of(entry.content, source)
    except ValueError as error:
        raise ValueError(f"{entry}: {error}") from None


def _messages(text: str) -> list[Entry]:
    found = []
    for fields in read_omm(text):
        name, designator, number, epoch = (
            fields.get(key, "") for key in ("OBJECT_NAME", "OBJECT_ID", "NORAD_CAT_ID", "EPOCH")
        )
        if not epoch:
            raise ValueError(f"{name or 'a message'}: EPOCH: missing")
        found.append(Entry(name, designator, number, utc_of(epoch), fields))
    if not found:
        raise ValueError("expected a mean-elements message, and there is none")
    return found


def _lines(text: str) -> list[Entry]:
    """Pairs of lines, each perhaps below a line with the object's name."""
    lines = [line.rstrip() for line in text.splitlines()]
    found = []
    for k, (line1, line2) in enumerate(itertools.pairwise(lines)):
        if not (line1.startswith("1 ") and line2.startswith("2 ")):
            continue
        above = lines[k - 1] if k else ""
        name = "" if above.startswith(("1 ", "2 ", "#")) else above.removeprefix("0 ").strip()
        launch = line1[9:17].strip()
        designator = f"{19 + (launch[:2] < '57')}{launch[:2]}-{launch[2:]}" if launch else ""
        entry = {"line1": line1, "line2": line2}
        found.append(Entry(name, designator, line1[2:7].strip(), epoch_of(line1), entry))
    return found


def _identity(entry: Entry) -> str:
    return _in_digits(entry.number) or entry.designator or entry.name


def _in_digits(number: str) -> str:
    """A catalog number of which lines of five columns have the first digits as a letter (alpha-5).

    A stands for 10; the letters I and O are left out.
    """
    letter, rest = number[:1], number[1:]
    k = "ABCDEFGHJKLMNPQRSTUVWXYZ".find(letter) if letter else -1
    return f"{k + 10}{rest}" if k >= 0 and rest.isdigit() else number.lstrip("0")


def _listed(names: Sequence[str]) -> str:
    more = f" and {len(names) - _LISTED} more" if len(names) > _LISTED else ""
    return ", ".join(names[:_LISTED]) + more
