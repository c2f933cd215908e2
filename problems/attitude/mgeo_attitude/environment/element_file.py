"""Files of element sets, in messages or in lines: which objects they have, and the set of one."""

from __future__ import annotations

import itertools
import re
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime

from mgeo_attitude.environment.mean_elements import MeanElements
from mgeo_attitude.environment.omm import elements_of, is_omm, read_omm
from mgeo_attitude.environment.segment import Origin
from mgeo_attitude.environment.time_stamps import utc_of
from mgeo_attitude.environment.tle import TLEOrbit, epoch_of

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
    if re.search(r"^\s*CCSDS_OEM_VERS\b", text, re.MULTILINE):
        return False
    return is_omm(text) or bool(re.search(r"^1 .+\s*\n2 ", text, re.MULTILINE))


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
