"""A folder belongs to one study: the tables of another would replace its own, or mix with them."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from mgeo.store.atomic import write_files
from mgeo.store.lock import lock
from mgeo.store.provenance import difference
from mgeo.store.reading import read_json
from mgeo.studies.file import Study
from mgeo.validation import entry, errors_of

OWNER = "study.json"  # problems and algorithms of the study that a folder belongs to
TEXT = "study.toml"


def claim(folder: Path, study: Study) -> None:
    """Make a folder this study's, before it writes tables there; runs belong to anybody.

    It may be so already, also with other seeds or evaluations, and with fewer algorithms or (of
    several) fewer problems: a study may grow.

    Raises
    ------
    ValueError
        If it belongs to another study, with the first difference; nothing is changed then.
    """
    content = _content(study)
    folder.mkdir(parents=True, exist_ok=True)
    with lock(folder):
        check(folder, study)
        write_files(folder, {TEXT: study.text.encode(), OWNER: content})


def check(folder: Path, study: Study) -> None:
    """Refuse a folder that belongs to another study, as `claim` does.

    Raises
    ------
    ValueError
        See `claim`.
    """
    wanted = json.loads(_content(study))
    path = folder / OWNER
    try:
        found = read_json(path)
    except FileNotFoundError:
        return
    with errors_of(path):
        owner = {key: entry(found, key, dict) for key in wanted}
    if text := _difference(owner, wanted):
        raise ValueError(
            f"{folder} belongs to another study: {text}; expected the problems and algorithms "
            f"in its {OWNER}, perhaps with more of them, or another folder"
        )


def _content(study: Study) -> bytes:
    try:
        return (json.dumps(study.configuration(), indent=2, allow_nan=False) + "\n").encode()
    except (TypeError, ValueError) as error:  # an infinity
        raise ValueError(
            f"options or parameters that JSON cannot hold, and so no provenance: {error}"
        ) from error


def _difference(owner: Mapping[str, Any], wanted: Mapping[str, Any]) -> str:
    for key, known in owner.items():
        for label, expected in known.items():
            if label not in wanted[key]:
                return f"{label!r} is not among the {key}"
            if text := difference(expected, wanted[key][label], f"{key}.{label}"):
                return text
    if len(owner["problems"]) == 1 < len(wanted["problems"]):
        return "it has one problem, whose tables are not in a folder below"
    return ""
