"""Orbit mean-elements messages of the CCSDS (502.0-B, versions 2 and 3): KVN, XML, JSON and CSV."""

from __future__ import annotations

import csv
import json
import re
from collections.abc import Iterator, Mapping
from typing import Any
from xml.etree import ElementTree

from mgeo_attitude.environment.mean_elements import MeanElements
from mgeo_attitude.environment.time_stamps import utc_of
from mgeo_attitude.fields import InvalidValue

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
    elif re.search(r"^\s*(CCSDS_OMM_VERS|MEAN_MOTION)\s*=", text, re.MULTILINE):
        found = list(_kvn(text))
    else:
        found = [dict(row) for row in csv.DictReader(text.strip().splitlines())]
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
    for message in re.split(r"^(?=\s*CCSDS_OMM_VERS)", text, flags=re.MULTILINE):
        pairs = (line.partition("=") for line in message.splitlines() if "=" in line)
        fields = {key.strip(): re.sub(r"\[[^]]*\]\s*$", "", value) for key, _, value in pairs}
        if fields:
            yield fields


def _json(text: str) -> Iterator[Fields]:
    found = json.loads(text)
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
