"""Monte Carlo results that a problem's own tools leave in a run folder.

Each is a file ``verification*.json``: an object with the strings ``title`` and ``conclusion``, and
a table as ``columns``, a list of strings, and ``rows``, lists of as many numbers or strings. It
says what it is about by the ``problem``'s name, its ``options`` and the ``design``, a list of
numbers as in a row of ``front.csv``. One that is about no solution of the folder's front, as a
front before it may have left, proves nothing here, and is not shown.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import pandas as pd
from pymoo.core.problem import Problem

from mgeo.plugins import protocol
from mgeo.plugins.review import cells
from mgeo.store.provenance import difference
from mgeo.store.reading import read_json
from mgeo.store.run import Run
from mgeo.store.run_folder import ABOUT, VERIFICATION_FILES, check_verification
from mgeo.validation.tables import errors_of

_LONGEST = 200  # characters of a difference, which may quote a whole list


def more_tables(found: Mapping[str, Any]) -> Iterator[tuple[str, list[list[str]]]]:
    """What else it tells in rows, lists of objects with the same keys, by name, titles first."""
    for key, rows in found.items():
        if not (isinstance(rows, list) and rows and all(isinstance(row, dict) for row in rows)):
            continue
        titles = list(rows[0])
        if all(list(row) == titles for row in rows):
            yield key.replace("_", " "), cells(pd.DataFrame(rows, columns=titles))


def verifications(
    folder: Path, run: Run, problem: Problem
) -> Iterator[tuple[str, str, Mapping[str, Any]]]:
    """All results of a folder by name: the file, and why it is ignored, or "" and what it says.

    Raises
    ------
    ValueError
        For a file of another form, naming it.
    """
    options = protocol.options(problem)
    solved = {
        "problem": run.configuration.problem,
        # as a file gives them
        "options": run.configuration.options
        if options is None
        else json.loads(json.dumps(options)),
    }
    solutions = run.outcome.X.tolist()
    for path in sorted(folder.glob(VERIFICATION_FILES)):
        found = read_json(path)
        with errors_of(path):
            check_verification(found)
        missing = [key for key in ABOUT if key not in found]
        why_ignored = ""
        if missing:
            why_ignored = f"it does not say what it is about, its {' and '.join(missing)}"
        elif other := difference(solved, {key: found[key] for key in solved}):
            why_ignored = f"it is about another problem, {other:.{_LONGEST}}"
        elif found["design"] not in solutions:
            why_ignored = "its design is no solution of this front"
        yield path.name, why_ignored, found
